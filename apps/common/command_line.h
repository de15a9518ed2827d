// How every command starts and ends, and how its results are had again.
//
// Exit codes: 0 done; 1 ran, but the result is not usable; 2 bad input or
// flags.

#ifndef APPS_COMMON_COMMAND_LINE_H_
#define APPS_COMMON_COMMAND_LINE_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/report/html.h"
#include "mle/base/folder_lock.h"

namespace mle {

inline constexpr int kExitDone = 0;
inline constexpr int kExitNotUsable = 1;
inline constexpr int kExitBadInput = 2;

// Parses the flags; answers --help and --version (exit code 0) and unknown
// flags, stray arguments, values that cannot be read (exit code 2) itself.
void StartCommand(const std::string& usage, OptionTable& table, int argc,
                  char** argv);

// Prints the failure and gives its exit code: 1 for FailedPrecondition,
// Internal and ResourceExhausted, else 2.
int Fail(const absl::Status& status);

// The whole of a command: reads its options, then does what `run` does. Gives
// the exit code; a failure is printed.
template <typename Request>
int RunCommand(const char* usage,
               void (*add_options)(Request& request, OptionTable& table),
               absl::StatusOr<int> (*run)(Request& request, OptionTable& table),
               int argc, char** argv) {
  Request request;
  OptionTable table;
  add_options(request, table);
  StartCommand(usage, table, argc, argv);
  const absl::StatusOr<int> code = run(request, table);
  return code.ok() ? *code : Fail(code.status());
}

// The command line as it was given, for a shell.
std::string CommandLine();

// "error: message" on standard error, in one line whatever is quoted in it.
void SayError(const std::string& message);

// Makes the folder that --out names, and locks it against other commands as
// long as the lock lasts. InvalidArgument, naming --out, if that fails.
absl::StatusOr<FolderLock> ClaimOutputFolder(const std::string& folder);

// Threads that gain something: `asked`, but no more than there are processors.
int UsableThreads(int asked);

using NamesAndValues = std::vector<std::pair<std::string, std::string>>;

// The options that shape results: all but out, part, threads, verbose and json.
NamesAndValues ShapingResults(NamesAndValues options);

// The same of all flags of the command that was started.
NamesAndValues ResultFlags();

// Command line, version, seeds (the first and the last, if there are any) and
// flags. `checksums`: names and values that come before the flags.
report::RunAgain HowToRunAgain(const std::vector<std::uint64_t>& seeds,
                               NamesAndValues checksums = {});

// The same for a run that was not started as a command: the call and its
// options.
report::RunAgain HowToCallAgain(const std::string& call,
                                const NamesAndValues& options,
                                NamesAndValues checksums);

}  // namespace mle

#endif  // APPS_COMMON_COMMAND_LINE_H_
