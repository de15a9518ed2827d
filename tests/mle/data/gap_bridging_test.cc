#include <random>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/data/record_collector.h"

namespace mle {
namespace {

// One output that rises by 1 a sample, its set point, and one input.
Record RecordOf(const Eigen::RowVectorXd& input) {
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::RowVectorXd::LinSpaced(
      input.size(), 0.0, static_cast<double>(input.size() - 1));
  record.set_points = record.outputs;
  record.inputs = input;
  return record;
}

// Moves at random, every `period` samples from `phase` on.
Eigen::RowVectorXd MovesEvery(int period, int phase, int samples) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> move(-1.0, 1.0);
  Eigen::RowVectorXd input(samples);
  double level = 0.0;
  for (int k = 0; k < samples; ++k) {
    if (k % period == phase) level += move(random);
    input(k) = level;
  }
  return input;
}

TEST(BridgeGapsTest, SetPointsAreHeldOutputsStayBad) {
  Record record = RecordOf(Eigen::RowVectorXd::Zero(10));
  record.outputs(3) = record.outputs(4) = kNaN;
  record.set_points(3) = record.set_points(4) = kNaN;
  EXPECT_EQ(BridgeGaps(5, record), std::vector<int>({0, 2, 0}));
  EXPECT_EQ(record.outputs.array().isFinite().count(), 8);
  EXPECT_EQ(record.set_points(3), 2.0);
  EXPECT_EQ(record.set_points(4), 2.0);
}

TEST(BridgeGapsTest, LongGapsAndEndsStay) {
  Record record = RecordOf(Eigen::RowVectorXd::Zero(12));
  for (const int k : {0, 4, 5, 6, 11}) record.inputs(k) = kNaN;
  EXPECT_EQ(BridgeGaps(2, record), std::vector<int>({0, 0, 0}));
  EXPECT_EQ(record.inputs.array().isFinite().count(), 7);
  EXPECT_EQ(BridgeGaps(3, record), std::vector<int>({0, 0, 3}));
  EXPECT_EQ(record.inputs.array().isFinite().count(), 10);
}

// With one instant in the gap nothing is unknown, wherever the gap lies.
TEST(BridgeGapsTest, AHeldInputIsWhatItWas) {
  for (const int period : {2, 3, 5}) {
    for (int phase = 0; phase < period; ++phase) {
      const Eigen::RowVectorXd input = MovesEvery(period, phase, 80);
      for (int missing = 1; missing < period; ++missing) {
        for (int first = 1; first + missing < 80; ++first) {
          Record record = RecordOf(input);
          record.inputs.middleCols(first, missing).setConstant(kNaN);
          EXPECT_EQ(BridgeGaps(5, record)[2], missing);
          EXPECT_EQ(record.inputs, input)
              << period << phase << missing << first;
        }
      }
    }
  }
}

TEST(BridgeGapsTest, OfTwoMovesInAGapTheLastIsKnown) {
  const Eigen::RowVectorXd input = MovesEvery(2, 0, 80);
  Record record = RecordOf(input);
  record.inputs.middleCols(41, 4).setConstant(kNaN);  // moves at 42 and 44
  BridgeGaps(5, record);
  EXPECT_EQ(record.inputs(41), input(40));
  EXPECT_EQ(record.inputs(42), input(40));
  EXPECT_EQ(record.inputs(43), input(40));
  EXPECT_EQ(record.inputs(44), input(45));
}

TEST(BridgeGapsTest, FewMovesOrOnesAtAnyInstantShowNothing) {
  Eigen::RowVectorXd few = MovesEvery(2, 0, 80);
  few.tail(80 - 21).setConstant(few(20));  // ten moves seen, at 2 to 20
  Eigen::RowVectorXd any = MovesEvery(2, 0, 80);
  any.tail(9).array() += 1.0;  // at 71
  for (const Eigen::RowVectorXd& input : {few, any}) {
    Record record = RecordOf(input);
    record.inputs(10) = kNaN;  // where it moves
    BridgeGaps(5, record);
    EXPECT_EQ(record.inputs(10), input(9));
  }
}

// A step between the instants that happened in the gap.
TEST(BridgeGapsTest, WithoutAnInstantInTheGapItIsHeld) {
  Eigen::RowVectorXd input = MovesEvery(4, 0, 80);
  input.tail(80 - 42).array() += 1.0;
  Record record = RecordOf(input);
  record.inputs(41) = record.inputs(42) = kNaN;
  BridgeGaps(5, record);
  EXPECT_EQ(record.inputs(41), input(40));
  EXPECT_EQ(record.inputs(42), input(40));
}

}  // namespace
}  // namespace mle
