#include "mle/nonlinear/sopdt_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "ceres/ceres.h"
#include "mle/base/status.h"
#include "mle/nonlinear/unit_errors.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Response = Eigen::Ref<const VectorXd>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kGridTimes = 16;
// Time constants closer than this (relatively) are taken as equal; h then errs
// by the square of it.
constexpr double kEqualTimes = 1e-5;

// h(s) for K = 1.
template <typename T>
T UnitResponse(const T& s, const T& first, const T& second) {
  using std::exp;
  if (!(s > T(0.0))) return T(0.0);
  const T difference = first - second;
  if (difference < kEqualTimes * first && -difference < kEqualTimes * first) {
    const T mean = 0.5 * (first + second);
    return 1.0 - (1.0 + s / mean) * exp(-s / mean);
  }
  return 1.0 -
         (first * exp(-s / first) - second * exp(-s / second)) / difference;
}

// Parameters K, ln T₁, ln T₂, L; time in samples.
using Parameters = std::array<double, 4>;

struct SopdtResidual {
  const Response& response;

  template <typename T>
  bool operator()(T const* const* x, T* residuals) const {
    using std::exp;
    const T first = exp(x[0][1]);
    const T second = exp(x[0][2]);
    for (Eigen::Index k = 0; k < response.size(); ++k) {
      residuals[k] = x[0][0] * UnitResponse(T(static_cast<double>(k)) - x[0][3],
                                            first, second) -
                     response(k);
    }
    return true;
  }
};

struct Bounds {
  double min_log = 0.0;  // of ln T
  double max_log = 0.0;
  double max_delay = 0.0;
};

struct Candidate {
  double explained = -kInfinity;
  Parameters parameters{};
};

// The best gain and dead time for each pair of time constants, best first.
std::vector<Candidate> SearchGrid(const Response& y, const Bounds& bounds) {
  const Eigen::Index n = y.size();
  const double step = (bounds.max_log - bounds.min_log) / (kGridTimes - 1);
  std::vector<Candidate> candidates;
  VectorXd unit(n);
  for (int a = 0; a < kGridTimes; ++a) {
    for (int b = 0; b <= a; ++b) {
      const double log_first = bounds.min_log + a * step;
      const double log_second = bounds.min_log + b * step;
      for (Eigen::Index k = 0; k < n; ++k) {
        unit(k) = UnitResponse(static_cast<double>(k), std::exp(log_first),
                               std::exp(log_second));
      }
      Candidate best;
      for (int delay = 0; delay <= bounds.max_delay; ++delay) {
        const Eigen::Index left = n - delay;
        const double product = unit.head(left).dot(y.tail(left));
        const double norm = unit.head(left).squaredNorm();
        if (!(norm > 0.0) || product * product / norm <= best.explained) {
          continue;
        }
        best.explained = product * product / norm;
        best.parameters = {product / norm, log_first, log_second,
                           static_cast<double>(delay)};
      }
      candidates.push_back(best);
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& p, const Candidate& q) {
              return p.explained > q.explained;
            });
  return candidates;
}

struct Refined {
  Parameters parameters{};
  double cost = kInfinity;
  FopdtTermination termination = FopdtTermination::kFailed;
  int iterations = 0;
  MatrixXd jacobian;  // n × 4
};

Refined Refine(const Response& response, Parameters x, const Bounds& bounds,
               int max_iterations) {
  auto* cost = new ceres::DynamicAutoDiffCostFunction<SopdtResidual>(
      new SopdtResidual{response});
  cost->AddParameterBlock(4);
  cost->SetNumResiduals(static_cast<int>(response.size()));
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, x.data());
  for (const int index : {1, 2}) {
    problem.SetParameterLowerBound(x.data(), index, bounds.min_log);
    problem.SetParameterUpperBound(x.data(), index, bounds.max_log);
  }
  problem.SetParameterLowerBound(x.data(), 3, 0.0);
  problem.SetParameterUpperBound(x.data(), 3, std::max(bounds.max_delay, 1e-9));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-16;
  options.parameter_tolerance = 1e-13;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  Refined refined;
  refined.iterations = static_cast<int>(summary.iterations.size());
  if (!summary.IsSolutionUsable()) return refined;
  refined.termination = summary.termination_type == ceres::NO_CONVERGENCE
                            ? FopdtTermination::kIterationLimit
                            : FopdtTermination::kConverged;
  refined.parameters = x;
  refined.cost = summary.final_cost;
  ceres::CRSMatrix rows;
  problem.Evaluate({}, nullptr, nullptr, nullptr, &rows);
  refined.jacobian = Eigen::Map<
      const Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>>(
      rows.values.data(), rows.num_rows, 4);
  return refined;
}

SopdtFit MakeFit(const Response& response, const Refined& refined, double scale,
                 double sample_time) {
  Parameters x = refined.parameters;
  Eigen::Vector4d unit = UnitErrors(refined.jacobian);
  if (x[1] < x[2]) {
    std::swap(x[1], x[2]);
    std::swap(unit(1), unit(2));
  }
  const double n = static_cast<double>(response.size());
  // The first sample is 0 in any model and says nothing.
  const double deviation =
      std::sqrt(2.0 * refined.cost / std::max(n - 1.0 - 4.0, 1.0));
  const auto error = [&](int index, double size) {
    return std::isinf(unit(index)) ? kInfinity : size * deviation * unit(index);
  };
  SopdtFit fit;
  fit.gain = scale * x[0];
  fit.time_constant = sample_time * std::exp(x[1]);
  fit.second_time_constant = sample_time * std::exp(x[2]);
  fit.delay = sample_time * x[3];
  fit.gain_standard_error = error(0, scale);
  fit.time_constant_standard_error = error(1, fit.time_constant);
  fit.second_time_constant_standard_error = error(2, fit.second_time_constant);
  fit.delay_standard_error = error(3, sample_time);
  double largest = 0.0;
  for (Eigen::Index k = 0; k < response.size(); ++k) {
    const double h = x[0] * UnitResponse(static_cast<double>(k) - x[3],
                                         std::exp(x[1]), std::exp(x[2]));
    largest = std::max(largest, std::abs(h - response(k)));
  }
  const double range =
      std::max(response.maxCoeff(), 0.0) - std::min(response.minCoeff(), 0.0);
  fit.relative_rms = std::sqrt(2.0 * refined.cost / n) / range;
  fit.relative_max_residual = largest / range;
  fit.termination = refined.termination;
  return fit;
}

const char* ResponseName(ResponseShape shape) {
  switch (shape) {
    case ResponseShape::kSettling:
      return "settling";
    case ResponseShape::kNoResponse:
      return "no response";
    case ResponseShape::kIntegrating:
      return "integrating";
    case ResponseShape::kInverse:
      return "inverse response";
  }
  return "unknown";
}

}  // namespace

ResponseShape ClassifyResponse(const Response& step_response,
                               double negligible_response) {
  const Response& y = step_response;
  const Eigen::Index n = y.size();
  const double size = n == 0 ? 0.0 : y.cwiseAbs().maxCoeff();
  if (size == 0.0 || size <= negligible_response) {
    return ResponseShape::kNoResponse;
  }
  const double range =
      std::max(y.maxCoeff(), 0.0) - std::min(y.minCoeff(), 0.0);
  // Means of the ends of the quarters, so that a noisy sample decides nothing.
  const Eigen::Index quarter = std::max<Eigen::Index>(n / 4, 1);
  const Eigen::Index width = std::max<Eigen::Index>(n / 50, 1);
  const auto level = [&](Eigen::Index end) {
    const Eigen::Index begin = std::max<Eigen::Index>(end - width, 0);
    return y.segment(begin, std::max<Eigen::Index>(end - begin, 1)).mean();
  };
  const double last = level(n) - level(n - quarter);
  const double before = level(n - quarter) - level(n - 2 * quarter);
  if (std::abs(last) > 0.2 * range && last * before > 0.0 &&
      std::abs(last) > 0.5 * std::abs(before)) {
    return ResponseShape::kIntegrating;
  }
  const double other_side = level(n) >= 0.0 ? -std::min(y.minCoeff(), 0.0)
                                            : std::max(y.maxCoeff(), 0.0);
  return other_side > 0.05 * range ? ResponseShape::kInverse
                                   : ResponseShape::kSettling;
}

TransferFunction SopdtFit::ToTransferFunction() const {
  if (shape == FopdtShape::kNoResponse || gain == 0.0) {
    return TransferFunction();
  }
  return TransferFunction({gain},
                          {time_constant * second_time_constant,
                           time_constant + second_time_constant, 1.0},
                          delay);
}

std::string SopdtFit::BriefReport() const {
  return absl::StrCat("SOPDT fit: K ", gain, ", T ", time_constant, " and ",
                      second_time_constant, ", L ", delay, ", residual ",
                      100.0 * relative_rms, " % of the range, ",
                      ResponseName(response),
                      shape == FopdtShape::kFits ? ", fits" : ", poor fit");
}

absl::StatusOr<SopdtFit> FitSopdt(const Response& step_response,
                                  double sample_time,
                                  const FopdtOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "SOPDT fit: sample_time is ", sample_time, ", must be positive"));
  }
  if (step_response.size() < 6) {
    return absl::InvalidArgumentError(
        absl::StrCat("SOPDT fit: the step response has ", step_response.size(),
                     " samples, must have at least 6"));
  }
  for (Eigen::Index k = 0; k < step_response.size(); ++k) {
    if (!std::isfinite(step_response(k))) {
      return absl::InvalidArgumentError(absl::StrCat(
          "SOPDT fit: sample ", k, " of the step response is not finite"));
    }
  }
  SopdtFit fit;
  fit.response = ClassifyResponse(step_response, options.negligible_response);
  if (fit.response == ResponseShape::kNoResponse) {
    fit.shape = FopdtShape::kNoResponse;
    fit.termination = FopdtTermination::kConverged;
    fit.gain_standard_error = 0.0;
    fit.relative_rms = 0.0;
    fit.relative_max_residual = 0.0;
    return fit;
  }
  const double scale = step_response.cwiseAbs().maxCoeff();
  const VectorXd response = step_response / scale;
  const Response view(response);
  const double last = static_cast<double>(response.size() - 1);
  const Bounds bounds = {
      .min_log = std::log(options.min_time_constant_samples),
      .max_log = std::log(options.max_time_constant_horizons * last),
      .max_delay = std::min(options.max_delay / sample_time, last - 4.0)};
  const std::vector<Candidate> candidates = SearchGrid(view, bounds);
  Refined best;
  int iterations = 0;
  for (int i = 0;
       i < std::min(options.num_starts, static_cast<int>(candidates.size()));
       ++i) {
    Refined refined =
        Refine(view, candidates[i].parameters, bounds, options.max_iterations);
    iterations += refined.iterations;
    if (refined.cost < best.cost) best = std::move(refined);
  }
  fit.iterations = iterations;
  if (best.termination == FopdtTermination::kFailed) {
    fit.termination = FopdtTermination::kFailed;
    return fit;
  }
  const ResponseShape shape = fit.response;
  fit = MakeFit(view, best, scale, sample_time);
  fit.response = shape;
  fit.iterations = iterations;
  const bool poor =
      shape != ResponseShape::kSettling ||
      fit.relative_rms > options.poor_relative_rms ||
      fit.relative_max_residual > options.poor_relative_residual ||
      !(fit.gain_standard_error < std::abs(fit.gain));
  fit.shape = poor ? FopdtShape::kPoorFit : FopdtShape::kFits;
  return fit;
}

}  // namespace mle
