#include "apps/common/progress.h"

#include <sstream>

#include "gtest/gtest.h"

namespace mle {
namespace {

TEST(StatusLineTest, IsOneRewrittenLineOnATerminal) {
  std::ostringstream out;
  StatusLine line(out, true, 100.0);
  line.Show("too early", 101.0);
  EXPECT_EQ(out.str(), "");
  line.Show("first", 102.5);
  line.Show("too soon", 102.55);
  line.Show("second", 103.0);
  EXPECT_EQ(out.str(), "\rfirst\x1b[K\rsecond\x1b[K");
  line.End();
  line.End();
  EXPECT_EQ(out.str(), "\rfirst\x1b[K\rsecond\x1b[K\r\x1b[K");
}

TEST(StatusLineTest, IsALineEveryTenSecondsInALog) {
  std::ostringstream out;
  StatusLine line(out, false, 0.0);
  for (int second = 0; second < 35; ++second) {
    line.Show("at " + std::to_string(second), second);
  }
  line.End();
  EXPECT_EQ(out.str(), "at 10\nat 20\nat 30\n");
}

TEST(SpelledDurationTest, ChoosesTheUnit) {
  EXPECT_EQ(SpelledDuration(40.0), "40 s");
  EXPECT_EQ(SpelledDuration(420.0), "7 min");
  EXPECT_EQ(SpelledDuration(12600.0), "3.5 h");
}

}  // namespace
}  // namespace mle
