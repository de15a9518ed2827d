// A view of Abseil's, where its functions do not take the standard one.

#ifndef MLE_BASE_ABSL_VIEW_H_
#define MLE_BASE_ABSL_VIEW_H_

#include <string_view>

#include "absl/strings/string_view.h"

namespace mle {

inline absl::string_view AbslView(std::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace mle

#endif  // MLE_BASE_ABSL_VIEW_H_
