// The flags of mle_correct that say how records are read and cut.

#ifndef APPS_CORRECT_RECORD_FLAGS_H_
#define APPS_CORRECT_RECORD_FLAGS_H_

#include "absl/status/statusor.h"
#include "mle/maintain/records.h"

namespace mle::correct {

// Errors name the flag, what was found and what would be right.
absl::StatusOr<HistorianOptions> ImportOptionsFromFlags(
    const ProcessModel& model);
absl::StatusOr<RecordOptions> RecordOptionsFromFlags();

}  // namespace mle::correct

#endif  // APPS_CORRECT_RECORD_FLAGS_H_
