// NAME:TIME:VALUE,… on a command line: steps of named channels.

#ifndef APPS_SIMULATE_NAMED_VALUES_H_
#define APPS_SIMULATE_NAMED_VALUES_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace mle::simulate {

struct NamedStep {
  int channel = 0;  // of `names`
  double time = 0.0;
  double value = 0.0;
};

// Names may hold colons. InvalidArgument, naming flag and entry, for an unknown
// name, or a time or value that is not a finite number.
absl::StatusOr<std::vector<NamedStep>> ParseNamedSteps(
    std::string_view flag, std::string_view value,
    const std::vector<std::string>& names);

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_NAMED_VALUES_H_
