// Errors that are about options: a caller that has other names for them, such
// as a command with flags, can name them in its own way.

#ifndef MLE_BASE_OPTION_ERROR_H_
#define MLE_BASE_OPTION_ERROR_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace mle {

// InvalidArgument that is about one option, or several separated by commas:
// their names, as they stand in `text`, are kept beside the text. A value that
// helps follows its option as "name = value".
absl::Status OptionError(std::string_view option, std::string_view text);

// The options that an error is about, separated by commas; empty: none.
std::string OptionOf(const absl::Status& status);

// `status` with `prefix` before its text.
absl::Status WithPrefix(const absl::Status& status, std::string_view prefix);

}  // namespace mle

#endif  // MLE_BASE_OPTION_ERROR_H_
