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

#ifndef APPS_LIFECYCLE_OPERATION_H_
#define APPS_LIFECYCLE_OPERATION_H_

#include <memory>
#include <optional>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/lifecycle/scenario.h"
#include "control/mpc.h"
#include "control/mpc_options.h"
#include "control/operating_cost.h"
#include "control/prediction_model.h"
#include "mle/data/record.h"
#include "sim/ageing_plant.h"
#include "sim/closed_loop.h"
#include "sim/set_point_profile.h"

namespace mle::lifecycle {

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

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_OPERATION_H_
