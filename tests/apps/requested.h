// A command's request made from flags as its users write them, without starting
// the command.

#ifndef TESTS_APPS_REQUESTED_H_
#define TESTS_APPS_REQUESTED_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/status.h"

namespace mle {

// What the request says of flags such as "--seeds=3" and "--every_sample".
template <typename Request>
absl::Status Requested(const std::vector<std::string>& flags) {
  Request request;
  OptionTable table;
  AddOptions(request, table);
  for (const std::string& flag : flags) {
    const std::size_t equals = flag.find('=');
    MLE_RETURN_IF_ERROR(table.Set(
        flag.substr(2, equals - 2),
        equals == std::string::npos ? "true" : flag.substr(equals + 1)));
  }
  MLE_RETURN_IF_ERROR(table.Read());
  return Complete(request, table);
}

// Flags that a request refuses, and what the one line must hold that says so.
struct RefusedFlags {
  std::vector<std::string> flags;
  std::vector<std::string> named;
};

template <typename Request>
void ExpectRefused(const std::vector<RefusedFlags>& all) {
  for (const RefusedFlags& one : all) {
    SCOPED_TRACE(::testing::PrintToString(one.flags));
    const absl::Status status = Requested<Request>(one.flags);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    const std::string message(status.message());
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& part : one.named) {
      EXPECT_THAT(message, ::testing::HasSubstr(part));
    }
  }
}

}  // namespace mle

#endif  // TESTS_APPS_REQUESTED_H_
