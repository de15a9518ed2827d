#include "mle/maintain/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mle/base/status.h"
#include "mle/maintain/channel_scales.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Of log10 q/r: below, a level does not move within a record; above, it is
// all that moves.
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

// What a model leaves of an output: the samples that were measured.
struct Remainder {
  std::vector<int> times;
  VectorXd values;
};

Remainder FiniteFrom(const Eigen::RowVectorXd& errors, int first) {
  Remainder remainder;
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
    if (remainder.times.size() < 2) continue;
    const InnovationsFilter filter(remainder.times, {.ratio = ratio});
    MatrixXd whitened = remainder.values;
    filter.Apply(whitened);
    squares += whitened.squaredNorm();
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

int FirstPredicted(const InputResponse& model, const Record& record) {
  return std::min(model.forgetting, record.samples() / 4);
}

}  // namespace

absl::StatusOr<InputResponse> ResponseOf(const ProcessModel& model,
                                         double sample_time) {
  // What cannot be simulated is found here, not record by record.
  MLE_RETURN_IF_ERROR(ProcessSimulator::Create(model, sample_time).status());
  return InputResponse{
      .response =
          [model](const Record& record) {
            return SimulateResponse(model, record.sample_time, record.inputs);
          },
      .forgetting = static_cast<int>(
          std::min(std::ceil(LongestMemory(model) / sample_time), 1e9))};
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
          FiniteFrom(window.outputs.row(i) - response.row(i), first));
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
      errors.row(i) =
          LevelErrors(record.outputs.row(i) - response->row(i), ratios(i),
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
