#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "ceres/ceres.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Response = Eigen::Ref<const Eigen::VectorXd>;

constexpr double kLeastSopdtDamping = 0.01;
constexpr double kMostSopdtDamping = 20.0;
constexpr double kCritical = 1e-7;     // |ζ² − 1| that is taken as 0
constexpr double kDampingStep = 1e-5;  // of ln ζ, for the derivative
constexpr int kSopdtTimeConstants = 20;
constexpr int kSopdtDelays = 4;
constexpr int kGridPoints = 150;  // of the response
constexpr int kStarts = 3;
constexpr int kMaxIterations = 100;

// Time in samples.
struct Parameters {
  double gain = 0.0;
  double time_constant = 1.0;
  double damping = 1.0;
  double delay = 0.0;
  double squares = std::numeric_limits<double>::infinity();
};

struct StepValue {
  double value = 0.0;  // φ
  double slope = 0.0;  // ∂φ/∂x
};

StepValue UnitStep(double x, double damping) {
  if (!(x > 0.0)) return {};
  const double square = damping * damping - 1.0;
  if (std::abs(square) < kCritical) {
    const double decay = std::exp(-x);
    return {1.0 - (1.0 + x) * decay, x * decay};
  }
  const double w = std::sqrt(std::abs(square));
  if (square < 0.0) {
    const double decay = std::exp(-damping * x);
    const double sine = std::sin(w * x) / w;
    return {1.0 - decay * (std::cos(w * x) + damping * sine), decay * sine};
  }
  // Poles −r₁ and −r₂ with r₁ r₂ = 1.
  const double fast = damping + w;
  const double slow = 1.0 / fast;
  const double of_slow = std::exp(-slow * x);
  const double of_fast = std::exp(-fast * x);
  return {1.0 - (fast * of_slow - slow * of_fast) / (2.0 * w),
          (of_slow - of_fast) / (2.0 * w)};
}

// Residuals of the fit, and derivatives by K, ln T, ln ζ and L where wanted.
class SopdtCost : public ceres::CostFunction {
 public:
  explicit SopdtCost(const Response& response) : response_(response) {
    set_num_residuals(static_cast<int>(response.size()));
    *mutable_parameter_block_sizes() = {4};
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    const double gain = x[0][0];
    const double time_constant = std::exp(x[0][1]);
    const double damping = std::exp(x[0][2]);
    const double delay = x[0][3];
    double* rows = jacobians != nullptr ? jacobians[0] : nullptr;
    for (Index k = 0; k < response_.size(); ++k) {
      const double at = (static_cast<double>(k) - delay) / time_constant;
      const StepValue step = UnitStep(at, damping);
      residuals[k] = gain * step.value - response_(k);
      if (rows == nullptr) continue;
      const double up = UnitStep(at, damping * std::exp(kDampingStep)).value;
      const double down = UnitStep(at, damping * std::exp(-kDampingStep)).value;
      rows[4 * k] = step.value;
      rows[4 * k + 1] = -gain * step.slope * at;
      rows[4 * k + 2] = gain * (up - down) / (2.0 * kDampingStep);
      rows[4 * k + 3] = -gain * step.slope / time_constant;
    }
    return true;
  }

 private:
  Response response_;
};

// The best gain, and the squares that it leaves, of every `stride`th sample.
void SolveGain(const Response& response, Index stride, Parameters& parameters) {
  double inner = 0.0;
  double square = 0.0;
  double total = 0.0;
  for (Index k = 0; k < response.size(); k += stride) {
    const double value = UnitStep((static_cast<double>(k) - parameters.delay) /
                                      parameters.time_constant,
                                  parameters.damping)
                             .value;
    inner += value * response(k);
    square += value * value;
    total += response(k) * response(k);
  }
  parameters.gain = square > 0.0 ? inner / square : 0.0;
  parameters.squares = total - parameters.gain * inner;
}

// The best points of the grid, the best first; of neighbours in T and L, one.
std::vector<Parameters> Starts(const Response& response, double max_delay) {
  const auto samples = static_cast<double>(response.size() - 1);
  const Index stride = std::max<Index>(1, response.size() / kGridPoints);
  std::vector<Parameters> best;
  for (const double damping : {0.05, 0.15, 0.4, 0.8, 1.3, 3.0}) {
    Parameters of_damping;
    for (int t = 0; t < kSopdtTimeConstants; ++t) {
      for (int l = 0; l < kSopdtDelays; ++l) {
        Parameters candidate;
        candidate.damping = damping;
        candidate.time_constant =
            0.3 * std::pow(samples / 0.6, t / double{kSopdtTimeConstants - 1});
        candidate.delay = max_delay * l / double{kSopdtDelays - 1};
        SolveGain(response, stride, candidate);
        if (candidate.squares < of_damping.squares) of_damping = candidate;
      }
    }
    best.push_back(of_damping);
  }
  std::sort(best.begin(), best.end(),
            [](const Parameters& a, const Parameters& b) {
              return a.squares < b.squares;
            });
  best.resize(kStarts);
  return best;
}

Parameters RefinedSopdt(const Response& response, double max_delay,
                        const Parameters& start) {
  double x[] = {start.gain, std::log(start.time_constant),
                std::log(start.damping), start.delay};
  ceres::Problem problem;
  problem.AddResidualBlock(new SopdtCost(response), nullptr, x);
  const auto samples = static_cast<double>(response.size());
  problem.SetParameterLowerBound(x, 1, std::log(0.05));
  problem.SetParameterUpperBound(x, 1, std::log(100.0 * samples));
  problem.SetParameterLowerBound(x, 2, std::log(kLeastSopdtDamping));
  problem.SetParameterUpperBound(x, 2, std::log(kMostSopdtDamping));
  problem.SetParameterLowerBound(x, 3, 0.0);
  problem.SetParameterUpperBound(x, 3, std::max(max_delay, 1e-9));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return start;
  Parameters refined = {x[0], std::exp(x[1]), std::exp(x[2]), x[3]};
  refined.squares = 2.0 * summary.final_cost;
  return refined;
}

absl::Status CheckArguments(const Response& response, double sample_time,
                            double max_delay) {
  MLE_RETURN_IF_ERROR(
      ValidateSampleTime("SOPDT fit: sample_time", sample_time));
  if (!(max_delay >= 0.0) || !std::isfinite(max_delay)) {
    return absl::InvalidArgumentError(
        absl::StrCat("SOPDT fit: max_delay is ", max_delay,
                     ", must be finite and at least 0"));
  }
  if (response.size() < 10 || !response.allFinite() || response.isZero(0.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("SOPDT fit: the step response has ", response.size(),
                     " samples; it must have at least 10, all finite and not "
                     "all 0"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SopdtFit> FitSopdt(const Response& step_response,
                                  double sample_time, double max_delay) {
  MLE_RETURN_IF_ERROR(CheckArguments(step_response, sample_time, max_delay));
  // In units of the largest value, and of samples; three see the response.
  const double scale = step_response.cwiseAbs().maxCoeff();
  const VectorXd response = step_response / scale;
  const double longest = std::min(
      max_delay / sample_time, static_cast<double>(step_response.size() - 4));
  Parameters best;
  for (const Parameters& start : Starts(response, longest)) {
    const Parameters refined = RefinedSopdt(response, longest, start);
    if (refined.squares < best.squares) best = refined;
  }
  double largest = 0.0;
  for (Index k = 0; k < response.size(); ++k) {
    const StepValue step =
        UnitStep((static_cast<double>(k) - best.delay) / best.time_constant,
                 best.damping);
    largest = std::max(largest, std::abs(best.gain * step.value - response(k)));
  }
  const double range =
      std::max(response.maxCoeff(), 0.0) - std::min(response.minCoeff(), 0.0);
  return SopdtFit{.gain = scale * best.gain,
                  .time_constant = sample_time * best.time_constant,
                  .damping = best.damping,
                  .delay = sample_time * best.delay,
                  .largest_difference = largest / range};
}

}  // namespace mle
