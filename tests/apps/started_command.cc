#include "tests/apps/started_command.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "glog/logging.h"
#include "gtest/gtest.h"

namespace mle {

StartedCommand::StartedCommand(const std::string& command,
                               const std::vector<std::string>& arguments,
                               const std::string& log) {
  std::vector<std::string> words = {command};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> line;
  for (std::string& word : words) line.push_back(word.data());
  line.push_back(nullptr);
  process_ = ::fork();
  PCHECK(process_ >= 0) << "no process for " << command;
  if (process_ != 0) return;
  const int file =
      ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::execv(line[0], line.data());
  ::_exit(127);
}

StartedCommand::~StartedCommand() {
  if (process_ <= 0) return;
  Send(SIGKILL);
  ExitCode();
}

void StartedCommand::Send(int signal) const { ::kill(process_, signal); }

bool StartedCommand::HasEnded() const {
  siginfo_t info = {};
  return ::waitid(P_PID, static_cast<id_t>(process_), &info,
                  WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == process_;
}

void StartedCommand::Await(const std::function<bool()>& happened) const {
  while (!happened() && !HasEnded()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

int StartedCommand::ExitCode() {
  int status = 0;
  EXPECT_EQ(::waitpid(process_, &status, 0), process_);
  process_ = 0;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace mle
