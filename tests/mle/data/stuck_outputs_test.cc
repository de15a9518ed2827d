#include "mle/data/stuck_outputs.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/data/loop_records.h"

namespace mle {
namespace {

using testing::LoopModel;
using testing::LoopRecord;

std::vector<StuckOutput> FindStuck(const Record& record) {
  return *FindStuckOutputs({record}, LoopModel());
}

TEST(StuckOutputsTest, FindsADeadSensor) {
  Record record = LoopRecord();
  record.outputs.row(1).setConstant(7.5);
  const std::vector<StuckOutput> stuck = FindStuck(record);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].output, 1);
  EXPECT_EQ(stuck[0].kind, StuckOutput::Kind::kDead);
  EXPECT_EQ(stuck[0].value, 7.5);
  EXPECT_NEAR(stuck[0].expected, 1.0, 0.3);
  EXPECT_EQ(stuck[0].samples(), record.samples());
}

// A sensor that was dead before anything moved.
TEST(StuckOutputsTest, FindsADeadSensorWhereMovesComeLate) {
  Record record = LoopRecord();
  record.outputs.row(1).setConstant(7.5);
  const auto rest = static_cast<Eigen::Index>(0.7 * record.samples());
  record.inputs.leftCols(rest).colwise() =
      Eigen::VectorXd(record.inputs.col(0));
  for (const bool has_gaps : {false, true}) {
    if (has_gaps) {
      for (Eigen::Index k = 100; k < record.samples(); k += 100) {
        record.outputs(1, k) = std::numeric_limits<double>::quiet_NaN();
      }
    }
    const std::vector<StuckOutput> stuck = FindStuck(record);
    ASSERT_EQ(stuck.size(), 1u) << has_gaps;
    EXPECT_EQ(stuck[0].kind, StuckOutput::Kind::kDead);
  }
}

TEST(StuckOutputsTest, FindsAClippedSensor) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Record record = LoopRecord({.seed = seed});
    record.outputs.row(0) = record.outputs.row(0).cwiseMin(0.6);
    const std::vector<StuckOutput> stuck = FindStuck(record);
    ASSERT_EQ(stuck.size(), 1u);
    EXPECT_EQ(stuck[0].kind, StuckOutput::Kind::kClipped);
    EXPECT_EQ(stuck[0].value, 0.6);
    for (const SampleRun& run : stuck[0].runs) EXPECT_GE(run.samples, 10);
  }
}

// Without noise nothing but the model tells rest from a freeze.
TEST(StuckOutputsTest, FindsAFreezeWithoutNoise) {
  Record record = LoopRecord({.noise = 0.0});
  record.outputs.row(0).segment(540, 120).setConstant(record.outputs(0, 540));
  const std::vector<StuckOutput> stuck = FindStuck(record);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].kind, StuckOutput::Kind::kFrozen);
  EXPECT_EQ(stuck[0].runs[0].first, 540);
}

TEST(StuckOutputsTest, LeavesCleanDriftingAndRoundedOutputs) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double walk : {0.0, 0.01}) {
      for (const double quantum : {0.0, 0.02, 0.1}) {
        Record record = LoopRecord({.walk = walk, .seed = seed});
        if (quantum > 0.0) testing::Quantise(quantum, record.outputs);
        EXPECT_TRUE(FindStuck(record).empty()) << walk << " " << quantum;
      }
    }
  }
}

// Dead times twice as long, gains halved, with and without noise and rounding:
// the plant is at rest when the model moves, but not for long.
TEST(StuckOutputsTest, LeavesAgedPlants) {
  ProcessModel aged = LoopModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const TransferFunction& g = aged.element(i, j);
      aged.element(i, j) =
          TransferFunction::FirstOrder((i == j ? 0.5 : 1.0) * g.StaticGain(),
                                       g.TimeConstant(), 2.0 * g.delay());
    }
  }
  for (const double noise : {0.0, 0.005}) {
    for (const double quantum : {0.0, 0.02}) {
      Record record =
          LoopRecord(aged, {.noise = noise}, StaticGains(LoopModel()));
      if (quantum > 0.0) testing::Quantise(quantum, record.outputs);
      EXPECT_TRUE(FindStuck(record).empty()) << noise << " " << quantum;
    }
  }
}

TEST(StuckOutputsTest, ToleratesMissingSamples) {
  Record record = LoopRecord();
  record.outputs.row(0).setConstant(std::nan(""));
  record.inputs.row(1).setConstant(std::nan(""));
  EXPECT_TRUE(FindStuck(record).empty());
}

}  // namespace
}  // namespace mle
