
#include <algorithm>
#include <cmath>

#include "apps/correct/report.h"
#include "apps/correct/result.h"
#include "control/mpc.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/maintain/prediction.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"

namespace mle::correct {
namespace {

// Until the plant has settled twice; a tenth of that before the step.
constexpr double kLoopSettlingTimes = 2.0;
constexpr double kBefore = 0.1;
// Most control periods after a step; each of them costs as many operations as
// there are periods.
constexpr double kMostPeriods = 10'000;
constexpr double kMostSamples = 1e6;    // of the record
constexpr Eigen::Index kHorizons = 30;  // of predictions that are compared

// The largest step of the output's set point in the records; 1 where there is
// none.
double StepOf(const RecordData& data, int output) {
  double step = 0.0;
  for (const SetPointWindow& window : data.windows) {
    for (const SetPointChange& change : window.changes) {
      if (change.output != output) continue;
      const double one = change.to - change.from;
      if (std::abs(one) > std::abs(step)) step = one;
    }
  }
  return step == 0.0 || !std::isfinite(step) ? 1.0 : step;
}

// `mpc` begins at rest.
absl::StatusOr<Record> Follow(const ProcessModel& plant, control::Mpc mpc,
                              const sim::SetPointProfile& set_points,
                              const sim::ClosedLoopOptions& options) {
  return sim::SimulateClosedLoop(
      plant,
      [&mpc](const auto& measured, const auto& wanted, auto next_inputs) {
        mpc.Step(measured, wanted, next_inputs);
      },
      set_points, options);
}

double SquaredError(const Record& record) {
  return (record.outputs - record.set_points).squaredNorm();
}

}  // namespace

absl::StatusOr<LoopComparison> CompareLoops(const Result& result) {
  if (!result.accepted()) {
    return absl::FailedPreconditionError("nothing was corrected");
  }
  if (!result.request.controller_known()) {
    return absl::FailedPreconditionError("the controller's tuning is not told");
  }
  const control::MpcOptions& tuning = result.request.controller;
  LoopComparison comparison;
  const double settled =
      kLoopSettlingTimes *
      std::max(SettlingTime(result.model), SettlingTime(result.initial));
  if (!(settled <= kMostPeriods * tuning.control_period)) {
    return absl::FailedPreconditionError(
        "responses settle too late for a comparison of loops");
  }
  sim::ClosedLoopOptions options;
  options.sample_time = result.data.sample_time();
  options.control_period = tuning.control_period;
  options.noise_variance = 0.0;
  const double period = tuning.control_period;
  const double at = period * std::ceil(kBefore * settled / period);
  options.duration = at + period * std::ceil(settled / period);
  if (!(options.duration <= kMostSamples * options.sample_time)) {
    return absl::FailedPreconditionError(
        "a comparison of loops of this control period takes too many samples");
  }
  // Around the operating point of transforms, where there are any.
  const ProcessModel plant = WithoutTransforms(result.model);
  MLE_ASSIGN_OR_RETURN(
      const control::Mpc old_mpc,
      control::Mpc::Create(WithoutTransforms(result.initial), tuning));
  MLE_ASSIGN_OR_RETURN(const control::Mpc new_mpc,
                       control::Mpc::Create(plant, tuning));
  const int p = result.initial.num_outputs();
  comparison.steps.resize(p);
  std::vector<absl::Status> status(p);
  ParallelFor(p, result.options.threads, [&](int i) {
    const sim::SetPointProfile set_points{
        .steps = {{i, at, StepOf(result.data, i)}}};
    const absl::StatusOr<Record> before =
        Follow(plant, old_mpc, set_points, options);
    const absl::StatusOr<Record> after =
        Follow(plant, new_mpc, set_points, options);
    status[i] = before.ok() ? after.status() : before.status();
    if (!status[i].ok()) return;
    LoopStep& step = comparison.steps[i];
    step.output = i;
    step.before = *before;
    step.after = *after;
    const double error = SquaredError(step.before);
    if (error > 0.0) step.error_ratio = SquaredError(step.after) / error;
  });
  for (const absl::Status& of_output : status) MLE_RETURN_IF_ERROR(of_output);
  return comparison;
}

absl::StatusOr<Eigen::VectorXd> PredictionShifts(const Result& result) {
  const double sample_time = result.data.sample_time();
  MLE_ASSIGN_OR_RETURN(const InputResponse before,
                       ResponseOf(result.initial, sample_time));
  MLE_ASSIGN_OR_RETURN(const InputResponse after,
                       ResponseOf(result.model, sample_time));
  const auto horizon = static_cast<Eigen::Index>(
      std::clamp(std::round(SettlingTime(result.initial) / sample_time), 1.0,
                 kMostPeriods));
  const Eigen::Index step = std::max<Eigen::Index>(horizon / kHorizons, 1);
  Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(result.initial.num_outputs());
  double count = 0.0;
  for (const Record& window : result.data.Records()) {
    MLE_ASSIGN_OR_RETURN(Eigen::MatrixXd shift, after.response(window));
    MLE_ASSIGN_OR_RETURN(const Eigen::MatrixXd old, before.response(window));
    shift -= old;
    for (Eigen::Index h = step; h <= horizon && h < shift.cols(); h += step) {
      const Eigen::Index starts = shift.cols() - h;
      squares += (shift.rightCols(starts) - shift.leftCols(starts))
                     .rowwise()
                     .squaredNorm()
                     .array();
      count += static_cast<double>(starts);
    }
  }
  return Eigen::VectorXd((squares / std::max(count, 1.0)).sqrt());
}

}  // namespace mle::correct
