// The flags that name the initial model and the plants.

#ifndef APPS_REPRODUCE_CASE_FLAGS_H_
#define APPS_REPRODUCE_CASE_FLAGS_H_

#include "absl/status/status.h"
#include "apps/reproduce/study.h"

namespace mle::reproduce {

// Fills in `initial` and `cases`: the user's own, or the paper's. Errors name
// the flag, and the file if there is one.
absl::Status ReadCases(Study& study);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_CASE_FLAGS_H_
