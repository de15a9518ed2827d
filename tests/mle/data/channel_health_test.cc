#include "mle/data/channel_health.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/data/outliers.h"
#include "mle/data/record_collector.h"
#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kNoise = 0.03;

ProcessModel Model() {
  return ProcessModel("tank", "min", {{"u1", ""}, {"u2", ""}},
                      {{"y1", ""}, {"y2", ""}});
}

// Outputs answer a set point of size 1 at sample `step` as a second-order loop
// with overshoot does; inputs are held for five samples.
Record Loop(int samples, unsigned seed, double noise = kNoise) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Record record;
  record.start_time = 10.0;
  record.sample_time = 0.5;
  record.outputs.resize(2, samples);
  record.inputs.resize(2, samples);
  const int step = samples / 2;
  for (int k = 0; k < samples; ++k) {
    const double t = 0.15 * std::max(k - step, 0);
    record.outputs(0, k) =
        50.0 + 1.0 - std::exp(-0.5 * t) * std::cos(t) + noise * normal(engine);
    record.outputs(1, k) =
        5.0 + (k < step ? 0.0 : std::exp(-t)) + noise * normal(engine);
    for (int j = 0; j < 2; ++j) {
      record.inputs(j, k) =
          k % 5 == 0 ? 20.0 * j + normal(engine) : record.inputs(j, k - 1);
    }
  }
  return record;
}

HealthReport Check(const Record& record, const HealthOptions& options = {}) {
  return CheckHealth({record}, Model(), options);
}

// No false alarm: neither of noise nor of a response, steep or slow.
TEST(ChannelHealthTest, RoutineOperationIsHealthy) {
  int outliers = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const HealthReport report = Check(Loop(2000, seed));
    for (const ChannelHealth& channel : report.channels) {
      EXPECT_TRUE(channel.frozen.empty());
      EXPECT_TRUE(channel.saturated.empty());
      EXPECT_EQ(channel.quantum, 0.0);
      EXPECT_FALSE(channel.is_constant);
      outliers += static_cast<int>(channel.outliers.size());
    }
  }
  EXPECT_LE(outliers, 20);  // of 400,000 samples
  const Record smooth = Loop(2000, 1, 0.0);
  for (const ChannelHealth& channel : Check(smooth).channels) {
    EXPECT_TRUE(channel.outliers.empty()) << channel.name;
  }
}

TEST(ChannelHealthTest, RecordsWithoutNoiseAreNotFrozenWhereAllRests) {
  Record record = Loop(2000, 1, 0.0);
  // Nothing moves before the step and long after, as in a simulation.
  for (int j = 0; j < 2; ++j) {
    record.inputs.row(j).head(1000).setConstant(record.inputs(j, 1000));
    record.inputs.row(j).tail(900).setConstant(record.inputs(j, 1100));
  }
  record.outputs.rightCols(800).colwise() = record.outputs.col(1999).eval();
  const HealthReport report = Check(record);
  for (const ChannelHealth& channel : report.channels) {
    EXPECT_TRUE(channel.frozen.empty()) << channel.Report({record});
    EXPECT_TRUE(channel.saturated.empty()) << channel.Report({record});
  }
}

TEST(ChannelHealthTest, AFrozenOutputIsFoundWhereItIs) {
  Record record = Loop(4000, 3);
  record.outputs.row(0).segment(1200, 120).setConstant(record.outputs(0, 1200));
  const HealthReport report = Check(record);
  ASSERT_EQ(report.channels[0].frozen.size(), 1u);
  EXPECT_EQ(report.channels[0].frozen[0].first, 1200);
  EXPECT_EQ(report.channels[0].frozen[0].samples, 120);
  EXPECT_TRUE(report.channels[1].frozen.empty());
  EXPECT_THAT(report.Report({record}),
              HasSubstr("y1: frozen for 120 samples in 1 places: 610 … 669.5"));
}

// Lost samples and outliers inside a freeze do not hide it.
TEST(ChannelHealthTest, AFreezeGoesOnOverLossesAndOutliers) {
  Record record = Loop(4000, 13);
  std::mt19937_64 engine(13);
  record.outputs.row(0).segment(1200, 300).setConstant(record.outputs(0, 1200));
  for (int k = 1201; k < 1499; ++k) {
    if (engine() % 10 == 0) record.outputs(0, k) = kNaN;
    if (engine() % 50 == 0) record.outputs(0, k) += 1.0;
  }
  std::vector<Record> records = {record};
  const HealthReport report = CheckHealth(records, Model(), {});
  ASSERT_EQ(report.channels[0].frozen.size(), 1u);
  EXPECT_EQ(report.channels[0].frozen[0].samples, 300);
  MarkBad(report, MarkOptions(), records);
  EXPECT_TRUE(
      records[0].outputs.row(0).segment(1201, 299).array().isNaN().all());
}

// Rounding repeats values by itself; a freeze is longer than that.
TEST(ChannelHealthTest, RoundingIsNoFreeze) {
  for (const double quantum : {0.003, 0.01, 0.03, 0.06}) {
    Record record = Loop(4000, 4);
    for (double& y : record.outputs.reshaped()) {
      y = quantum * std::round(y / quantum);
    }
    HealthReport report = Check(record);
    EXPECT_TRUE(report.channels[0].frozen.empty()) << quantum;
    EXPECT_NEAR(report.channels[0].quantum, quantum, 1e-6 * quantum);
    EXPECT_THAT(report.Report({record}), HasSubstr("rounded to multiples of"));
    EXPECT_TRUE(report.channels[0].outliers.empty()) << quantum;
    record.outputs.row(1).segment(500, 300).setConstant(5.0);
    report = Check(record);
    ASSERT_EQ(report.channels[1].frozen.size(), 1u) << quantum;
    EXPECT_NEAR(report.channels[1].frozen[0].samples, 300, 20);
  }
}

TEST(ChannelHealthTest, RoundingIsFoundUnderLosses) {
  Record record = Loop(4000, 5);
  std::mt19937_64 engine(5);
  for (double& y : record.outputs.reshaped()) {
    y = engine() % 20 == 0 ? kNaN : 0.01 * std::round(y / 0.01);
  }
  EXPECT_NEAR(Check(record).channels[0].quantum, 0.01, 1e-8);
  EXPECT_EQ(Check(Loop(4000, 5)).channels[0].quantum, 0.0);
}

TEST(ChannelHealthTest, OutliersAreFoundAndNothingElse) {
  Record record = Loop(4000, 6);
  std::mt19937_64 engine(6);
  std::vector<int> placed;
  for (int k = 10; k < 3990; ++k) {
    if (engine() % 100 != 0) continue;
    const double size = (10.0 + static_cast<double>(engine() % 40)) * kNoise;
    record.outputs(0, k) += engine() % 2 ? size : -size;
    placed.push_back(k);
  }
  const ChannelHealth health = Check(record).channels[0];
  std::size_t found = 0;
  for (const SampleRun& run : health.outliers) {
    found += std::count(placed.begin(), placed.end(), run.first);
  }
  EXPECT_GE(found, placed.size() * 95 / 100);
  EXPECT_LE(health.outliers.size() - found, 3u);
}

// As the filter is defined, median by median.
TEST(ChannelHealthTest, OutliersAreThoseOfTheDefinition) {
  std::mt19937_64 engine(17);
  std::student_t_distribution<double> heavy(1.5);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::RowVectorXd y(500);
    for (double& value : y) value = engine() % 25 == 0 ? kNaN : heavy(engine);
    const double noise = WhiteDeviation(y);
    std::vector<int> expected;
    for (int k = 0; k < 500; ++k) {
      std::vector<double> around;
      for (int i = std::max(0, k - 5); i <= std::min(499, k + 5); ++i) {
        if (std::isfinite(y(i))) around.push_back(y(i));
      }
      if (!std::isfinite(y(k)) || around.size() <= 5) continue;
      const double median = MedianInPlace(around);
      for (double& value : around) value = std::abs(value - median);
      const double spread = 1.4826 * MedianInPlace(around);
      const double distance = std::abs(y(k) - median);
      if (distance > 5.0 * noise && distance > 4.0 * spread) {
        expected.push_back(k);
      }
    }
    EXPECT_EQ(FindOutliers(y), expected);
    EXPECT_FALSE(expected.empty());
  }
}

TEST(ChannelHealthTest, SingleSamplesOfInputsThatAreHeldAreOutliers) {
  Record record = Loop(1000, 7);
  record.inputs(1, 502) = 500.0;
  const ChannelHealth health = Check(record).channels[3];
  ASSERT_EQ(health.outliers.size(), 1u);
  EXPECT_EQ(health.outliers[0].first, 502);
}

TEST(ChannelHealthTest, InputsAtTheirLimitsAreFound) {
  Record record = Loop(2000, 8);
  record.inputs.row(0) = record.inputs.row(0).cwiseMin(1.0);
  record.inputs.row(0).segment(700, 60).setConstant(1.0);
  ChannelHealth health = Check(record).channels[2];
  ASSERT_EQ(health.saturated.size(), 1u);
  EXPECT_NEAR(health.saturated[0].first, 700, 15);
  // Where limits are declared, every sample there.
  HealthOptions options;
  options.input_max = Eigen::Vector2d(1.0, kNaN);
  options.input_min = Eigen::Vector2d(kNaN, kNaN);
  health = Check(record, options).channels[2];
  EXPECT_EQ(health.saturated_samples(),
            (record.inputs.row(0).array() == 1.0).count());
  EXPECT_TRUE(Check(record, options).channels[3].saturated.empty());
}

TEST(ChannelHealthTest, ConstantAndMissingChannelsAreNamed) {
  Record record = Loop(500, 9);
  record.inputs.row(1).setConstant(0.1);
  record.outputs.row(1).setConstant(kNaN);
  record.outputs(0, 7) = kNaN;
  const HealthReport report = Check(record);
  EXPECT_TRUE(report.channels[3].is_constant);
  EXPECT_EQ(report.channels[1].bad, 500);
  EXPECT_EQ(report.channels[0].bad, 1);
  EXPECT_THAT(report.Report({record}), HasSubstr("u2: does not move at all"));
  EXPECT_THAT(report.Report({record}), HasSubstr("y1: 1 of 500 samples"));
}

TEST(ChannelHealthTest, WhatIsFoundIsMarkedBad) {
  Record record = Loop(4000, 10);
  record.outputs.row(0).segment(100, 50).setConstant(record.outputs(0, 100));
  record.outputs(1, 3000) += 1.0;
  const double held = record.inputs(0, 502);
  record.inputs(0, 502) = 100.0;
  std::vector<Record> records = {record};
  const HealthReport report = CheckHealth(records, Model(), {});
  EXPECT_EQ(MarkBad(report, MarkOptions(), records), 51);
  EXPECT_EQ(records[0].inputs(0, 502), held);
  EXPECT_EQ(records[0].outputs.array().isNaN().count(), 50);
  EXPECT_FALSE(std::isnan(records[0].outputs(0, 100)));
  EXPECT_TRUE(std::isnan(records[0].outputs(1, 3000)));
  EXPECT_EQ(MarkBad(CheckHealth(records, Model(), {}), {}, records), 0);
}

// Findings do not depend on units.
TEST(ChannelHealthTest, IsTheSameInOtherUnits) {
  Record record = Loop(3000, 11);
  record.outputs.row(0).segment(100, 50).setConstant(record.outputs(0, 100));
  record.outputs(1, 2000) += 1.0;
  const HealthReport one = Check(record);
  record.outputs = record.outputs.array() * 1024.0;
  record.inputs = record.inputs.array() * -0.25;
  const HealthReport other = Check(record);
  for (std::size_t c = 0; c < one.channels.size(); ++c) {
    EXPECT_EQ(one.channels[c].frozen_samples(),
              other.channels[c].frozen_samples());
    EXPECT_EQ(one.channels[c].outliers.size(),
              other.channels[c].outliers.size());
  }
}

}  // namespace
}  // namespace mle
