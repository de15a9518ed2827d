// The flags of mle_reproduce, turned into what is to be run and where it goes.
// They are listed by `mle_reproduce --help`.

#ifndef APPS_REPRODUCE_FLAGS_H_
#define APPS_REPRODUCE_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "apps/reproduce/reproduction.h"

namespace mle::reproduce {

// Reads the process models and checks everything that can be checked before
// something is run; errors name the flag or the file.
absl::StatusOr<Reproduction> ReproductionFromFlags();

struct Destination {
  std::string folder;
  bool figures = true;
};

Destination DestinationFromFlags();

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_FLAGS_H_
