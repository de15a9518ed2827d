#include "apps/simulate/condition_options.h"

#include "mle/base/double_limits.h"

namespace mle::simulate {

std::vector<Option> OptionsOf(sim::OutputDisturbanceOptions& options) {
  return {
      {"coloured_variance", ForEachOutput(&options.coloured_variance, "0"),
       "Variance of a coloured disturbance of the outputs: one value, or one "
       "for each output.",
       "", kNotNegative},
      {"coloured_time_constant", &options.coloured_time_constant,
       "Correlation time of the coloured disturbance.", "min", kPositive},
      {"drift_variance", ForEachOutput(&options.drift_variance, "0"),
       "Variance q of the increments per sample of a random-walk disturbance "
       "of the outputs: one value, or one for each output.",
       "", kNotNegative},
      {"disturbance_step_rate", &options.step_rate,
       "Mean number of step disturbances of an output per unit of time.",
       "1/min", kNotNegative},
      {"disturbance_step_deviation",
       ForEachOutput(&options.step_deviation, "0"),
       "Standard deviation of a step disturbance: one value, or one for each "
       "output.",
       "", kNotNegative},
  };
}

std::vector<Option> OptionsOf(sim::InputDisturbanceOptions& options) {
  return {
      {"disturbance_variance", ForEachInput(&options.variance, "0"),
       "Variance of coloured noise on the inputs with the role of "
       "disturbances: one value, or one for each input of the model.",
       "", kNotNegative},
      {"disturbance_time_constant", &options.time_constant,
       "Correlation time of that noise on the inputs.", "min", kPositive},
  };
}

std::vector<Option> OptionsOf(sim::ValveLimits& limits) {
  return {
      {"valve_min", LimitOfEachInput(&limits.min, -kInfinity),
       "Lower limits of the plant's valves, which the controller does not "
       "know; as --min_input."},
      {"valve_max", LimitOfEachInput(&limits.max, kInfinity),
       "Upper limits of the plant's valves, as --valve_min."},
  };
}

std::vector<Option> OptionsOf(sim::MeasurementFaultOptions& options) {
  return {
      {"outlier_probability", &options.outlier_probability,
       "Probability that a measured sample of an output is an outlier.", "",
       kShare},
      {"outlier_size", ForEachOutput(&options.outlier_size, "0"),
       "Largest outlier; the size of an outlier is uniform between a fifth of "
       "this value and this value. One value, or one for each output.",
       "", kNotNegative},
      {"quantum", ForEachOutput(&options.quantum, "0"),
       "Quantum of the measured outputs; 0: no rounding. One value, or one for "
       "each output.",
       "", kNotNegative},
      {"freeze_rate", &options.freeze_rate,
       "Mean number of times a measured output freezes per unit of time.",
       "1/min", kNotNegative},
      {"freeze_duration", &options.freeze_duration,
       "Mean duration for which a measured output is frozen.", "min",
       kPositive},
      {"lost_probability", &options.lost_probability,
       "Probability that a sample of an output is lost.", "", kShare},
      {"lost_input_probability", &options.lost_input_probability,
       "Probability that a sample of an input is lost in the record.", "",
       kShare},
      {"faults_only_in_record", &options.only_in_record,
       "Outliers, rounding, frozen and lost samples occur in the historian; "
       "the controller receives the measurements without these faults."},
  };
}

}  // namespace mle::simulate
