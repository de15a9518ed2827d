#include "mle/data/input_spikes.h"

#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/data/loop_records.h"

namespace mle {
namespace {

using testing::LoopRecord;

// At a move, between moves, with a controller that moves at every sample or at
// every fifth.
TEST(InputSpikesTest, FindsASpike) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const int period : {1, 5}) {
      for (const int at : {1230, 1231, 1234}) {
        Record record = LoopRecord({.period = period, .seed = seed});
        const double usual = record.inputs(1, at);
        record.inputs(1, at) += 3.0;
        const std::vector<InputSpike> spikes = FindInputSpikes(record, 1);
        ASSERT_EQ(spikes.size(), 1u) << period << " " << at;
        EXPECT_EQ(spikes[0].sample, at);
        EXPECT_NEAR(spikes[0].usual, usual, period == 1 ? 0.1 : 1e-12);
        EXPECT_TRUE(FindInputSpikes(record, 0).empty());
      }
    }
  }
}

TEST(InputSpikesTest, LeavesWhatControllersDo) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const int period : {1, 2, 5, 50}) {
      for (const double walk : {0.0, 0.01}) {
        Record record =
            LoopRecord({.walk = walk, .period = period, .seed = seed});
        for (int j = 0; j < 2; ++j) {
          EXPECT_TRUE(FindInputSpikes(record, j).empty()) << period;
        }
        testing::Quantise(0.01, record.inputs);
        for (int j = 0; j < 2; ++j) {
          EXPECT_TRUE(FindInputSpikes(record, j).empty()) << period;
        }
      }
    }
  }
}

// The kick of a controller of one period at a change of set point.
TEST(InputSpikesTest, LeavesKicksAtSetPointChanges) {
  Record record = LoopRecord({.period = 1});
  record.inputs(0, 500) += 5.0;
  EXPECT_TRUE(FindInputSpikes(record, 0).empty());
  record.inputs(0, 700) += 5.0;
  ASSERT_EQ(FindInputSpikes(record, 0).size(), 1u);
}

TEST(InputSpikesTest, LeavesStepsAndConstants) {
  Record record = LoopRecord();
  record.inputs.row(0).setConstant(2.0);
  record.inputs.row(1).head(300).setConstant(1.0);
  record.inputs.row(1).tail(3700).setConstant(4.0);
  EXPECT_TRUE(FindInputSpikes(record, 0).empty());
  EXPECT_TRUE(FindInputSpikes(record, 1).empty());
}

TEST(InputSpikesTest, KnowsThePeriod) {
  for (const int period : {1, 2, 5, 50}) {
    int phase = -1;
    EXPECT_EQ(MovePeriod(LoopRecord({.period = period}), 0, phase), period);
    EXPECT_EQ(phase, 0);
  }
}

}  // namespace
}  // namespace mle
