// Records between engineering values and the variables in which a model is
// linear (mle/model/transform.h).

#ifndef MLE_DATA_LINEARISE_H_
#define MLE_DATA_LINEARISE_H_

#include <string_view>

#include "absl/status/status.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// x → T(x) of every channel, set points as their outputs; bad samples stay bad.
// InvalidArgument, naming channel, value and time, where a value has no
// transform; the record is as it was then.
absl::Status Linearise(const ProcessModel& model, Record& record);

// The way back; NaN where a value has none.
void Delinearise(const ProcessModel& model, Record& record);

}  // namespace mle

#endif  // MLE_DATA_LINEARISE_H_
