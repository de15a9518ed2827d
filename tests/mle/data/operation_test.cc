#include "mle/data/operation.h"

#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/data/loop_records.h"

namespace mle {
namespace {

using testing::LoopModel;
using testing::LoopRecord;

TEST(OperationTest, FindsTimeAtLimits) {
  Record record = LoopRecord({.noise = 0.2});
  record.inputs.row(0) = record.inputs.row(0).cwiseMin(0.5).cwiseMax(-0.02);
  const std::vector<TimeAtLimits> found = FindTimeAtLimits({record});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].input, 0);
  EXPECT_EQ(found[0].high, 0.5);
  EXPECT_NEAR(found[0].share_high,
              (record.inputs.row(0).array() == 0.5).cast<double>().mean(),
              1e-12);
}

TEST(OperationTest, LeavesInputsThatHaveNoLimits) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_TRUE(FindTimeAtLimits({LoopRecord({.seed = seed})}).empty());
    EXPECT_TRUE(
        FindTimeAtLimits({LoopRecord({.walk = 0.01, .seed = seed})}).empty());
  }
  Record record = LoopRecord();
  for (int k = 0; k < record.samples(); ++k) {
    record.inputs(0, k) = k / 37 % 2;  // a relay
    record.inputs(1, k) = k < 1000 ? 0.0 : k < 3000 ? 1.0 : 0.5;
  }
  EXPECT_TRUE(FindTimeAtLimits({record}).empty());
}

// The controller moves every 20 samples, the historian averages over three.
TEST(OperationTest, FindsMovesBetweenSamples) {
  const Record fine = LoopRecord({.samples = 12000, .period = 20});
  Record coarse = fine;
  coarse.sample_time *= 3.0;
  for (auto* rows : {&coarse.inputs, &coarse.outputs, &coarse.set_points}) {
    rows->conservativeResize(2, 4000);
  }
  for (int k = 0; k < 4000; ++k) {
    coarse.inputs.col(k) = fine.inputs.middleCols(3 * k, 3).rowwise().mean();
  }
  // Means of equal values differ by rounding.
  testing::Quantise(1e-9, coarse.inputs);
  const std::vector<SplitMoves> found = FindSplitMoves({coarse});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_GE(found[0].split, 0.5 * found[0].moves);
  EXPECT_TRUE(FindSplitMoves({fine}).empty());
  EXPECT_TRUE(FindSplitMoves({LoopRecord({.period = 1})}).empty());
}

TEST(OperationTest, SamplesPerTimeConstant) {
  EXPECT_TRUE(FindUnusualSampling(LoopModel(), 0.25).empty());
  const std::vector<SamplingRate> coarse =
      FindUnusualSampling(LoopModel(), 4.9);
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_EQ(coarse[0].output, 1);
  EXPECT_EQ(coarse[0].input, 0);
  EXPECT_NEAR(coarse[0].samples, 10.0 / 4.9, 1e-12);
  EXPECT_EQ(FindUnusualSampling(LoopModel(), 0.019).size(), 4u);
  EXPECT_EQ(FindUnusualSampling(LoopModel(), 0.035).size(), 1u);
}

TEST(OperationTest, FindsAnOptimisersSetPoints) {
  Record record = LoopRecord();
  for (int k = 0; k < record.samples(); ++k) {
    record.set_points(1, k) = 0.01 * (k / 10 * 7 % 11);
  }
  const std::vector<ManyMoves> found =
      FindManySetPointMoves({record}, LoopModel());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].output, 1);
  EXPECT_EQ(found[0].moves, 399);
  EXPECT_TRUE(FindManySetPointMoves({LoopRecord()}, LoopModel()).empty());
}

}  // namespace
}  // namespace mle
