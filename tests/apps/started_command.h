// A command that runs while its test goes on: to be watched, held and killed.

#ifndef TESTS_APPS_STARTED_COMMAND_H_
#define TESTS_APPS_STARTED_COMMAND_H_

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace mle {

class StartedCommand {
 public:
  // What it writes to standard output and error is added to the file `log`.
  StartedCommand(const std::string& command,
                 const std::vector<std::string>& arguments,
                 const std::string& log);
  // Kills the command if nobody has waited for it.
  ~StartedCommand();
  StartedCommand(const StartedCommand&) = delete;
  StartedCommand& operator=(const StartedCommand&) = delete;

  void Send(int signal) const;
  bool HasEnded() const;
  // Returns as soon as `happened`, or when the command has ended without it.
  void Await(const std::function<bool()>& happened) const;
  // Waits for its end: its exit code, or 128 + the signal that ended it.
  int ExitCode();

 private:
  pid_t process_ = 0;  // 0 once it has been waited for.
};

}  // namespace mle

#endif  // TESTS_APPS_STARTED_COMMAND_H_
