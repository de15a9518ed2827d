// The record from which a model is converted: the process excited in open loop
// by white Gaussian inputs that change at every sample.

#ifndef MLE_CORRECTION_EXCITATION_H_
#define MLE_CORRECTION_EXCITATION_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct ExcitationOptions {
  double sample_time = 0.2;       // Δt > 0
  double duration = 10000.0;      // N₀Δt > 0; N₀ + 1 samples
  double input_variance = 1.0;    // > 0
  double noise_variance = 0.001;  // ≥ 0, white, on each output
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;

  absl::Status Validate() const;
};

// Inputs and noise are drawn from streams of their own, so that runs with and
// without noise see the same inputs.
absl::StatusOr<Record> SimulateExcitation(const ProcessModel& process,
                                          const ExcitationOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_EXCITATION_H_
