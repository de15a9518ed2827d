#include "apps/common/process_faults.h"

#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string_view>

#include "apps/common/command_line.h"

namespace mle {
namespace {

// Without memory and without streams.
void Say(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::terminate_handler usual_handler = nullptr;

// Nothing of ours throws: what arrives here is the lack of memory, or a fault
// of the program, which shall leave its traces as ever.
[[noreturn]] void Terminate() {
  try {
    if (const std::exception_ptr fault = std::current_exception()) {
      std::rethrow_exception(fault);
    }
  } catch (const std::bad_alloc&) {
    Say("error: out of memory; existing files are unchanged. Provide more "
        "memory, or use fewer samples, lags or threads\n");
    ::_exit(kExitNotUsable);
  } catch (...) {
  }
  if (usual_handler != nullptr) usual_handler();
  std::abort();
}

// Where standard output is a pipe: whether nobody reads it any more.
bool ReaderIsGone() {
  pollfd out = {STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

void AtExit(int exit_code, void*) {
  if (!std::cout.flush() && !ReaderIsGone()) {
    Say("error: cannot write to standard output\n");
    ::_exit(kExitNotUsable);
  }
  // A thread of OpenBLAS (which may stand behind LAPACK, and that behind Ceres)
  // that finds no memory for its buffer tries for ever, and the library waits
  // for it when the program ends. All is written by now.
  rlimit memory = {};
  if (::getrlimit(RLIMIT_AS, &memory) == 0 &&
      memory.rlim_cur != RLIM_INFINITY) {
    std::cerr.flush();
    ::_exit(exit_code);
  }
}

}  // namespace

void PrepareForFaults() {
  std::signal(SIGXFSZ, SIG_IGN);
  // Who stops reading (head, a pager) does not end the command: files are
  // written all the same.
  std::signal(SIGPIPE, SIG_IGN);
  usual_handler = std::set_terminate(Terminate);
  ::on_exit(AtExit, nullptr);
}

}  // namespace mle
