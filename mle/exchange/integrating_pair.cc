#include "mle/exchange/integrating_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "mle/base/status.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/rational_fit.h"

namespace mle {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kSteps = 100;
constexpr double kConverged = 1e-12;  // of the squares
// Starting values of T, as shares of the time from the least dead time to where
// the ramp would begin; L is the rest of the time until then.
constexpr std::array<double, 4> kStarts = {0.02, 0.3, 0.7, 0.95};

// Dead times that are tried: later than the response nothing is seen of them.
struct Delays {
  double least = 0.0;
  double most = 0.0;
};

// K, ln T and L.
struct Values {
  double gain = 0.0;
  double log_time = 0.0;
  double delay = 0.0;

  Values Moved(const Vector3d& step, const Delays& delays) const {
    return {gain + step(0), log_time + std::clamp(step(1), -1.0, 1.0),
            std::clamp(delay + step(2), delays.least, delays.most)};
  }
};

// n rows: the response of K = 1, its derivatives by ln T and L.
MatrixXd RespondToSteps(const ElementResponse& element, const Values& values,
                        double interval, Eigen::Index samples) {
  const double delay = values.delay / interval;
  const auto whole = static_cast<int>(delay);
  MatrixXd columns(samples, 3);
  element.Simulate(std::exp(values.log_time), interval, {whole, delay - whole},
                   VectorXd::Ones(samples), 0.0, columns);
  return columns;
}

}  // namespace

absl::StatusOr<TransferFunction> FitIntegratingPair(const VectorXd& response,
                                                    double interval,
                                                    double least_delay) {
  const Eigen::Index n = response.size();
  const double last = response(n - 1);
  const double slope = (last - response(n - 2)) / interval;
  if (slope == 0.0 || !std::isfinite(slope)) {
    return absl::InvalidArgumentError("it ends in a ramp without a slope");
  }
  const double end = static_cast<double>(n - 1) * interval;
  const Delays delays = {std::max(least_delay, 0.0), end};
  if (!(delays.least + 0.1 * interval <= end) || !std::isfinite(end)) {
    return absl::InvalidArgumentError("it ends before its ramp can begin");
  }
  // Where the line of the last interval meets zero.
  const double begin =
      std::clamp(end - last / slope, delays.least + 0.1 * interval, end);
  MLE_ASSIGN_OR_RETURN(
      const ElementResponse element,
      ElementResponse::Create(TransferFunction::Integrator(1.0, 1.0, 0.0)));
  Values best;
  double least = std::numeric_limits<double>::infinity();
  for (const double share : kStarts) {
    const double lag = share * (begin - delays.least);
    Values values = {slope, std::log(lag), begin - lag};
    MatrixXd columns = RespondToSteps(element, values, interval, n);
    VectorXd rest = response - values.gain * columns.col(0);
    double damping = 1e-3;
    for (int step = 0; step < kSteps; ++step) {
      MatrixXd jacobian = columns;
      jacobian.rightCols(2) *= values.gain;
      const Matrix3d normal = jacobian.transpose() * jacobian;
      Matrix3d damped = normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-300;
      const Vector3d change = damped.ldlt().solve(jacobian.transpose() * rest);
      if (!change.allFinite()) break;
      const Values moved = values.Moved(change, delays);
      const MatrixXd trial = RespondToSteps(element, moved, interval, n);
      const VectorXd left = response - moved.gain * trial.col(0);
      const double before = rest.squaredNorm();
      if (!(left.squaredNorm() < before)) {
        damping *= 10.0;
        if (damping > 1e12) break;
        continue;
      }
      values = moved;
      columns = trial;
      rest = left;
      damping = std::max(0.1 * damping, 1e-12);
      if (before - rest.squaredNorm() < kConverged * before) break;
    }
    if (rest.squaredNorm() < least) {
      least = rest.squaredNorm();
      best = values;
    }
  }
  return TransferFunction::Integrator(best.gain, std::exp(best.log_time),
                                      best.delay);
}

absl::StatusOr<TransferFunction> FitIntegratingLags(
    const VectorXd& response, double interval, const TransferFunction& nearest,
    double tolerance) {
  const double gain = nearest.StaticGain();
  RationalOptions options;
  options.min_delay = options.max_delay = nearest.delay();
  options.tolerance = tolerance;
  MLE_ASSIGN_OR_RETURN(
      const RationalFit fit,
      FitRational(
          response -
              TransferFunction::Integrator(gain, 0.0, nearest.delay())
                  .StepResponse(interval, static_cast<int>(response.size())),
          interval, options));
  // (K/s + b/a) = (K a + s b)/(s a).
  std::vector<double> numerator = fit.element.denominator();
  for (double& c : numerator) c *= gain;
  const std::vector<double>& b = fit.element.numerator();
  for (std::size_t k = 0; k < b.size(); ++k) {
    // b is of lower degree than a.
    numerator[numerator.size() - 2 - k] += b[b.size() - 1 - k];
  }
  std::vector<double> denominator = fit.element.denominator();
  denominator.push_back(0.0);
  return TransferFunction(std::move(numerator), std::move(denominator),
                          fit.element.delay());
}

}  // namespace mle
