#include "apps/common/loop_flags.h"

#include "apps/common/command_line.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"

DEFINE_double(sample_time, 0.2,
              "Sample time Δt of records and models, in the model's time unit "
              "(min).");
DEFINE_double(control_period, 1.0,
              "Control period Δt_c, a multiple of --sample_time (min).");
DEFINE_int32(prediction_horizon, 30,
             "Prediction horizon H_p, in control periods.");
DEFINE_int32(control_horizon, 5,
             "Control horizon H_c ≤ H_p, in control periods.");
DEFINE_string(output_weight, "0.2",
              "Weight Q_y on tracking errors, ≥ 0: one value, or one for each "
              "output, separated by commas.");
DEFINE_string(
    move_weight, "0.1",
    "Weight Q_u on input moves, ≥ 0: one value, or one for each input.");
DEFINE_double(disturbance_variance_ratio, 0.1,
              "Disturbance observer: increment variance of the output "
              "disturbance over the noise variance, ≥ 0.");
DEFINE_double(
    noise_variance, 0.001,
    "Variance σ² of the white measurement noise of every output, ≥ 0.");

namespace mle {

absl::StatusOr<control::MpcOptions> ControllerFromFlags(
    const ProcessModel& model) {
  control::MpcOptions options;
  options.control_period = FLAGS_control_period;
  options.prediction_horizon = FLAGS_prediction_horizon;
  options.control_horizon = FLAGS_control_horizon;
  MLE_ASSIGN_OR_RETURN(
      const Eigen::VectorXd output_weight,
      ParseNumbers("output_weight", FLAGS_output_weight, model.num_outputs()));
  MLE_ASSIGN_OR_RETURN(
      const Eigen::VectorXd move_weight,
      ParseNumbers("move_weight", FLAGS_move_weight, model.num_inputs()));
  options.output_weight = output_weight.asDiagonal();
  options.move_weight = move_weight.asDiagonal();
  options.disturbance_variance_ratio = FLAGS_disturbance_variance_ratio;
  return options;
}

}  // namespace mle
