// One policy through all the years of a scenario.
//
// For each set-point change, in turn: the quiet time before it, the change, and
// then the action of the policy: nothing, a correction from the records of the
// last changes, or a step test. The resulting model is used from there on.

#ifndef APPS_LIFECYCLE_LIFE_H_
#define APPS_LIFECYCLE_LIFE_H_

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/scenario.h"
#include "control/mpc.h"
#include "control/mpc_options.h"
#include "control/operating_cost.h"
#include "control/prediction_model.h"
#include "mle/data/record.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/prediction.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "sim/ageing_plant.h"
#include "sim/closed_loop.h"
#include "sim/set_point_profile.h"

namespace mle::lifecycle {

// The plant in operation, stretch by stretch: predictive control around each
// set-point change, quiet running between them, step tests.
//
// Months pass between changes, and all but hours of them are stationary: the
// set point is constant, the loop responds to noise and slow disturbances. Of
// such a quiet stretch only the last `quiet_stretch` is simulated; what it
// costs, per unit of time, represents all of it. There the plant is as it is at
// the next change (frozen: it ages by parts in a thousand while that is
// simulated), and is entered at its steady state, the loop having run for
// `warm_up` before anything is counted. With `every_sample` everything is
// simulated: the plant ages sample by sample and the controller is never
// restarted; this is about a hundred times slower and validates the short cut.
//
// Disturbances: on each output white measurement noise, which the controller
// and the records see, and a slow disturbance of the product itself
// (scenario.h), one path over all years. Noise and disturbance depend
// on the seed and the change alone, so that all policies have the same.

struct OperationOptions {
  double sample_time = 0.2;
  double noise_variance = 0.001;          // σ² ≥ 0
  Eigen::VectorXd disturbance_deviation;  // s ≥ 0 (p)
  double disturbance_time = 1440.0;       // T > 0
  control::MpcOptions controller;
  control::OutputLimits limits;  // for the violation
  double before = 200.0;         // of the record of a change
  double after = 200.0;          // of it, and what counts as transient
  double quiet_stretch = 400.0;  // > 0
  double warm_up = 100.0;        // ≥ 0
  bool every_sample = false;

  // The time that a change needs before it and after it.
  double Lead() const { return quiet_stretch + warm_up; }
  absl::Status Validate(const ProcessModel& model) const;
};

// The operation from the end of the last change (or step test) to the end of
// this one.
struct ChangeOperation {
  control::OperationSums quiet;      // up to the change
  control::OperationSums transient;  // `after` from the change on
  Record window;  // measured, `before` and `after` around the change
  // p: mean squared error as it was measured, in the quiet time.
  Eigen::VectorXd quiet_square;
};

// The first hours with another model.
struct WatchOperation {
  control::OperationSums sums;
  Eigen::VectorXd square;  // p: mean squared error as it was measured
};

struct TestOperation {
  control::OperationSums sums;
  Record record;
};

class Operation {
 public:
  // `scenario` must outlive it.
  static absl::StatusOr<Operation> Create(const Scenario& scenario,
                                          const OperationOptions& options);

  // The next change of the scenario, with this model in the controller.
  // FailedPrecondition, with channel and time, if the loop diverges.
  absl::StatusOr<ChangeOperation> RunChange(
      const control::PredictionModel& model);

  // A step test right after the last change: the controller is off.
  absl::StatusOr<TestOperation> RunStepTest(const StepTestPlan& plan);

  // Quiet running after the last change with a new model, for a quiet stretch.
  absl::StatusOr<WatchOperation> RunWatch(
      const control::PredictionModel& model);

  double now() const { return now_; }

 private:
  struct Stretch;

  Operation(const Scenario& scenario, const OperationOptions& options);

  Eigen::VectorXd SteadyInputs(const ProcessModel& plant,
                               const Eigen::VectorXd& wanted) const;
  absl::StatusOr<Stretch> Enter(double time, const Eigen::VectorXd& set_points,
                                Eigen::MatrixXd disturbance);
  absl::Status Simulate(Stretch& stretch, const sim::SetPointProfile& profile,
                        std::uint64_t stream,
                        const sim::Controller& controller);
  absl::Status PrepareController(const control::PredictionModel& model,
                                 const Stretch& stretch,
                                 const Eigen::VectorXd& set_points);

  const Scenario* scenario_;
  OperationOptions options_;
  int next_ = 0;      // of the scenario's events
  double now_ = 0.0;  // all before has been lived through
  SlowDisturbance disturbance_;
  Eigen::VectorXd inputs_;                        // m: asked for last
  std::unique_ptr<sim::PlantModel> whole_plant_;  // every_sample
  std::optional<control::Mpc> mpc_;
};

// A policy's update: corrects the model in use from records, and accepts or
// refuses the correction as CorrectFromRecords() (mle/maintain) decides.

// The model that a controller runs on, in the forms that are needed of it.

struct ModelInUse {
  // Gains, time constants and dead times; where `own_response`, only what the
  // next correction begins with.
  ProcessModel process;
  // Step responses are not those of `process`: the model has a ΔR.
  bool own_response = false;
  StepResponse response;  // at 0, Δt, … (only if own_response)
  Predictor predictor;    // of the model in use (only if own_response)
  control::PredictionModel prediction;
};

absl::StatusOr<ModelInUse> UseProcess(const ProcessModel& process,
                                      double control_period);

// How far a model is from the plant.
struct ModelError {
  double distance = 0.0;  // E, over the response horizon
  // The largest relative error of a gain, |K̂ − K| / |K|, and the largest error
  // of a dead time (time unit). Of responses that are not a process model's,
  // gains are those at the end of the horizon, and dead times those of
  // first-order fits; NaN where such a fit is poor.
  double gain = 0.0;
  double delay = 0.0;
};

// `samples` of step responses are compared.
absl::StatusOr<ModelError> CompareWithPlant(const ModelInUse& model,
                                            const ProcessModel& plant,
                                            double sample_time, int samples);

struct UpdateOptions {
  CorrectOptions correct = SimulatedRecords();
  double control_period = 1.0;
  int response_samples = 501;  // compared with the plant

  // Options for simulated records: these have no outliers, and nobody looks at
  // diagnostics or an ARX model.
  static CorrectOptions SimulatedRecords();
};

enum class Outcome {
  kNone,      // nothing was tried
  kNoChange,  // the test found no change
  kUpdated,
  kRefused,   // not validated, or because the controller cannot use it
  kReverted,  // used for some hours, then reverted: the squared error grew
};

std::string_view NameOf(Outcome outcome);
// The reverse; an error for another name.
absl::StatusOr<Outcome> ParseOutcome(std::string_view name);

struct UpdateResult {
  Outcome outcome = Outcome::kNone;
  std::string reason;  // of a refusal
  // The share of the squared one-step error that the correction removes where
  // it was held out, of the output that gains least; NaN where it was not
  // tried.
  double held_out_gain = 0.0;
  std::optional<ModelInUse> model;  // if updated
};

// ΔR, where the estimator has one, is always sought around the process model of
// `in_use`, which for the estimator arx stays that of the commissioning.
// Windows are in order of time: where they disagree, the oldest are left out.
UpdateResult UpdateModel(const ModelInUse& in_use,
                         const std::vector<Record>& windows,
                         const UpdateOptions& options);

struct LifeOptions {
  OperationOptions operation;
  UpdateOptions update;  // its estimator is the policy's
  StepTestOptions test;
  int windows = 4;  // records of the last changes that are kept, ≥ 1
  // Older ones are forgotten, time unit, > 0.
  double window_age = std::numeric_limits<double>::infinity();
  double month = 43830.0;  // in the time unit
  // A new model is watched for a quiet stretch, and reverted if the measured
  // squared error of an output is more than this many times what it was before
  // the last change, > 1; infinite: never.
  double watch_limit = 3.0;
};

// Results of a set-point change and of the time before it.
struct ChangeRow {
  SetPointEvent event;
  control::OperationSums quiet;      // since the last row
  control::OperationSums transient;  // after the change
  // Sums of a step test after it, and of the first hours with a new model;
  // their times are 0 without one.
  control::OperationSums test;
  control::OperationSums watch;
  ModelError error;  // of the model in use at the change
  double index = std::numeric_limits<double>::quiet_NaN();  // on_demand only
  Outcome outcome = Outcome::kNone;  // of a correction or step test after it
  std::string reason;                // of a refusal
  double held_out_gain = std::numeric_limits<double>::quiet_NaN();

  bool tested() const { return test.time > 0.0; }
  // Sums of all four.
  control::OperationSums Total() const;
};

struct Life {
  std::vector<ChangeRow> rows;  // the last is the end of the years
  // If the loop diverged: the reason and the time. Rows end there.
  std::string ended;
};

// `stop` is asked at each change and within corrections; Cancelled if it says
// so. Other errors are of options and models that do not fit.
absl::StatusOr<Life> LiveThrough(const Scenario& scenario, const Policy& policy,
                                 const LifeOptions& options,
                                 const std::function<bool()>& stop);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_LIFE_H_
