// Which channels of a model records have no column of. Internal to this
// project: not installed.

#ifndef MLE_DATA_MISSING_CHANNELS_H_
#define MLE_DATA_MISSING_CHANNELS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/model/process_model.h"

namespace mle {

// The inputs and outputs whose column, by its tag or by their name, stands in
// no header of the sources, nor one that may be meant by it: a name of the same
// digits that is near or contains it, and is not used otherwise. Errors as of
// an import where a table is not understood.
absl::StatusOr<std::vector<std::string>> MissingChannels(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options);

}  // namespace mle

#endif  // MLE_DATA_MISSING_CHANNELS_H_
