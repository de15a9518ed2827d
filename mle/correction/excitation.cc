#include "mle/correction/excitation.h"

#include <cmath>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/data/sampling.h"
#include "mle/model/process_simulator.h"

namespace mle {

absl::Status ExcitationOptions::Validate() const {
  MLE_RETURN_IF_ERROR(ValidateSampling(sample_time, duration));
  if (!(input_variance > 0.0) || !std::isfinite(input_variance)) {
    return InvalidArgument("input_variance = ", input_variance,
                           ", but it must be finite and > 0");
  }
  return ValidateNoiseVariance(noise_variance);
}

absl::StatusOr<Record> SimulateExcitation(const ProcessModel& process,
                                          const ExcitationOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(ProcessSimulator simulator,
                       ProcessSimulator::Create(process, options.sample_time));
  const int samples = SampleCount(options.sample_time, options.duration);

  GaussianNoise input_source(options.seed, options.stream, kExcitationInputs);
  GaussianNoise noise_source(options.seed, options.stream, kExcitationNoise);
  Record record;
  record.sample_time = options.sample_time;
  record.inputs = input_source.DrawMatrix(process.num_inputs(), samples,
                                          std::sqrt(options.input_variance));
  record.outputs = noise_source.DrawMatrix(process.num_outputs(), samples,
                                           std::sqrt(options.noise_variance));
  for (int k = 0; k < samples; ++k) {
    record.outputs.col(k) += simulator.outputs();
    simulator.Advance(record.inputs.col(k));
  }
  return record;
}

}  // namespace mle
