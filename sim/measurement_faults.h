// Faults of a measurement on its way to the controller and the historian:
// outliers, quantisation, frozen channels and lost samples.
//
// In this order: a frozen channel repeats its last value; any other takes an
// outlier where one is due and is rounded to its quantum; then the sample may
// be lost (NaN). Each kind draws from a stream of its own.

#ifndef SIM_MEASUREMENT_FAULTS_H_
#define SIM_MEASUREMENT_FAULTS_H_

#include <cstdint>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

// Vectors have a value for each output (p), or none: that kind is off.
struct MeasurementFaultOptions {
  double outlier_probability = 0.0;  // of each sample of each output, in [0, 1]
  // Largest outlier ≥ 0: one adds or subtracts a fifth of it to all of it,
  // evenly distributed.
  Eigen::VectorXd outlier_size;
  Eigen::VectorXd quantum;   // ≥ 0: values are whole multiples of it
  double freeze_rate = 0.0;  // mean freezes per unit of time and output, ≥ 0
  double freeze_duration = 10.0;  // mean > 0, exponentially distributed
  double lost_probability = 0.0;  // of each sample of each output, in [0, 1]
  // The same for inputs; only the record knows of it.
  double lost_input_probability = 0.0;
  // Whether the faults arise in the historian alone. Otherwise the controller
  // sees them too, with the last good value in place of a lost one.
  bool only_in_record = false;

  absl::Status Validate(int num_outputs) const;
};

// The faults of one run, drawn ahead.
class MeasurementFaults {
 public:
  // For valid options.
  MeasurementFaults(const MeasurementFaultOptions& options, int num_outputs,
                    int num_inputs, double sample_time, int samples,
                    std::uint64_t seed, std::uint64_t stream);

  // Applies the faults to the measured outputs (p) of sample k; to be called
  // for k = 0, 1, ….
  void SpoilOutputs(int k, Eigen::Ref<Eigen::VectorXd> outputs);
  // Marks the recorded inputs (m) of sample k that are lost.
  void SpoilInputs(int k, Eigen::Ref<Eigen::VectorXd> inputs) const;

 private:
  using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

  static Mask DrawLost(int rows, int samples, double probability,
                       std::uint64_t seed, std::uint64_t stream,
                       std::uint32_t substream);
  static Mask DrawFrozen(const MeasurementFaultOptions& options,
                         int num_outputs, double sample_time, int samples,
                         std::uint64_t seed, std::uint64_t stream);

  // Empty where a kind is off.
  Eigen::MatrixXd outliers_;  // p × N
  Eigen::VectorXd quantum_;   // p
  Mask frozen_;               // p × N
  Mask lost_outputs_;         // p × N
  Mask lost_inputs_;          // m × N
  Eigen::VectorXd last_;      // p
};

}  // namespace mle::sim

#endif  // SIM_MEASUREMENT_FAULTS_H_
