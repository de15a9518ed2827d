#include "mle/maintain/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "mle/base/status.h"
#include "mle/correction/prediction_residuals.h"
#include "mle/data/lagged_series.h"
#include "mle/maintain/channel_scales.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace

absl::StatusOr<Predictor> PredictWithProcess(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    double sample_time) {
  // What cannot be simulated is found here, not record by record.
  MLE_RETURN_IF_ERROR(ProcessSimulator::Create(model, sample_time).status());
  VectorXd ratios(model.num_outputs());
  for (int i = 0; i < model.num_outputs(); ++i) ratios(i) = noise[i].ratio;
  const int forgetting = static_cast<int>(
      std::min(std::ceil(LongestMemory(model) / sample_time), 1e9));
  return Predictor([=](const Record& record, int horizon) {
    const absl::StatusOr<MatrixXd> response =
        SimulateResponse(model, record.sample_time, record.inputs);
    MatrixXd errors =
        MatrixXd::Constant(record.num_outputs(), record.samples(), kNaN);
    if (!response.ok()) return errors;
    const int first = std::min(forgetting, record.samples() / 4);
    for (int i = 0; i < record.num_outputs(); ++i) {
      errors.row(i) = LevelErrors(record.outputs.row(i) - response->row(i),
                                  ratios(i), first, horizon);
    }
    return errors;
  });
}

Predictor PredictWithArx(const ArxModel& model) {
  return [model](const Record& record, int horizon) {
    MatrixXd errors =
        MatrixXd::Constant(record.num_outputs(), record.samples(), kNaN);
    if (record.samples() <= model.order) return errors;
    const LaggedSeries series(record, model.order, ChannelMeans({record}));
    for (const RowRange& rows : series.UsableRows()) {
      const MatrixXd residuals =
          PredictionResiduals(series, rows, model.R, horizon);
      // They run backwards in time.
      errors.middleCols(rows.first, rows.rows()) =
          residuals.rowwise().reverse();
    }
    return errors;
  };
}

absl::StatusOr<Predictor> PredictFilled(const ProcessModel& model,
                                        const std::vector<NoiseEstimate>& noise,
                                        double sample_time,
                                        const Predictor& predictor) {
  // What cannot be expected is found here, not record by record.
  Record empty;
  empty.sample_time = sample_time;
  empty.outputs.resize(model.num_outputs(), 0);
  empty.inputs.resize(model.num_inputs(), 0);
  MLE_RETURN_IF_ERROR(ExpectedOutputs(model, noise, empty).status());
  return Predictor([=](const Record& record, int horizon) {
    std::vector<Record> filled = {record};
    const absl::StatusOr<int> count =
        FillOutputs(model, noise, kLongestFill, filled);
    if (!count.ok()) {
      return MatrixXd(
          MatrixXd::Constant(record.num_outputs(), record.samples(), kNaN));
    }
    return MatrixXd(record.outputs.array().isFinite().select(
        predictor(filled.front(), horizon), kNaN));
  });
}

}  // namespace mle
