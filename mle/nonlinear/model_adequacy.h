// Test whether a process model explains records up to their noise, against any
// fault of the model: a gain, a dead time, another order, a missing element.
//
// The model's residual of an output is regressed on sums of every input over
// ranges of lags (1, 2–3, 4–7, … samples, up to the model's settling time),
// that is, on any impulse response that is constant over each range,
//
//   y_i − ŷ_i = Σ_j Σ_b h_ijb Σ_{l in range b} u_j(k − l) + noise,
//
// with the noise of output_error_correction.h, white upon a random walk, and an
// offset for each window. The statistic is the reduction by the h of the
// squares of the whitened residuals, χ² under "the model is right" with a
// degree of freedom for each h that the records determine; the ratio of drift
// to white noise is the larger of those estimated with and without the h, by
// restricted likelihood. Given the past outputs the inputs say nothing about
// the noise to come, so that this holds for closed-loop records too.
//
//   MLE_ASSIGN_OR_RETURN(const ModelAdequacy adequacy,
//                        TestAdequacy(model, records, AdequacyOptions()));
//   if (!adequacy.adequate) correct(model);

#ifndef MLE_NONLINEAR_MODEL_ADEQUACY_H_
#define MLE_NONLINEAR_MODEL_ADEQUACY_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct AdequacyOptions {
  // Probability, in (0, 1), of finding a model wrong that is right.
  double false_alarm_probability = 0.01;
  // Whether the noise may have a random walk in it; if not, it is white.
  bool estimate_drift = true;
  // Options for the model's elements, as of OutputErrorOptions, whose bounds
  // decide how many samples at the begin of each window are left out.
  OutputErrorOptions structure;
  // Outputs are independent; 0: one thread for each processor.
  int threads = 1;

  absl::Status Validate() const;
};

// The test with the options, and the false-alarm probability, of an
// output_error correction.
AdequacyOptions AdequacyOptionsFor(const OutputErrorOptions& structure);

struct ModelAdequacy {
  bool adequate = true;
  double p_value = 1.0;    // of all outputs together
  double statistic = 0.0;  // sum over the outputs
  int degrees_of_freedom = 0;
};

// Errors are those of CorrectByOutputError().
absl::StatusOr<ModelAdequacy> TestAdequacy(const ProcessModel& model,
                                           const std::vector<Record>& records,
                                           const AdequacyOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_MODEL_ADEQUACY_H_
