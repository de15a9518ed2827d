// Samples that are means over the time from one to the next, though nobody has
// said so: historians hand them out. Internal to mle/maintain.
//
// Inputs act over that time; outputs stand in its middle. Beside a controller
// that moves its inputs in between, all outputs seem to answer half a sample
// too early, which is no ageing. What set points drive of the outputs is
// explained twice, as samples and as means; the records are means where that
// leaves less, by as much as any explanation has to explain. What one of the
// two has found is tried in the other, too: only the sampling differs.

#ifndef MLE_MAINTAIN_MEANS_H_
#define MLE_MAINTAIN_MEANS_H_

#include "mle/explain/competition.h"
#include "mle/maintain/records.h"

namespace mle {

// Whether nothing is declared, or was found, of how the outputs were sampled.
bool MayBeMeans(const RecordData& data);

// The same data with Δt/2, outputs measured at every second sample: in the
// middle of what they are means over.
RecordData AsMeans(RecordData data);

// Whether the records are explained by less as means: over all outputs that
// set points drive, by the evidence that an explanation needs.
bool AreMeans(const Competition& as_samples, const Competition& as_means);

}  // namespace mle

#endif  // MLE_MAINTAIN_MEANS_H_
