#include "mle/maintain/window_agreement.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/base/random.h"
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

// Adds a random walk to the output.
void Drift(Record& record, double deviation, int seed) {
  const Eigen::MatrixXd steps =
      GaussianNoise(static_cast<std::uint64_t>(seed) + 1000, 0,
                    kMeasurementNoise)
          .DrawMatrix(1, record.samples(), deviation);
  double level = 0.0;
  for (int k = 0; k < record.samples(); ++k) {
    level += steps(0, k);
    record.outputs(0, k) += level;
  }
}

// 60 changes of the set point, 26 samples apart, under a PI controller that
// answers noise as it does the set point.
Record ControlledTank(double noise, std::uint64_t seed) {
  constexpr int kSamples = 60 * 26;
  constexpr int kDelay = 3;
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Zero(1, kSamples);
  record.outputs =
      GaussianNoise(seed, 0, kMeasurementNoise).DrawMatrix(1, kSamples, noise);
  record.set_points = Eigen::MatrixXd::Zero(1, kSamples);
  const double decay = std::exp(-0.1);
  double level = 0.0;
  double integral = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    record.set_points(0, k) = (k / 26) % 4 < 2 ? 0.0 : 1.0;
    record.outputs(0, k) += level;
    const double error = record.set_points(0, k) - record.outputs(0, k);
    integral += 0.05 * error;
    record.inputs(0, k) = 0.7 * error + integral;
    level *= decay;
    if (k >= kDelay) level += (1.0 - decay) * record.inputs(0, k - kDelay);
  }
  return record;
}

// A record cut into adjoining windows.
std::vector<Record> Parts(const Record& record, int length) {
  std::vector<Record> parts;
  for (int first = 0; first < record.samples(); first += length) {
    Record part = record;
    part.start_time = record.time(first);
    part.inputs = record.inputs.middleCols(first, length);
    part.outputs = record.outputs.middleCols(first, length);
    part.set_points = record.set_points.middleCols(first, length);
    parts.push_back(std::move(part));
  }
  return parts;
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

// What inputs did before a window acts in it, and is known; outputs are not.
TEST(WindowAgreementTest, ALeadIsNoPartOfAWindow) {
  constexpr int kLead = 100;
  Record record = TankRecord(Tank(1.0), 0.0, 1);
  for (const int begin : {150, 400, 650}) {
    record.inputs.middleCols(begin - 12, 10).array() +=
        begin == 400 ? -20.0 : 20.0;
    record.inputs.middleCols(begin + 10, 30).array() += 1.0;
  }
  record.outputs = *SimulateResponse(Tank(1.0), 0.5, record.inputs) +
                   GaussianNoise(6, 0, kMeasurementNoise)
                       .DrawMatrix(1, record.samples(), 0.02);
  std::vector<Record> windows;
  for (const int begin : {150, 400, 650}) {
    windows.push_back(*CutWindow(record, begin, 0.5 * kLead, 0.5 * 99));
    windows.back().outputs.leftCols(kLead).setConstant(
        std::numeric_limits<double>::quiet_NaN());
  }
  const WindowAgreement agreement = Agreement(windows);
  EXPECT_TRUE(agreement.agree()) << agreement.p_value;
  // It was tested at all.
  EXPECT_LT(agreement.p_value, 1.0);
}

TEST(WindowAgreementTest, DriftIsNoDisagreement) {
  int doubts = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Record> windows;
    for (int w = 0; w < 4; ++w) {
      windows.push_back(Window(1.0, kLevels[w], 4 * trial + w));
      Drift(windows.back(), 0.002, 4 * trial + w);
    }
    const WindowAgreement agreement = Agreement(windows);
    EXPECT_TRUE(agreement.agree()) << trial << ": " << agreement.p_value;
    if (agreement.p_value < 0.1) ++doubts;
  }
  EXPECT_LE(doubts, 6);
}

TEST(WindowAgreementTest, WindowsShorterThanTheResponseAreJoined) {
  const std::vector<Record> windows = Parts(ControlledTank(0.1, 7), 26);
  ASSERT_EQ(windows.size(), 60);
  const WindowAgreement agreement = Agreement(windows);
  EXPECT_GT(agreement.p_value, 1e-4);
  // 13 samples of dead time and lag, five times of these in three windows.
  EXPECT_EQ(agreement.windows, 20);
  // A row of ten elements asks for 15 times these.
  ProcessModel wide("tank", "min", std::vector<InputChannel>(10),
                    {OutputChannel{"level", "m"}});
  std::vector<Record> many = windows;
  for (int j = 0; j < 10; ++j) {
    wide.element(0, j) = Tank(1.0).element(0, 0);
  }
  for (Record& window : many) {
    window.inputs = window.inputs.replicate(10, 1).eval();
  }
  EXPECT_EQ(Agreement(many, wide).windows, 7);
}

TEST(WindowAgreementTest, NoiseIsNoDifference) {
  // A gain is off by 11 % in a window, the larger one of two by 12 %, and what
  // exceeds 11 % in mean squares by 4 %.
  double sum = 0.0;
  for (int trial = 0; trial < 40; ++trial) {
    sum += Agreement({Window(1.0, 0.0, 2 * trial, 2.0),
                      Window(1.0, 0.0, 2 * trial + 1, 2.0)})
               .difference;
  }
  EXPECT_LT(sum / 40.0, 0.06);
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
