#include "mle/maintain/window_agreement.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using Cause = WindowAgreement::Cause;
using testing::Tank;
using testing::TankRecord;

// A window at an operating point, one after the other with some time between.
Record Window(double gain, double level, int place, double noise = 0.02) {
  Record window =
      TankRecord(Tank(gain), noise, static_cast<std::uint64_t>(place) + 1);
  window.outputs.array() += level;
  window.start_time = 600.0 * place;
  return window;
}

WindowAgreement Agreement(const std::vector<Record>& windows,
                          const ProcessModel& model = Tank(1.0)) {
  const auto agreement = TestWindowAgreement(model, windows);
  EXPECT_TRUE(agreement.ok()) << agreement.status();
  return agreement->front();
}

// Levels that come back, so that they are not time.
constexpr double kLevels[] = {2.0, -1.0, 1.5, -2.0, 0.5, -1.5};

TEST(WindowAgreementTest, WindowsOfOnePlantAgree) {
  int doubts = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Record> windows;
    for (int w = 0; w < 4; ++w) {
      windows.push_back(Window(1.3, kLevels[w], 10 * trial + w, 0.2));
    }
    // The model's gain may be wrong: windows agree on another.
    const WindowAgreement agreement = Agreement(windows);
    EXPECT_TRUE(agreement.agree()) << trial;
    if (agreement.p_value < 0.1) ++doubts;
  }
  // Two are to be expected.
  EXPECT_LE(doubts, 6);
}

TEST(WindowAgreementTest, AgeingDuringTheRecordFollowsTime) {
  std::vector<Record> windows;
  for (int w = 0; w < 6; ++w) {
    windows.push_back(Window(1.0 + 0.08 * w, kLevels[w], w));
  }
  const WindowAgreement agreement = Agreement(windows);
  EXPECT_FALSE(agreement.agree());
  EXPECT_EQ(agreement.cause, Cause::kTime);
  EXPECT_NEAR(agreement.difference, 0.2 / 1.2, 0.03);
  EXPECT_NE(agreement.Describe("level").find("follow time"), std::string::npos);
}

TEST(WindowAgreementTest, AValveFollowsTheOperatingPoint) {
  std::vector<Record> windows;
  for (int w = 0; w < 6; ++w) {
    windows.push_back(Window(1.0 + 0.08 * kLevels[w], kLevels[w], w));
  }
  const WindowAgreement agreement = Agreement(windows);
  EXPECT_FALSE(agreement.agree());
  EXPECT_EQ(agreement.cause, Cause::kOperatingPoint);
  EXPECT_NE(agreement.Describe("level").find("operating point, not time"),
            std::string::npos);
}

TEST(WindowAgreementTest, FewWindowsDoNotTellWhy) {
  const WindowAgreement agreement = Agreement(
      {Window(1.0, 2.0, 0), Window(1.3, -1.0, 1), Window(1.3, 1.0, 2)});
  EXPECT_FALSE(agreement.agree());
  EXPECT_EQ(agreement.cause, Cause::kUnknown);
  EXPECT_NE(agreement.Describe("level").find("Four windows"),
            std::string::npos);
  // Where operating points move with time, more windows do not tell either.
  std::vector<Record> windows;
  for (int w = 0; w < 6; ++w) {
    windows.push_back(Window(1.0 + 0.08 * w, 0.5 * w, w));
  }
  EXPECT_FALSE(Agreement(windows).agree());
  EXPECT_EQ(Agreement(windows).cause, Cause::kUnknown);
}

TEST(WindowAgreementTest, SmallDifferencesAndOneWindowAreNone) {
  EXPECT_TRUE(Agreement({Window(1.0, 0.0, 0)}).agree());
  const WindowAgreement small =
      Agreement({Window(1.0, 0.0, 0, 0.001), Window(1.03, 0.0, 1, 0.001)});
  EXPECT_LT(small.p_value, 1e-6);
  EXPECT_TRUE(small.agree());
}

TEST(WindowAgreementTest, LostSamplesAreBridged) {
  std::vector<Record> windows = {Window(1.0, 2.0, 0), Window(1.4, -1.0, 1)};
  for (Record& window : windows) {
    window.outputs(0, 300) = std::numeric_limits<double>::quiet_NaN();
  }
  EXPECT_FALSE(Agreement(windows).agree());
}

}  // namespace
}  // namespace mle
