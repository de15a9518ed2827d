#include "apps/report/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

extern char** environ;

namespace mle::report {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::string Reason(int error) { return std::generic_category().message(error); }

// A nameless file, not passed on to the processes others start meanwhile.
// Files rather than pipes: the program can neither block on us nor we on it.
File MakeFile() {
  File file(std::tmpfile());
  if (file != nullptr) fcntl(fileno(file.get()), F_SETFD, FD_CLOEXEC);
  return file;
}

std::string ReadAll(std::FILE* file) {
  std::rewind(file);
  std::string content;
  std::array<char, 65536> buffer;
  while (const std::size_t n =
             std::fread(buffer.data(), 1, buffer.size(), file)) {
    content.append(buffer.data(), n);
  }
  return content;
}

std::vector<std::string> Environment(const std::vector<std::string>& more) {
  std::vector<std::string> variables = more;  // the first of a name counts
  for (char** at = environ; *at != nullptr; ++at) {
    const std::string_view variable = *at;
    if (variable.starts_with("LC_") || variable.starts_with("LANG") ||
        variable.starts_with("TZ=")) {
      continue;
    }
    variables.emplace_back(variable);
  }
  variables.emplace_back("LC_ALL=C.UTF-8");
  variables.emplace_back("TZ=UTC");
  return variables;
}

std::vector<char*> Pointers(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& string : strings) pointers.push_back(string.data());
  pointers.push_back(nullptr);
  return pointers;
}

// The exit code of a child once it has ended, 128 plus the signal that ended
// it; nothing if it still runs after `limit`.
std::optional<int> WaitFor(pid_t child, absl::Duration limit) {
  const bool forever = limit == absl::InfiniteDuration();
  using Clock = std::chrono::steady_clock;  // the time of day may be set
  const Clock::time_point begin = Clock::now();
  for (absl::Duration pause = absl::Milliseconds(1);;
       pause = std::min(2 * pause, absl::Milliseconds(20))) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, forever ? 0 : WNOHANG);
    if (ended < 0 && errno != EINTR) return 127;
    if (ended == child) {
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    if (!forever && absl::FromChrono(Clock::now() - begin) >= limit) {
      return std::nullopt;
    }
    if (!forever) absl::SleepFor(pause);
  }
}

}  // namespace

absl::StatusOr<ProcessResult> RunProcess(
    const std::string& program, const std::vector<std::string>& arguments,
    std::string_view input, const ProcessOptions& options) {
  const File in = MakeFile();
  const File out = MakeFile();
  const File err = MakeFile();
  if (in == nullptr || out == nullptr || err == nullptr ||
      std::fwrite(input.data(), 1, input.size(), in.get()) != input.size() ||
      std::fflush(in.get()) != 0) {
    return absl::InternalError("a temporary file cannot be written: " +
                               Reason(errno));
  }
  std::rewind(in.get());

  std::vector<std::string> argument_strings = {program};
  argument_strings.insert(argument_strings.end(), arguments.begin(),
                          arguments.end());
  std::vector<std::string> variables = Environment(options.variables);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, program.c_str(), &actions, nullptr,
                                 Pointers(argument_strings).data(),
                                 Pointers(variables).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) {
    return absl::NotFoundError(program + " is not installed");
  }
  if (error != 0) {
    return absl::InternalError(program + " cannot be run: " + Reason(error));
  }
  const std::optional<int> exit_code = WaitFor(child, options.time_limit);
  if (!exit_code.has_value()) {
    kill(child, SIGKILL);
    WaitFor(child, absl::InfiniteDuration());
    return absl::DeadlineExceededError(
        absl::StrCat(program, " did not end within ",
                     absl::FormatDuration(options.time_limit)));
  }
  ProcessResult result;
  result.exit_code = *exit_code;
  result.out = ReadAll(out.get());
  result.err = ReadAll(err.get());
  return result;
}

}  // namespace mle::report
