// A process model and its records in units in which the ARX correction is set
// up alike for every plant, and the conversion in those units.
//
// The penalties λ₀ and λ, and the excitation of the conversion, are numbers for
// the paper's plant: noise of variance 0.001, inputs of variance 1 that move
// outputs by some 500 standard deviations of it. So output i is divided by s_i
// and input j by s_j,
//
//   s_i = √(r_i/0.001),   s_j = 500 · geometric mean over i of √r_i / |φ_ij|,
//
// with r_i the variance of the output's white noise and |φ_ij| the largest
// magnitude of the pair's step response. A change of units changes nothing.

#ifndef MLE_MAINTAIN_CHANNEL_SCALES_H_
#define MLE_MAINTAIN_CHANNEL_SCALES_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/correction/correction_options.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// `noise` (p) of the plant; where an output has next to none, a 10⁻⁵th of its
// range in `records` stands for its standard deviation.
ChannelScales ChooseScales(const ProcessModel& model,
                           const std::vector<NoiseEstimate>& noise,
                           const std::vector<Record>& records);

Record Scaled(const Record& record, const ChannelScales& scales);
ProcessModel Scaled(const ProcessModel& model, const ChannelScales& scales);
// Back to the units of the records.
ArxModel Unscaled(const ArxModel& model, const ChannelScales& scales);

// The longest dead time and slowest time constant of an element together: how
// far back the inputs reach.
double LongestMemory(const ProcessModel& model);

// 1.25 times LongestMemory(), as the paper's order is to its plant, in samples;
// at least 10, and at most what leaves 1500 regressors.
int ChooseOrder(const ProcessModel& model, double sample_time);

// R of the model in scaled units, under noise of the plant's shape: white, with
// a random walk of the ratio q/r of each output.
absl::StatusOr<ConversionSummary> ConvertUnderNoise(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    const ChannelScales& scales, double sample_time,
    const ConversionSettings& settings);

}  // namespace mle

#endif  // MLE_MAINTAIN_CHANNEL_SCALES_H_
