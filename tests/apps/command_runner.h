// Runs a command of the project as its users do, in a folder of its own.

#ifndef TESTS_APPS_COMMAND_RUNNER_H_
#define TESTS_APPS_COMMAND_RUNNER_H_

#include <string>
#include <vector>

#include "apps/report/process.h"
#include "nlohmann/json.hpp"
#include "tests/mle/base/scratch_folder.h"

namespace mle {

// Variables are set as by env(1), "PATH=/none".
report::ProcessResult RunCommand(const std::string& command,
                                 const std::vector<std::string>& arguments,
                                 const std::vector<std::string>& variables);

#ifdef MLE_TESTED_COMMAND
// The command that the test program is about.
inline report::ProcessResult RunTested(
    const std::vector<std::string>& arguments,
    const std::vector<std::string>& variables = {}) {
  return RunCommand(MLE_TESTED_COMMAND, arguments, variables);
}
#endif

// The content of a file; a failure of the test if there is none.
std::string Content(const std::string& path);

nlohmann::json ParsedJson(const std::string& path);

// The fields of each line of a CSV file (RFC 4180).
std::vector<std::vector<std::string>> ParsedCsv(const std::string& path);

// Flags for a run of the Wood-Berry column, or of another plant of its speed,
// that takes a fraction of a second, draws nothing and writes to `folder`.
std::vector<std::string> SmallRun(const std::string& folder,
                                  const std::vector<std::string>& more = {});

}  // namespace mle

#endif  // TESTS_APPS_COMMAND_RUNNER_H_
