#include "apps/common/password_prompt.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>

namespace mle {
namespace {

// The terminal of the process, and its echo off for as long as this lives.
class SilentTerminal {
 public:
  SilentTerminal() : file_(open("/dev/tty", O_RDWR | O_CLOEXEC)) {
    is_open_ = file_ >= 0 && tcgetattr(file_, &before_) == 0;
    if (!is_open_) return;
    termios silent = before_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    is_open_ = tcsetattr(file_, TCSAFLUSH, &silent) == 0;
  }
  ~SilentTerminal() {
    ShowAgain();
    if (file_ >= 0) close(file_);
  }
  SilentTerminal(const SilentTerminal&) = delete;
  SilentTerminal& operator=(const SilentTerminal&) = delete;

  bool is_open() const { return is_open_; }

  // The echo as it was; what was typed after the line stays to be read.
  void ShowAgain() {
    if (is_open_) tcsetattr(file_, TCSADRAIN, &before_);
  }

  bool Write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t size = write(file_, text.data(), text.size());
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(size));
    }
    return true;
  }

  std::optional<std::string> ReadLine() const {
    std::string line;
    while (true) {
      char c = 0;
      const ssize_t size = read(file_, &c, 1);
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) return std::nullopt;
      if (c == '\n') return line;
      line += c;
    }
  }

 private:
  int file_;
  bool is_open_ = false;
  termios before_ = {};
};

}  // namespace

std::optional<std::string> AskPassword(const std::string& prompt) {
  SilentTerminal terminal;
  if (!terminal.is_open() || !terminal.Write(prompt)) return std::nullopt;
  std::optional<std::string> password = terminal.ReadLine();
  terminal.ShowAgain();
  terminal.Write("\n");
  return password;
}

}  // namespace mle
