#include "sim/archive.h"

#include <algorithm>
#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSampleTime = 0.5;

// A random walk with noise upon it.
RowVectorXd Series(int seed, int samples = 2000) {
  GaussianNoise noise(seed, 0);
  RowVectorXd walk = noise.DrawMatrix(1, samples, 0.1);
  for (int k = 1; k < samples; ++k) walk[k] += walk[k - 1];
  return walk + noise.DrawMatrix(1, samples, 0.3);
}

RowVectorXd Export(const TagOptions& tag, const RowVectorXd& series) {
  Record record;
  record.sample_time = kSampleTime;
  record.outputs = series;
  record.inputs = RowVectorXd::Ones(series.size());
  ExportFromArchive({.outputs = {tag}, .inputs = {}}, record);
  EXPECT_EQ(record.inputs, MatrixXd::Ones(1, series.size()));
  return record.outputs;
}

double LargestError(const TagOptions& tag, const RowVectorXd& series) {
  return (Export(tag, series) - series).cwiseAbs().maxCoeff();
}

TEST(ArchiveTest, WithoutDeviationsTheRecordStays) {
  const RowVectorXd series = Series(1);
  EXPECT_EQ(Export({}, series), series);
}

TEST(ArchiveTest, AnExportIsWithinTheDeviationsAndOftenNear) {
  for (int seed = 1; seed <= 5; ++seed) {
    const RowVectorXd series = Series(seed);
    for (const double deviation : {0.1, 0.6, 2.0}) {
      const double door = LargestError({.compression = deviation}, series);
      EXPECT_LE(door, deviation + 1e-12);
      EXPECT_GE(door, 0.8 * deviation);
      const double reports = LargestError({.exception = deviation}, series);
      EXPECT_LE(reports, 2.0 * deviation + 1e-12);
      EXPECT_GE(reports, 0.8 * deviation);
      EXPECT_LE(
          LargestError({.exception = deviation, .compression = 0.3}, series),
          2.0 * deviation + 0.3 + 1e-12);
    }
  }
}

TEST(ArchiveTest, AWiderDoorKeepsFewerPoints) {
  const RowVectorXd series = Series(1);
  std::size_t before = 2001;
  for (const double deviation : {0.01, 0.3, 0.6, 1.2}) {
    const std::size_t points =
        ArchivedSamples({.compression = deviation}, series, kSampleTime).size();
    EXPECT_LT(points, before);
    before = points;
  }
  EXPECT_LT(before, 200u);
}

// Straight lines need their corners, whatever the deviation.
TEST(ArchiveTest, TheDoorFindsTheCornersOfStraightLines) {
  RowVectorXd series(31);
  for (int k = 0; k <= 30; ++k) {
    series[k] = k <= 10 ? 2.0 * k : k <= 20 ? 20.0 : 20.0 - 3.0 * (k - 20);
  }
  EXPECT_THAT(ArchivedSamples({.compression = 1e-9}, series, kSampleTime),
              ElementsAre(0, 10, 20, 30));
}

// A value is sent on that differs by more than the deviation, with the one
// before it.
TEST(ArchiveTest, ExceptionsAreReportedWithTheValueBefore) {
  const RowVectorXd series{{0.0, 0.4, -0.4, 0.3, 1.1, 1.0, 1.3, 3.0, 3.1}};
  EXPECT_THAT(ArchivedSamples({.exception = 0.5}, series, kSampleTime),
              ElementsAre(0, 3, 4, 6, 7));
}

TEST(ArchiveTest, NothingWaitsLongerThanTheMaximum) {
  const RowVectorXd flat = RowVectorXd::Constant(50, 1.0);
  for (const TagOptions& tag :
       {TagOptions{.exception = 1.0, .max_interval = 10 * kSampleTime},
        TagOptions{.compression = 1.0, .max_interval = 10 * kSampleTime}}) {
    const std::vector<int> points = ArchivedSamples(tag, flat, kSampleTime);
    EXPECT_GE(points.size(), 5u);
    for (std::size_t i = 1; i < points.size(); ++i) {
      EXPECT_LE(points[i] - points[i - 1], 10);
    }
  }
}

TEST(ArchiveTest, AClockThatIsAheadShowsAValueLater) {
  const RowVectorXd series = Series(2, 100);
  const RowVectorXd late = Export({.clock_offset = 3 * kSampleTime}, series);
  EXPECT_EQ(late.tail(97), series.head(97));
  EXPECT_EQ(late.head(3), RowVectorXd::Constant(3, series[0]));
  const RowVectorXd early = Export({.clock_offset = -2 * kSampleTime}, series);
  EXPECT_EQ(early.head(98), series.tail(98));
  const RowVectorXd half = Export({.clock_offset = 0.25 * kSampleTime}, series);
  EXPECT_LE(
      (half.tail(99) - 0.75 * series.tail(99) - 0.25 * series.head(99)).norm(),
      1e-12);
  const RowVectorXd held =
      Export({.clock_offset = 0.25 * kSampleTime, .step = true}, series);
  EXPECT_EQ(held.tail(99), series.head(99));
}

TEST(ArchiveTest, SpikesAreSingleSamplesAndLostSamplesStayLost) {
  RowVectorXd series = RowVectorXd::Zero(20);
  series[7] = NAN;
  const RowVectorXd shown = Export(
      {.compression = 0.1,
       .spikes = {{.time = 5.0, .size = 4.0}, {.time = 90.0, .size = 4.0}}},
      series);
  EXPECT_TRUE(std::isnan(shown[7]));
  for (int k = 0; k < 20; ++k) {
    if (k == 7) continue;
    EXPECT_NEAR(shown[k], k == 10 ? 4.0 : 0.0, 0.1) << k;
  }
  EXPECT_NEAR(shown[10], 4.0, 1e-12);
}

TEST(ArchiveTest, OptionsAreChecked) {
  const auto message = [](const TagOptions& tag) {
    return std::string(ArchiveOptions{.outputs = {}, .inputs = {tag}}
                           .Validate(1, 2)
                           .message());
  };
  EXPECT_EQ(message({.channel = 1}), "");
  EXPECT_THAT(message({.channel = 2}), HasSubstr("channel = 2"));
  EXPECT_THAT(message({.exception = -1.0}), HasSubstr("exception = -1"));
  EXPECT_THAT(message({.compression = NAN}), HasSubstr("compression = nan"));
  EXPECT_THAT(message({.max_interval = 0.0}), HasSubstr("max_interval = 0"));
  EXPECT_THAT(message({.clock_offset = NAN}), HasSubstr("clock_offset"));
  EXPECT_THAT(message({.spikes = {{.time = NAN}}}), HasSubstr("spike"));
}

}  // namespace
}  // namespace mle::sim
