// How every command starts and ends.
//
// Exit codes: 0 done; 1 ran, but the result is not usable; 2 bad input or
// flags.

#ifndef APPS_COMMON_COMMAND_LINE_H_
#define APPS_COMMON_COMMAND_LINE_H_

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "mle/base/folder_lock.h"

namespace mle {

inline constexpr int kExitDone = 0;
inline constexpr int kExitNotUsable = 1;
inline constexpr int kExitBadInput = 2;

// Parses the flags; answers --help and --version (exit code 0) and unknown
// flags, stray arguments, values that cannot be read (exit code 2) itself.
void StartCommand(const std::string& usage, OptionTable& table, int argc,
                  char** argv);

// The command line as it was given, for a shell.
std::string CommandLine();

// The names and values of all options of the command that was started.
std::vector<std::pair<std::string, std::string>> GivenOptions();

std::string_view Version();

// Prints the failure and gives its exit code: 1 for FailedPrecondition,
// Internal and ResourceExhausted, else 2.
int Fail(const absl::Status& status);

// "error: message" on standard error, in one line whatever is quoted in it.
void SayError(const std::string& message);

// Makes the folder that --out names, and locks it against other commands as
// long as the lock lasts. InvalidArgument, naming --out, if that fails.
absl::StatusOr<FolderLock> ClaimOutputFolder(const std::string& folder);

// Threads that gain something: `asked`, but no more than there are processors.
int UsableThreads(int asked);

}  // namespace mle

#endif  // APPS_COMMON_COMMAND_LINE_H_
