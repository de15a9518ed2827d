// The initial model and the plants of a reproduction.

#ifndef APPS_REPRODUCE_CASES_H_
#define APPS_REPRODUCE_CASES_H_

#include "absl/status/status.h"
#include "apps/reproduce/request.h"

namespace mle::reproduce {

// Fills in the campaign's model and mismatches: the user's own, or the paper's.
// Errors name the option, and the file if there is one.
absl::Status ReadCases(Request& request);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_CASES_H_
