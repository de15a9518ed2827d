#include "apps/common/process_faults.h"

#include <poll.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>

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

// That a thread could not be started, as the standard library and TBB, which
// has no type of its own for it, say so.
bool IsLackOfThreads(const std::runtime_error& fault) {
  const auto* const error = dynamic_cast<const std::system_error*>(&fault);
  return error != nullptr
             ? error->code() == std::errc::resource_unavailable_try_again
             : std::string_view(fault.what()).starts_with("pthread_create");
}

// Nothing of ours throws: what arrives here is the lack of memory or of
// threads, or a fault of the program, which shall leave its traces as ever.
[[noreturn]] void Terminate() {
  try {
    if (const std::exception_ptr fault = std::current_exception()) {
      std::rethrow_exception(fault);
    }
  } catch (const std::bad_alloc&) {
    Say("error: out of memory; existing files are unchanged. Provide more "
        "memory, or use fewer samples, lags or threads\n");
    ::_exit(kExitNotUsable);
  } catch (const std::runtime_error& fault) {
    if (IsLackOfThreads(fault)) {
      Say("error: the system gives no more threads; existing files are "
          "unchanged. Allow more (ulimit -u shows the limit), or use "
          "--threads=1\n");
      ::_exit(kExitNotUsable);
    }
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

// Temporaries of 128 kB stand on the stack, some upon others. Raises the limit
// as far as it may be, also for threads; ends the program with a message where
// that is not enough.
void ProvideStack() {
  constexpr rlim_t kUsual = rlim_t{8} << 20;
  constexpr rlim_t kLeast = rlim_t{1} << 20;
  rlimit stack = {};
  if (::getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur >= kUsual) {
    return;
  }
  stack.rlim_cur = std::min(kUsual, stack.rlim_max);
  if (stack.rlim_cur < kLeast || ::setrlimit(RLIMIT_STACK, &stack) != 0) {
    Say("error: the stack is limited to less than 1 MB (ulimit -s shows the "
        "limit in kB); use ulimit -s 8192\n");
    ::_exit(kExitNotUsable);
  }
  pthread_attr_t attributes;
  if (::pthread_getattr_default_np(&attributes) != 0) return;
  ::pthread_attr_setstacksize(&attributes, kUsual);
  ::pthread_setattr_default_np(&attributes);
  ::pthread_attr_destroy(&attributes);
}

}  // namespace

void PrepareForFaults() {
  ProvideStack();
  std::signal(SIGXFSZ, SIG_IGN);
  // Who stops reading (head, a pager) does not end the command: files are
  // written all the same.
  std::signal(SIGPIPE, SIG_IGN);
  usual_handler = std::set_terminate(Terminate);
  ::on_exit(AtExit, nullptr);
}

namespace {

std::atomic<bool> g_stop{false};

extern "C" void StopOnSignal(int /*signal*/) { g_stop = true; }

}  // namespace

void CatchStopSignals() {
  struct sigaction action = {};
  action.sa_handler = StopOnSignal;
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A terminal that is closed stops a command, unless nohup has it ignored.
  struct sigaction before = {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

bool StopRequested() { return g_stop.load(); }

}  // namespace mle
