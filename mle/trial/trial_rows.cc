#include "mle/trial/trial_rows.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/set_point_windows.h"
#include "mle/model/process_simulator.h"
#include "mle/trial/set_point_shapes.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// What the models make of the inputs (r × N each); NaN where these are not
// known, or former ones act that are not.
struct Simulated {
  MatrixXd in_use;
  MatrixXd proposed;
};

absl::StatusOr<Simulated> Simulate(const TrialModels& models,
                                   const Record& record, int forgetting) {
  const auto r = static_cast<Index>(models.outputs.size());
  const MatrixXd unknown = MatrixXd::Constant(r, record.samples(), kNaN);
  Simulated simulated = {unknown, unknown};
  const auto known = [&](int k) {
    return record.inputs(models.inputs, k).allFinite();
  };
  for (int begin = 0; begin < record.samples(); ++begin) {
    int end = begin;
    while (end < record.samples() && known(end)) ++end;
    const int length = end - begin;
    if (length > forgetting) {
      MatrixXd inputs = record.inputs.middleCols(begin, length);
      inputs = inputs.array().isFinite().select(inputs, 0.0).eval();
      MLE_ASSIGN_OR_RETURN(
          const MatrixXd in_use,
          SimulateResponse(models.in_use, record.sample_time, inputs));
      MLE_ASSIGN_OR_RETURN(
          const MatrixXd proposed,
          SimulateResponse(models.proposed, record.sample_time, inputs));
      const int kept = length - forgetting;
      simulated.in_use.middleCols(end - kept, kept) = in_use.rightCols(kept);
      simulated.proposed.middleCols(end - kept, kept) =
          proposed.rightCols(kept);
    }
    begin = end;
  }
  return simulated;
}

// Means of the columns from `offset` on, `samples` in turn.
MatrixXd MeansOf(const MatrixXd& values, Index offset, Index samples) {
  const Index n = (values.cols() - offset + samples - 1) / samples;
  MatrixXd means(values.rows(), n);
  for (Index k = 0; k < n; ++k) {
    const Index begin = offset + k * samples;
    const Index end = std::min(begin + samples, values.cols());
    for (Index i = 0; i < values.rows(); ++i) {
      double sum = 0.0;
      Index count = 0;
      for (Index l = begin; l < end; ++l) {
        if (!std::isfinite(values(i, l))) continue;
        sum += values(i, l);
        ++count;
      }
      means(i, k) = count > 0 && 2 * count >= samples
                        ? sum / static_cast<double>(count)
                        : kNaN;
    }
  }
  return means;
}

}  // namespace

absl::StatusOr<TrialRows> MakeTrialRows(const TrialModels& models,
                                        const Record& record, int first,
                                        const RowPlan& plan) {
  MLE_ASSIGN_OR_RETURN(const Simulated simulated,
                       Simulate(models, record, plan.forgetting));
  const MatrixXd measured = record.outputs(models.outputs, Eigen::all);
  const Index offset = first % plan.samples;
  const auto means = [&](const MatrixXd& values) {
    return MeansOf(values, offset, plan.samples);
  };
  TrialRows rows;
  rows.first = (first - offset) / plan.samples;
  const bool by_hand = record.set_points.size() == 0;
  MatrixXd moving = by_hand ? record.inputs : record.set_points;
  for (auto row : moving.rowwise()) row = Filled(row.transpose()).transpose();
  rows.shapes = SetPointShapes(means(moving), plan.pole);
  rows.differences = means(simulated.proposed - simulated.in_use);
  rows.in_use = means(measured - simulated.in_use);
  rows.proposed = means(measured - simulated.proposed);
  rows.changes.assign(static_cast<std::size_t>(rows.shapes.cols()), 0);
  // Of inputs those that rest otherwise.
  const std::vector<SetPointChange> changes =
      by_hand ? FindChanges({record}, WindowOptions()).front()
              : FindSetPointChanges(record);
  for (const SetPointChange& change : changes) {
    const Index row = (change.sample - offset) / plan.samples;
    if (change.sample >= offset) ++rows.changes[static_cast<std::size_t>(row)];
  }
  return rows;
}

}  // namespace mle
