// Status helpers. Whatever comes from outside (files, flags, arguments) is
// answered with absl::Status; these macros pass a failure on to the caller.
//
//   MLE_RETURN_IF_ERROR(options.Validate());
//   MLE_ASSIGN_OR_RETURN(const Record record, ReadRecord(path));
//   return InvalidArgument("'", name, "' is not known; choose from a and b");

#ifndef MLE_BASE_STATUS_H_
#define MLE_BASE_STATUS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

#define MLE_RETURN_IF_ERROR(expression)                             \
  do {                                                              \
    if (absl::Status mle_status = (expression); !mle_status.ok()) { \
      return mle_status;                                            \
    }                                                               \
  } while (false)

#define MLE_STATUS_CONCAT_INNER(a, b) a##b
#define MLE_STATUS_CONCAT(a, b) MLE_STATUS_CONCAT_INNER(a, b)

#define MLE_ASSIGN_OR_RETURN(declaration, expression)                   \
  MLE_ASSIGN_OR_RETURN_IMPL(MLE_STATUS_CONCAT(mle_statusor_, __LINE__), \
                            declaration, expression)

#define MLE_ASSIGN_OR_RETURN_IMPL(statusor, declaration, expression) \
  auto statusor = (expression);                                      \
  if (!statusor.ok()) return statusor.status();                      \
  declaration = std::move(statusor).value()

namespace mle {

// InvalidArgument whose message are these parts, one after the other, as of
// absl::StrCat().
template <typename... Parts>
absl::Status InvalidArgument(const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat(parts...));
}

}  // namespace mle

#endif  // MLE_BASE_STATUS_H_
