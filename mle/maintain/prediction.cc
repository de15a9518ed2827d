#include "mle/maintain/prediction.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/line.h"
#include "mle/maintain/channel_scales.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/innovations_filter.h"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Range of log10 q/r: below, a level does not move within a record; above, it
// is all that moves.
constexpr double kLeastLogRatio = -8.0;
constexpr double kLargestLogRatio = 6.0;

// Removes the mean of the finite values.
void Centre(Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> values) {
  double sum = 0.0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  if (count > 0) values.array() -= sum / count;
}

// A level with a constant slope, neither of which is known at first, in white
// noise (variance 1) and with a random walk (variance `ratio` a sample), by its
// Kalman filter.
class SlopedLevel {
 public:
  explicit SlopedLevel(double ratio) : ratio_(ratio) {}

  bool known() const { return measured_ >= 2; }
  // At `samples` after the last Advance().
  double After(double samples) const { return level_ + samples * slope_; }
  void Advance() {
    ++since_;
    if (!known()) return;
    level_ += slope_;
    P_ += 2.0 * C_ + S_ + ratio_;
    C_ += S_;
  }
  void Measure(double value) {
    if (measured_ == 0) {
      level_ = value;
      since_ = 0;
    } else if (measured_ == 1) {
      // The level is as good as its last value, the slope as both.
      const auto d = static_cast<double>(since_);
      slope_ = (value - level_) / d;
      level_ = value;
      P_ = 1.0;
      C_ = 1.0 / d;
      S_ = (2.0 + ratio_ * d) / (d * d);
    } else {
      const double F = P_ + 1.0;
      const double innovation = value - level_;
      const double gain = P_ / F;
      const double slope_gain = C_ / F;
      level_ += gain * innovation;
      slope_ += slope_gain * innovation;
      S_ -= slope_gain * C_;
      C_ -= slope_gain * P_;
      P_ = gain;
    }
    ++measured_;
  }

 private:
  double ratio_;
  int measured_ = 0;
  int since_ = 0;
  double level_ = 0.0;
  double slope_ = 0.0;
  double P_ = 0.0;  // Var level
  double C_ = 0.0;  // Cov
  double S_ = 0.0;  // Var slope
};

// LevelErrors() of an integrating output.
Eigen::RowVectorXd SlopedErrors(const Eigen::RowVectorXd& e, double ratio,
                                int first, int horizon) {
  const int n = static_cast<int>(e.size());
  Eigen::RowVectorXd errors = Eigen::RowVectorXd::Constant(n, kNaN);
  if (horizon == 0) {
    errors.tail(n - first) = e.tail(n - first);
    return WithoutLine(errors.transpose()).transpose();
    return errors;
  }
  SlopedLevel level(ratio);
  SlopedLevel start(ratio);  // from which predictions run
  int begin = first;
  for (int k = first; k < n; ++k) {
    if ((k - first) % horizon == 0) {
      start = level;
      begin = k;
    }
    if (start.known()) errors(k) = e(k) - start.After(k - begin + 1.0);
    level.Advance();
    if (std::isfinite(e(k))) level.Measure(e(k));
  }
  return errors;
}

// The errors of one output, given e_k = y_k − x_k (NaN where not measured).
Eigen::RowVectorXd LevelErrors(const Eigen::RowVectorXd& e, double ratio,
                               int first, int horizon) {
  const int n = static_cast<int>(e.size());
  Eigen::RowVectorXd errors = Eigen::RowVectorXd::Constant(n, kNaN);
  if (horizon == 0) {
    errors.tail(n - first) = e.tail(n - first);
    Centre(errors);
    return errors;
  }
  double level = 0.0;
  double variance = 0.0;  // of the level, in units of r
  bool known = false;
  double start = 0.0;  // the level from which predictions run
  bool started = false;
  for (int k = first; k < n; ++k) {
    if ((k - first) % horizon == 0) {
      start = level;
      started = known;
    }
    if (started) errors(k) = e(k) - start;
    if (known) variance += ratio;
    if (!std::isfinite(e(k))) continue;
    const double gain = known ? variance / (variance + 1.0) : 1.0;
    level += gain * (e(k) - level);
    variance = gain;  // in units of r: P/(P + 1)
    known = true;
  }
  return errors;
}

// The errors of a model in one output, at the samples that were measured.
struct Remainder {
  std::vector<int> times;
  VectorXd values;
  bool ramp = false;  // a free one is part of it
};

Remainder FiniteFrom(const Eigen::RowVectorXd& errors, int first, bool ramp) {
  Remainder remainder;
  remainder.ramp = ramp;
  for (int k = first; k < errors.size(); ++k) {
    if (std::isfinite(errors(k))) remainder.times.push_back(k);
  }
  remainder.values = errors(remainder.times).transpose();
  return remainder;
}

// −2 ln likelihood less constants, maximised over r.
double LevelDeviance(const std::vector<Remainder>& remainders, double ratio) {
  double squares = 0.0;
  double size = 0.0;
  double log_determinant = 0.0;
  double innovations = 0.0;
  for (const Remainder& remainder : remainders) {
    if (remainder.times.size() < (remainder.ramp ? 3 : 2)) continue;
    const InnovationsFilter filter(remainder.times, {.ratio = ratio});
    MatrixXd whitened = remainder.values;
    if (remainder.ramp) AppendRamp(remainder.times, whitened);
    filter.Apply(whitened);
    if (remainder.ramp) {
      const double size_of_ramp = whitened.col(1).squaredNorm();
      whitened.col(0) -=
          whitened.col(1).dot(whitened.col(0)) / size_of_ramp * whitened.col(1);
      log_determinant += std::log(size_of_ramp);
      innovations -= 1.0;
    }
    squares += whitened.col(0).squaredNorm();
    size += remainder.values.squaredNorm();
    log_determinant += filter.log_determinant();
    innovations += static_cast<double>(remainder.times.size()) - 1.0;
  }
  // Exact data leave rounding, which has no likelihood.
  squares = std::max({squares, 1e-26 * size, 1e-300});
  return innovations * std::log(squares) + log_determinant;
}

double LikeliestRatio(const std::vector<Remainder>& remainders) {
  double best = kLeastLogRatio;
  double least = LevelDeviance(remainders, std::pow(10.0, best));
  const auto search = [&](double low, double high, double step) {
    for (double log = low; log <= high + 0.5 * step; log += step) {
      const double deviance = LevelDeviance(remainders, std::pow(10.0, log));
      if (deviance >= least) continue;
      least = deviance;
      best = log;
    }
  };
  search(kLeastLogRatio, kLargestLogRatio, 1.0);
  const double coarse = best;
  search(coarse - 0.9, coarse + 0.9, 0.1);
  return std::pow(10.0, best);
}

// From rest, inputs as they differ from the first; what grows without bound
// stays at ±1e100.
MatrixXd SimulateArx(const ArxModel& model, const MatrixXd& inputs) {
  constexpr double kBound = 1e100;
  const int p = model.num_outputs;
  const int channels = model.num_channels();
  MatrixXd history = MatrixXd::Zero(channels, inputs.cols());
  history.bottomRows(model.num_inputs) = inputs.colwise() - inputs.col(0);
  for (Eigen::Index k = 1; k < inputs.cols(); ++k) {
    VectorXd y = VectorXd::Zero(p);
    for (Eigen::Index lag = 1; lag <= std::min<Eigen::Index>(model.order, k);
         ++lag) {
      y += model.R.middleCols((lag - 1) * channels, channels) *
           history.col(k - lag);
    }
    history.col(k).head(p) = y.cwiseMax(-kBound).cwiseMin(kBound);
  }
  return history.topRows(p);
}

bool Integrates(const InputResponse& model, Eigen::Index output) {
  return !model.integrating.empty() && model.integrating[output];
}

int FirstPredicted(const InputResponse& model, const Record& record) {
  const int lead = record.lead();
  return std::max(
      lead, std::min(model.forgetting, lead + (record.samples() - lead) / 4));
}

}  // namespace

absl::StatusOr<InputResponse> ResponseOf(const ProcessModel& model,
                                         double sample_time) {
  // A model that cannot be simulated is found here, not record by record.
  MLE_RETURN_IF_ERROR(ProcessSimulator::Create(model, sample_time).status());
  return InputResponse{
      .response =
          [model](const Record& record) {
            return SimulateResponse(model, record.sample_time, record.inputs);
          },
      .forgetting = static_cast<int>(
          std::min(std::ceil(LongestMemory(model) / sample_time), 1e9)),
      .integrating = IntegratingOutputs(model)};
}

InputResponse ResponseOf(const ArxModel& model) {
  return {
      .response = [model](const Record& record) -> absl::StatusOr<MatrixXd> {
        return SimulateArx(model, record.inputs);
      },
      .forgetting = model.order};
}

absl::StatusOr<VectorXd> FitLevelRatios(const InputResponse& model,
                                        const std::vector<Record>& windows) {
  const Eigen::Index p = windows.front().num_outputs();
  std::vector<std::vector<Remainder>> remainders(p);
  for (const Record& window : windows) {
    MLE_ASSIGN_OR_RETURN(const MatrixXd response, model.response(window));
    const int first = FirstPredicted(model, window);
    for (Eigen::Index i = 0; i < p; ++i) {
      remainders[i].push_back(
          FiniteFrom(window.outputs.row(i) - response.row(i), first,
                     Integrates(model, i)));
    }
  }
  VectorXd ratios(p);
  for (Eigen::Index i = 0; i < p; ++i) {
    ratios(i) = LikeliestRatio(remainders[i]);
  }
  return ratios;
}

Predictor PredictWithLevel(const InputResponse& model, const VectorXd& ratios) {
  return [=](const Record& record, int horizon) {
    const absl::StatusOr<MatrixXd> response = model.response(record);
    MatrixXd errors =
        MatrixXd::Constant(record.num_outputs(), record.samples(), kNaN);
    if (!response.ok()) return errors;
    for (int i = 0; i < record.num_outputs(); ++i) {
      const auto errors_of = Integrates(model, i) ? SlopedErrors : LevelErrors;
      errors.row(i) =
          errors_of(record.outputs.row(i) - response->row(i), ratios(i),
                    FirstPredicted(model, record), horizon);
    }
    return errors;
  };
}

absl::StatusOr<Predictor> PredictAsIn(const std::vector<Record>& windows,
                                      const InputResponse& model) {
  MLE_ASSIGN_OR_RETURN(const VectorXd ratios, FitLevelRatios(model, windows));
  return PredictWithLevel(model, ratios);
}

}  // namespace mle
