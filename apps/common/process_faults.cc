#include "apps/common/process_faults.h"

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
    Say("error: out of memory; files that were there are as they were. Give "
        "the command more, or fewer samples, lags or threads\n");
    ::_exit(kExitNotUsable);
  } catch (...) {
  }
  if (usual_handler != nullptr) usual_handler();
  std::abort();
}

void CheckOutput() {
  if (std::cout.flush()) return;
  Say("error: cannot write to standard output\n");
  ::_exit(kExitNotUsable);
}

}  // namespace

void PrepareForFaults() {
  std::signal(SIGXFSZ, SIG_IGN);
  usual_handler = std::set_terminate(Terminate);
  std::atexit(CheckOutput);
}

}  // namespace mle
