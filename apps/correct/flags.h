// The flags of mle_correct.

#ifndef APPS_CORRECT_FLAGS_H_
#define APPS_CORRECT_FLAGS_H_

#include "absl/status/statusor.h"
#include "apps/correct/request.h"

namespace mle::correct {

// Reads the models that the flags name. Errors name the flag, what was found
// and what would be right.
absl::StatusOr<Request> RequestFromFlags();

}  // namespace mle::correct

#endif  // APPS_CORRECT_FLAGS_H_
