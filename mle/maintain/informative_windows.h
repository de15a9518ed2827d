// Which windows of long records are used. Internal to mle/maintain.
//
// Windows that are long are divided first, and short ones that follow each
// other without a gap are taken together, a tenth of the samples and four
// settling times at least: what the inputs did before it is unknown of each
// piece. Of these those are taken that are expected to inform most
// (segment_information.h).
//
// Operations: N samples times the elements, and W² times the elements for W
// windows.

#ifndef MLE_MAINTAIN_INFORMATIVE_WINDOWS_H_
#define MLE_MAINTAIN_INFORMATIVE_WINDOWS_H_

#include "absl/status/status.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Leaves windows of about `most_samples` in all (0: all windows), and a note of
// what was left out. InvalidArgument for a model that cannot be simulated.
absl::Status KeepInformativeWindows(const ProcessModel& model, int most_samples,
                                    RecordData& data);

}  // namespace mle

#endif  // MLE_MAINTAIN_INFORMATIVE_WINDOWS_H_
