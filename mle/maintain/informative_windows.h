// Which windows of long records are used. Internal to mle/maintain.
//
// What window w says of the gain of element (i, j) is, but for the noise of
// output i, the information
//
//   I_wij = Σ_k (x_ij(k)~)²,   S_ij = Σ_w I_wij over the windows used,
//
// of the model's response x_ij to the window's inputs, whether set points move
// them or control, whitened (~) under an offset and noise that drifts. Windows
// are taken one after the other, each time the one by which Σ_ij ln(S_ij + a
// thousandth of all I_ij) grows most for each of its samples, until the samples
// are used up: what says something of elements that others do not inform comes
// first. (The D-criterion with parameters apart: Fedorov, Theory of Optimal
// Experiments, 1972.) Windows that are long are divided first, and short ones
// that follow each other without a gap are taken together, a tenth of the
// samples and four settling times at least: what the inputs did before it is
// unknown of each piece, and gains of its own, by which windows are compared
// (window_agreement.h), need its length.
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
