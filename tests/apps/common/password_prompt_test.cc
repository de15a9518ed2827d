// A password asked for on a terminal, which does not show it.

#include "apps/common/password_prompt.h"

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// What the terminal shows until `end`.
std::string ReadUntil(int terminal, const std::string& end) {
  std::string shown;
  char c = 0;
  while (shown.find(end) == std::string::npos && read(terminal, &c, 1) == 1) {
    shown += c;
  }
  return shown;
}

TEST(PasswordPromptTest, IsReadAndNotShown) {
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::optional<std::string> password = AskPassword("Word of plant: ");
    const bool is_right = password == std::optional<std::string>("ge heim\"4");
    // The echo is back.
    std::string line(2, ' ');
    if (read(STDIN_FILENO, line.data(), 2) != 2 || line != "x\n") _exit(2);
    _exit(is_right ? 0 : 1);
  }
  std::string shown = ReadUntil(terminal, "Word of plant: ");
  const std::string typed = "ge heim\"4\n";
  ASSERT_EQ(write(terminal, typed.data(), typed.size()),
            static_cast<ssize_t>(typed.size()));
  shown += ReadUntil(terminal, "\n");
  ASSERT_EQ(write(terminal, "x\n", 2), 2);
  shown += ReadUntil(terminal, "x");
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  close(terminal);
  EXPECT_EQ(status, 0);
  EXPECT_THAT(shown, HasSubstr("Word of plant: "));
  EXPECT_THAT(shown, Not(HasSubstr("heim")));
}

TEST(PasswordPromptTest, NobodyIsAskedWithoutATerminal) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    setsid();  // which leaves the terminal
    _exit(AskPassword("Word: ").has_value() ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace mle
