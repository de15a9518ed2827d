#include "apps/common/process_faults.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "apps/common/command_line.h"
#include "gtest/gtest.h"
#include "mle/base/parallel.h"

namespace mle {
namespace {

// The limit is one of a user, and none for root.
void AllowNoOtherThread() {
  const rlimit one = {1, 1};
  if (::setrlimit(RLIMIT_NPROC, &one) != 0 ||
      (::getuid() == 0 && ::setuid(54321) != 0)) {
    ::_exit(kExitBadInput);
  }
}

// Runs `body`, whose exceptions nobody catches, in a process that may have one
// thread, and ends it.
template <typename Body>
[[noreturn]] void RunWithOneThread(const Body& body) noexcept {
  PrepareForFaults();
  AllowNoOtherThread();
  body();
  ::_exit(kExitDone);
}

class ProcessFaultsTest : public ::testing::Test {
 protected:
  // Processes of their own, that have no threads yet.
  ProcessFaultsTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

constexpr char kNoMore[] = "^error: the system gives no more threads; .*";

TEST_F(ProcessFaultsTest, NoThreadEndsTheProgramWithAMessage) {
  EXPECT_EXIT(RunWithOneThread([] { std::thread([] {}).join(); }),
              ::testing::ExitedWithCode(kExitNotUsable), kNoMore);
}

TEST_F(ProcessFaultsTest, NoThreadForALoopIsSaidInTheSameWay) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one processor";
  EXPECT_EXIT(RunWithOneThread([] {
                ParallelFor(100, 0, [](int) {
                  std::this_thread::sleep_for(std::chrono::milliseconds(1));
                });
              }),
              ::testing::ExitedWithCode(kExitNotUsable), kNoMore);
}

TEST_F(ProcessFaultsTest, OneThreadNeedsNoOther) {
  EXPECT_EXIT(RunWithOneThread([] { ParallelFor(100, 1, [](int) {}); }),
              ::testing::ExitedWithCode(kExitDone), "");
}

}  // namespace
}  // namespace mle
