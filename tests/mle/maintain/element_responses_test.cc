#include "mle/maintain/element_responses.h"

#include <limits>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// An output that counts its samples, and steps of its set point.
Record Steps(int samples, const std::vector<int>& changes) {
  Record record;
  record.start_time = 7.0;
  record.sample_time = 0.5;
  record.outputs = Eigen::RowVectorXd::LinSpaced(samples, 0.0, samples - 1.0);
  record.inputs = Eigen::MatrixXd::Zero(1, samples);
  record.set_points = Eigen::MatrixXd::Zero(1, samples);
  for (const int change : changes) {
    record.set_points.rightCols(samples - change).array() += 1.0;
  }
  return record;
}

std::vector<int> SamplesOf(const std::vector<Record>& parts) {
  std::vector<int> samples;
  for (const Record& part : parts) samples.push_back(part.samples());
  return samples;
}

TEST(AroundSetPointChangesTest, AThousandSamplesOnEachSide) {
  const std::vector<Record> parts =
      AroundSetPointChanges({Steps(9000, {1500, 2500, 6000})}, 1e9);
  ASSERT_EQ(SamplesOf(parts), (std::vector<int>{3000, 2000}));
  EXPECT_EQ(parts[0].outputs(0), 500.0);
  EXPECT_EQ(parts[1].outputs(0), 5000.0);
  EXPECT_EQ(parts[1].time(0), 7.0 + 0.5 * 5000.0);
}

TEST(AroundSetPointChangesTest, TheFirstEightThousandOrAsManyAsAreAskedFor) {
  const std::vector<Record> records = {Steps(9000, {1500, 6000}),
                                       Steps(9000, {1500, 4000, 6500})};
  EXPECT_EQ(SamplesOf(AroundSetPointChanges(records, 1e9)),
            (std::vector<int>{2000, 2000, 2000, 2000}));
  EXPECT_EQ(SamplesOf(AroundSetPointChanges(records, 2500.0)),
            (std::vector<int>{2000, 500}));
  // What is left is too short to say anything.
  EXPECT_EQ(SamplesOf(AroundSetPointChanges(records, 2049.9)),
            (std::vector<int>{2000}));
  EXPECT_TRUE(AroundSetPointChanges(records, 49.0).empty());
}

TEST(AroundSetPointChangesTest, WithoutSetPointsAllIsTakenWithGapsBridged) {
  Record record = Steps(100, {});
  record.set_points.resize(0, 0);
  record.outputs.row(0).segment(10, 3).setConstant(kNaN);
  record.inputs(0, 19) = 4.0;
  record.inputs.row(0).segment(20, 5).setConstant(kNaN);
  const std::vector<Record> parts = AroundSetPointChanges({record}, 1e9);
  ASSERT_EQ(SamplesOf(parts), (std::vector<int>{100}));
  EXPECT_EQ(parts[0].outputs, Steps(100, {}).outputs);
  EXPECT_EQ(parts[0].inputs(0, 24), 4.0);
  EXPECT_EQ(parts[0].inputs(0, 25), 0.0);
}

}  // namespace
}  // namespace mle
