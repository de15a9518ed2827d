// Status helpers. Whatever comes from outside (files, flags, arguments) is
// answered with absl::Status; these macros pass a failure on to the caller.
//
//   MLE_RETURN_IF_ERROR(options.Validate());
//   MLE_ASSIGN_OR_RETURN(const Record record, ReadRecord(path));

#ifndef MLE_BASE_STATUS_H_
#define MLE_BASE_STATUS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

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

#endif  // MLE_BASE_STATUS_H_
