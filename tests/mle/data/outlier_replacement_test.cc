#include "mle/data/outlier_replacement.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

ProcessModel Channels() {
  return ProcessModel("test", "min", {{"u", ""}}, {{"y", ""}});
}

// The response of a lag to a step, with noise of deviation 0.03.
Record StepRecord(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 0.03);
  Record record;
  record.sample_time = 0.2;
  record.outputs.resize(1, 2000);
  record.inputs.resize(1, 2000);
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.2 * (k - 1000);
    record.inputs(0, k) = t > 0.0 ? 1.0 : 0.0;
    record.outputs(0, k) =
        (t > 0.0 ? 1.0 - std::exp(-t / 10.0) : 0.0) + normal(random);
  }
  return record;
}

// Of samples off by 10 to 50 σ all are found, on the flanks of a response too,
// and none else; in their place stands what is within the noise of the truth.
TEST(OutlierReplacementTest, FindsAndReplacesThemAndNothingElse) {
  const Record clean = StepRecord(1);
  Record spoilt = clean;
  std::mt19937_64 random(2);
  int spoilt_samples = 0;
  for (int k = 20; k < 1980; k += 97) {
    const double size = 0.3 + 1.2 * static_cast<double>(random() % 1000) / 1e3;
    spoilt.outputs(0, k) += k % 2 == 0 ? size : -size;
    ++spoilt_samples;
  }
  std::vector<Record> records = {spoilt};
  EXPECT_EQ(ReplaceOutliers(Channels(), {}, records), spoilt_samples);
  EXPECT_EQ(records[0].inputs, clean.inputs);
  for (int k = 0; k < 2000; ++k) {
    if (spoilt.outputs(0, k) == clean.outputs(0, k)) {
      EXPECT_EQ(records[0].outputs(0, k), clean.outputs(0, k)) << k;
    } else {
      EXPECT_NEAR(records[0].outputs(0, k), clean.outputs(0, k), 6 * 0.03) << k;
    }
  }
  records = {spoilt};
  OutlierReplacementOptions mark;
  mark.max_gap = 0;
  EXPECT_EQ(ReplaceOutliers(Channels(), mark, records), spoilt_samples);
  EXPECT_EQ(records[0].outputs.array().isNaN().count(), spoilt_samples);
}

// Up to ten in a row, off to one side.
TEST(OutlierReplacementTest, FindsBursts) {
  const Record clean = StepRecord(3);
  Record spoilt = clean;
  std::mt19937_64 random(4);
  int spoilt_samples = 0;
  for (int k = 30; k < 1950; k += 131) {
    const int length = 3 + static_cast<int>(random() % 8);
    const double side = random() % 2 == 0 ? 1.0 : -1.0;
    for (int i = k; i < k + length; ++i) {
      spoilt.outputs(0, i) +=
          side * (0.3 + 1.2 * static_cast<double>(random() % 1000) / 1e3);
    }
    spoilt_samples += length;
  }
  std::vector<Record> records = {spoilt};
  const int found = ReplaceOutliers(Channels(), {}, records);
  // All but the odd one that noise brings nearer, or that is the last of a
  // burst on a flank.
  EXPECT_GE(found, 0.95 * spoilt_samples);
  EXPECT_LE(found, 1.05 * spoilt_samples);
  double largest = 0.0;
  for (int k = 0; k < 2000; ++k) {
    largest = std::max(
        largest, std::abs(records[0].outputs(0, k) - clean.outputs(0, k)));
  }
  EXPECT_LT(largest, 15 * 0.03);
}

TEST(OutlierReplacementTest, LeavesCleanRecordsAlone) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<Record> records = {StepRecord(seed)};
    EXPECT_LE(ReplaceOutliers(Channels(), {}, records), 1) << seed;
  }
}

}  // namespace
}  // namespace mle
