#include "mle/exchange/description.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Cholesky"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/model/element_response.h"
#include "mle/model/transfer_function.h"
#include "mle/nonlinear/low_order_fit.h"
#include "mle/nonlinear/rational_fit.h"

namespace mle {
namespace {

// An integrator with lag and dead time,
//
//   K e^{−Ls} / (s (T s + 1)),
//
// whose step response is nearest (least squares) to samples h_k that end in a
// ramp, by Levenberg and Marquardt's steps from several starts.

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

// `response` (N + 1) is h_0 = 0, h_1, … at the interval Δ; L ≤ N Δ, and
// L ≥ `least_delay`, which may be negative as far as it is no bound.
// InvalidArgument where the response has no slope at its end, or ends before a
// ramp can begin.
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

// The same with what it misses, which settles, as a sum of lags behind the same
// dead time (rational_fit.h): (K/s + R(s)) e^{−Ls}.
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

// Difference, relative to near_range_, with which no further shape is tried.
constexpr double kNear = 2e-3;
// A ramp counts over this many times the sum of its dead time and lag.
constexpr double kRampOver = 10.0;
// A further shape is taken if it leaves less than this share of the root mean
// square of a simpler one. Five lags fitted to noise leave nine tenths.
constexpr double kMaterial = 0.75;
// A response that exceeds this share of its range is past its dead time.
constexpr double kOnset = 0.05;
constexpr double kRationalTolerance = 1e-3;

struct Candidate {
  TransferFunction element;
  PairDescription found;
};

class PairFit {
 public:
  // `response` is h(0) = 0, c_1, … c_N, and goes on as a ramp or not.
  PairFit(Eigen::VectorXd response, bool ramp, double interval)
      : response_(std::move(response)), ramp_(ramp), interval_(interval) {
    const double range = RangeOf(response_);
    if (range > 0.0) exponent_ = std::ilogb(range);
    for (double& value : response_) value = std::ldexp(value, -exponent_);
    range_ = near_range_ = RangeOf(response_);
    best_.found.relative_rms = std::numeric_limits<double>::infinity();
    best_.found.largest_difference = std::numeric_limits<double>::infinity();
  }

  absl::StatusOr<Candidate> Fit() {
    MLE_RETURN_IF_ERROR(ramp_ ? FitRamp() : FitScaled());
    if (!ramp_ && range_ > 0.0) {
      best_.found.moves_on = std::abs(best_.element.StaticGain() -
                                      response_(response_.size() - 1)) /
                             range_;
    }
    std::vector<double> numerator = best_.element.numerator();
    for (double& value : numerator) value = std::ldexp(value, exponent_);
    best_.element =
        TransferFunction(std::move(numerator), best_.element.denominator(),
                         best_.element.delay());
    return best_;
  }

 private:
  absl::Status FitScaled();
  absl::Status FitRamp();
  bool Try(TransferFunction element);
  // The first sample whose size is more than `share` of the range.
  int FirstAbove(double share) const;

  Eigen::VectorXd response_;
  bool ramp_;
  double interval_;
  double range_ = 0.0;
  double near_range_ = 0.0;  // what kNear is of
  int exponent_ = 0;  // of the scale, a power of two: fits are to values near 1
  Candidate best_;
};

// Whether the best is near enough to stop.
bool PairFit::Try(TransferFunction element) {
  if (!element.Validate().ok()) return false;
  const Eigen::VectorXd difference =
      element.StepResponse(interval_, static_cast<int>(response_.size())) -
      response_;
  Eigen::Index at = 0;
  PairDescription found;
  found.largest_difference = difference.cwiseAbs().maxCoeff(&at) / range_;
  found.relative_rms = difference.norm() / std::sqrt(response_.size()) / range_;
  found.time = static_cast<double>(at) * interval_;
  if (found.relative_rms < kMaterial * best_.found.relative_rms) {
    best_ = {std::move(element), found};
  }
  return best_.found.largest_difference * range_ <= kNear * near_range_;
}

int PairFit::FirstAbove(double share) const {
  int k = 0;
  while (!(std::abs(response_(k)) > share * range_)) ++k;
  return k;
}

absl::Status PairFit::FitScaled() {
  if (!(range_ > 0.0)) {
    best_ = Candidate();
    return absl::OkStatus();
  }
  // h(L) = 0, so that a response that is first seen at kΔ has L ≥ (k − 1) Δ.
  const double least_delay = (FirstAbove(0.0) - 1) * interval_;
  const double most_delay =
      std::max(FirstAbove(kOnset) * interval_, least_delay);
  if (Try(TransferFunction({response_(response_.size() - 1)}, {1.0},
                           least_delay))) {
    return absl::OkStatus();
  }
  FopdtOptions first_order;
  first_order.negligible_response = 0.0;
  MLE_ASSIGN_OR_RETURN(const FopdtFit fopdt,
                       FitFopdt(response_, interval_, first_order));
  if (fopdt.time_constant > 0.0 &&
      Try(TransferFunction::FirstOrder(fopdt.gain, fopdt.time_constant,
                                       fopdt.delay))) {
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const SopdtFit sopdt,
                       FitSopdt(response_, interval_, most_delay));
  const double t = sopdt.time_constant;
  if (Try(TransferFunction({sopdt.gain}, {t * t, 2.0 * sopdt.damping * t, 1.0},
                           sopdt.delay))) {
    return absl::OkStatus();
  }
  RationalOptions rational;
  rational.min_delay = least_delay;
  rational.max_delay = most_delay;
  rational.tolerance = kRationalTolerance;
  MLE_ASSIGN_OR_RETURN(const RationalFit lags,
                       FitRational(response_, interval_, rational));
  Try(lags.element);
  return absl::OkStatus();
}

absl::Status PairFit::FitRamp() {
  const double least_delay =
      range_ > 0.0 ? (FirstAbove(0.0) - 1) * interval_ : 0.0;
  MLE_ASSIGN_OR_RETURN(const TransferFunction lag,
                       FitIntegratingPair(response_, interval_, least_delay));
  // However long the ramp is, what begins it is to be told.
  const double begin = std::max(lag.delay() + lag.TimeConstant(), interval_);
  near_range_ =
      std::min(range_, kRampOver * begin * std::abs(lag.StaticGain()));
  // Without the lag the ramp begins later by it.
  if (Try(TransferFunction::Integrator(lag.StaticGain(), 0.0,
                                       lag.delay() + lag.TimeConstant())) ||
      Try(lag)) {
    return absl::OkStatus();
  }
  // With the slope of the last tenth, and with that of the fit.
  const Eigen::Index last = response_.size() - 1;
  const Eigen::Index tenth = std::max<Eigen::Index>(last / 10, 1);
  const double slope = (response_(last) - response_(last - tenth)) /
                       (static_cast<double>(tenth) * interval_);
  for (const TransferFunction& ramp :
       {TransferFunction::Integrator(slope, 0.0, std::max(least_delay, 0.0)),
        lag}) {
    const auto lags =
        FitIntegratingLags(response_, interval_, ramp, kRationalTolerance);
    if (lags.ok() && Try(*lags)) break;
  }
  return absl::OkStatus();
}

absl::Status CheckDifferences(const Description& description,
                              const StepResponseModel& model) {
  std::vector<std::string> poor;
  for (const PairDescription& pair : description.pairs) {
    if (!(pair.moves_on <= kAcceptedMovingOn)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "%s: its step response has not settled at the last coefficient; the "
          "transfer function through it goes on from there by %.3g %% of the "
          "range. Give more coefficients, or say that the pair ends in a ramp",
          PairName(model.channels, pair.output, pair.input),
          100.0 * pair.moves_on));
    }
    if (pair.largest_difference <= kAcceptedDifference) continue;
    poor.push_back(DifferenceText(model.channels, pair));
  }
  if (poor.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "no transfer function of low order is near enough to these step "
      "responses (at most %.3g %% of the range): %s; smooth them, or leave the "
      "pairs out",
      100.0 * kAcceptedDifference, absl::StrJoin(poor, "; ")));
}

}  // namespace

double RangeOf(const Eigen::VectorXd& response) {
  return std::max(response.maxCoeff(), 0.0) -
         std::min(response.minCoeff(), 0.0);
}

absl::StatusOr<Description> Describe(const StepResponseModel& model) {
  const auto pairs = static_cast<int>(model.pairs.size());
  std::vector<absl::StatusOr<Candidate>> fits(pairs, Candidate());
  ParallelFor(pairs, 0, [&](int p) {
    Eigen::VectorXd response(model.length() + 1);
    response << 0.0, model.pairs[p].coefficients;
    fits[p] =
        PairFit(std::move(response), model.pairs[p].is_ramp, model.interval)
            .Fit();
  });
  Description description;
  description.process = model.channels;
  for (int p = 0; p < pairs; ++p) {
    const PairResponse& pair = model.pairs[p];
    if (!fits[p].ok()) {
      return InvalidArgument(PairName(model.channels, pair.output, pair.input),
                             ": ", fits[p].status().message());
    }
    PairDescription found = fits[p]->found;
    found.output = pair.output;
    found.input = pair.input;
    description.process.element(pair.output, pair.input) = fits[p]->element;
    description.pairs.push_back(found);
  }
  MLE_RETURN_IF_ERROR(CheckDifferences(description, model));
  return description;
}

std::string DifferenceText(const ProcessModel& channels,
                           const PairDescription& pair) {
  return absl::StrFormat("%s: %.3g %% of its range at %.6g %s",
                         PairName(channels, pair.output, pair.input),
                         100.0 * pair.largest_difference, pair.time,
                         channels.time_unit());
}

}  // namespace mle
