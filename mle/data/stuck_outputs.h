// Outputs that stand still, to the last digit, while the model says that the
// inputs move them: sensors that are dead, frozen or clipped.
//
// A run of equal samples is taken for one if, in its first 60 % (what comes
// later may be a longer dead time), the model's response changes by more than 5
// times the noise of the output, by more than 20 times its rounding (an output
// that control keeps within its rounding stands still, whatever a model that is
// somewhat wrong expects), and by more than a tenth of what it changes by in
// all. Against the model, unlike in channel_health.h, outputs without noise and
// sensors dead from the start are seen too.

#ifndef MLE_DATA_STUCK_OUTPUTS_H_
#define MLE_DATA_STUCK_OUTPUTS_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/channel_health.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct StuckOutput {
  enum class Kind {
    kDead,     // for nine tenths of all records
    kClipped,  // at its largest or smallest value, more than once
    kFrozen,
  };
  int output = 0;
  Kind kind = Kind::kFrozen;
  double value = 0.0;  // at which it stands, the first time
  double expected =
      0.0;  // change that the model expects meanwhile, the largest
  std::vector<SampleRun> runs;

  int samples() const;
};

// Outputs without such runs are left out. Inputs that are missing count as
// held. An error only where the model cannot be simulated.
absl::StatusOr<std::vector<StuckOutput>> FindStuckOutputs(
    const std::vector<Record>& records, const ProcessModel& model);

}  // namespace mle

#endif  // MLE_DATA_STUCK_OUTPUTS_H_
