#include "mle/base/version.h"

namespace mle {

std::string_view LibraryVersion() { return MLE_VERSION; }

}  // namespace mle
