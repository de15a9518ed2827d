// The flags that name the initial model and the plants.

#ifndef APPS_REPRODUCE_CASE_FLAGS_H_
#define APPS_REPRODUCE_CASE_FLAGS_H_

#include "absl/status/status.h"
#include "apps/reproduce/reproduction.h"

namespace mle::reproduce {

// Fills in the campaign's model and mismatches: the user's own, or the paper's.
// Errors name the flag, and the file if there is one.
absl::Status ReadCases(Reproduction& reproduction);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_CASE_FLAGS_H_
