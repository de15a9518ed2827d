// Another program run to its end, without a shell.

#ifndef APPS_REPORT_PROCESS_H_
#define APPS_REPORT_PROCESS_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace mle::report {

struct ProcessResult {
  int exit_code = 0;     // 128 + the signal, if one ended it
  std::string out = {};  // what it wrote to its standard output
  std::string err = {};  // and to its standard error
};

struct ProcessOptions {
  absl::Duration time_limit = absl::InfiniteDuration();  // > 0
  std::vector<std::string> variables = {};  // of its environment, "NAME=VALUE"
};

// Runs `program`, sought in PATH, with `arguments`, and gives it `input` to
// read. The environment is this process's, in UTF-8, the C locale and UTC, with
// `variables`. NotFound if there is no such program; Internal if it cannot be
// run; DeadlineExceeded if it takes longer than the limit: then it is killed.
absl::StatusOr<ProcessResult> RunProcess(
    const std::string& program, const std::vector<std::string>& arguments,
    std::string_view input, const ProcessOptions& options = {});

}  // namespace mle::report

#endif  // APPS_REPORT_PROCESS_H_
