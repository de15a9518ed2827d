// Inputs that the plant does not follow where they turn back: backlash of a
// linkage, or a valve that sticks, between the demand that is recorded and what
// acts on the plant.
//
// The outputs are explained by inputs passed through plays of some widths
// (play_regression.h), widths are added one input at a time while that gains 3
// nats, and an input sticks if, beside the plays of all others,
//
//   - its play gains 12 nats, noise fitted with and without it;
//   - 8 nats under the filters of the noise that is found without it, with a
//     difference of 0.4 to 2.5 times what its width says;
//   - 15 nats under the filters found with it;
//   - and its width is below 45 % of the input's range in the records.
//
// Gains, dead times, time constants and a valve's characteristic are refitted
// on both sides, so that a change of these is not taken for a play. A slip
// jump, by which stiction differs from backlash, is not estimated: the width
// is that of the backlash that explains the records best.
//
// Source of the model: Choudhury, Thornhill and Shah, Control Engineering
// Practice 13 (2005), p. 641.

#ifndef MLE_MAINTAIN_STICKING_INPUTS_H_
#define MLE_MAINTAIN_STICKING_INPUTS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct StickingInput {
  int input = 0;
  double width = 0.0;  // b > 0, in the input's unit
  double error = 0.0;  // its standard error
  double share = 0.0;  // of the input's range in the records
  // Gained, noise fitted with and without it.
  double log_likelihood = 0.0;
  std::vector<int> outputs;  // that this input moves

  std::string Describe(const ProcessModel& model) const;
};

// Those of `usable` outputs (p) tell; gaps are bridged, and rows near them left
// out. Needs 200 samples around changes of set points, and takes as many that
// samples × elements² / outputs are at most 2·10⁷. Errors as of
// SimulateResponse().
absl::StatusOr<std::vector<StickingInput>> FindStickingInputs(
    const ProcessModel& model, const std::vector<Record>& records,
    const std::vector<bool>& usable, int threads = 1);

// Replaces the input by what has passed through its play.
void CorrectPlay(const StickingInput& sticking, std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_MAINTAIN_STICKING_INPUTS_H_
