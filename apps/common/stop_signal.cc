#include "apps/common/stop_signal.h"

#include <atomic>
#include <csignal>

namespace mle {
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
