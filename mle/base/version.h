// The version of the library, as in find_package(mle 0.1): semantic, "0.1.0".
// Before 1.0 a new minor version may change interfaces; CHANGELOG.md says how.

#ifndef MLE_BASE_VERSION_H_
#define MLE_BASE_VERSION_H_

#include <string_view>

namespace mle {

// The version of the library that the program runs with.
std::string_view LibraryVersion();

}  // namespace mle

#endif  // MLE_BASE_VERSION_H_
