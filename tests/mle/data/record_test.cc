#include "mle/data/record.h"

#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Every value tells its row and sample.
Record Example(int samples) {
  Record record;
  record.start_time = 100.0;
  record.sample_time = 0.2;
  record.outputs.resize(2, samples);
  record.inputs.resize(3, samples);
  record.set_points = Eigen::MatrixXd::Zero(2, samples);
  for (int k = 0; k < samples; ++k) {
    record.outputs.col(k) << k, 1000 + k;
    record.inputs.col(k) << 2000 + k, 3000 + k, 4000 + k;
  }
  return record;
}

std::string Message(const absl::Status& status) {
  return std::string(status.message());
}

TEST(RecordTest, ValidateSaysWhatIsWrong) {
  Record record = Example(10);
  record.outputs(0, 3) = kNaN;  // A bad sample is allowed.
  EXPECT_TRUE(record.Validate().ok());
  record.set_points.resize(0, 0);
  EXPECT_TRUE(record.Validate().ok());
  record.set_points.resize(1, 10);
  EXPECT_THAT(Message(record.Validate()),
              AllOf(HasSubstr("1 × 10"), HasSubstr("2 × 10")));
  record.set_points.resize(0, 0);
  record.inputs.resize(3, 9);
  EXPECT_THAT(Message(record.Validate()), HasSubstr("3 × 9"));
  record = Example(10);
  record.sample_time = -0.2;
  EXPECT_THAT(Message(record.Validate()), HasSubstr("sample_time is -0.2"));
  record.sample_time = 0.2;
  record.start_time = kNaN;
  EXPECT_THAT(Message(record.Validate()), HasSubstr("start_time is nan"));
}

TEST(RecordTest, TimeOfASample) {
  EXPECT_DOUBLE_EQ(Example(10).time(5), 101.0);
}

TEST(FindSetPointChangesTest, AreInOrderOfTime) {
  Record record = Example(20);
  record.set_points.row(1).tail(15).setConstant(1.0);
  record.set_points.row(0).tail(8).setConstant(-2.0);
  record.set_points.row(1).tail(8).setConstant(3.0);
  const auto changes = FindSetPointChanges(record);
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[0].sample, 5);
  EXPECT_EQ(changes[0].output, 1);
  EXPECT_EQ(changes[0].from, 0.0);
  EXPECT_EQ(changes[0].to, 1.0);
  EXPECT_EQ(changes[1].sample, 12);
  EXPECT_EQ(changes[1].output, 0);
  EXPECT_EQ(changes[1].to, -2.0);
  EXPECT_EQ(changes[2].sample, 12);
  EXPECT_EQ(changes[2].output, 1);
  EXPECT_EQ(changes[2].from, 1.0);
}

TEST(RecordTest, SamplesThatCannotBeSquaredAreRefused) {
  for (Eigen::MatrixXd Record::*rows :
       {&Record::outputs, &Record::inputs, &Record::set_points}) {
    Record record = Example(20);
    (record.*rows)(0, 7) = -kLargestSample;
    EXPECT_TRUE(record.Validate().ok());
    (record.*rows)(0, 7) = kNaN;
    EXPECT_TRUE(record.Validate().ok());
    (record.*rows)(0, 7) = -1e155;
    const absl::Status status = record.Validate();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find("-1e+155 in sample 8"), std::string::npos)
        << status;
  }
}

TEST(FindSetPointChangesTest, ConstantSetPointsHaveNone) {
  EXPECT_TRUE(FindSetPointChanges(Example(20)).empty());
  Record record = Example(20);
  record.set_points.resize(0, 0);
  EXPECT_TRUE(FindSetPointChanges(record).empty());
}

TEST(FindSetPointChangesTest, BadSamplesAreNoChange) {
  Record record = Example(12);
  record.set_points.row(0) << kNaN, 1, 1, kNaN, kNaN, 1, 1, kNaN, 2, 2, kNaN,
      kNaN;
  const auto changes = FindSetPointChanges(record);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].sample, 8);
  EXPECT_EQ(changes[0].from, 1.0);
  EXPECT_EQ(changes[0].to, 2.0);
}

TEST(CutWindowTest, HoldsBothEnds) {
  const Record record = Example(100);
  const auto window = CutWindow(record, 50, 2.0, 4.0);
  ASSERT_TRUE(window.ok()) << window.status();
  EXPECT_TRUE(window->Validate().ok());
  EXPECT_EQ(window->samples(), 10 + 1 + 20);
  EXPECT_DOUBLE_EQ(window->start_time, 108.0);
  EXPECT_EQ(window->outputs(0, 0), 40.0);
  EXPECT_EQ(window->outputs(1, 30), 1070.0);
  EXPECT_EQ(window->inputs(2, 10), 4050.0);
  EXPECT_EQ(window->set_points.cols(), 31);
}

TEST(CutWindowTest, WholeRecordAndSingleSample) {
  const Record record = Example(11);
  EXPECT_EQ(CutWindow(record, 4, 0.8, 1.2)->samples(), 11);
  EXPECT_EQ(CutWindow(record, 4, 0.0, 0.0)->samples(), 1);
  // Half a sample more is rounded up and no longer in the record.
  EXPECT_FALSE(CutWindow(record, 4, 0.91, 1.2).ok());
}

TEST(CutWindowTest, SaysWhatTheRecordHolds) {
  const Record record = Example(101);
  for (const int center : {50, -1, 101}) {
    const absl::Status status = CutWindow(record, center, 2.0, 40.0).status();
    EXPECT_TRUE(absl::IsOutOfRange(status)) << status;
    EXPECT_THAT(Message(status), HasSubstr("from 100 to 120"));
  }
  EXPECT_THAT(Message(CutWindow(record, 50, 2.0, 40.0).status()),
              HasSubstr("from 108 to 150"));
  EXPECT_TRUE(absl::IsOutOfRange(
      CutWindow(record, 50, std::numeric_limits<double>::infinity(), 1.0)
          .status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(CutWindow(record, 50, -1.0, 1.0).status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(CutWindow(record, 50, 1.0, kNaN).status()));
  EXPECT_THAT(Message(CutWindow(Example(0), 0, 0.0, 0.0).status()),
              HasSubstr("the record is empty"));
}

TEST(FilledTest, HoldsTheLastValueKnown) {
  const Eigen::Vector<double, 6> gaps{kNaN, 2.0, kNaN, kInfinity, 3.0, kNaN};
  EXPECT_EQ(Filled(gaps),
            (Eigen::Vector<double, 6>{2.0, 2.0, 2.0, 2.0, 3.0, 3.0}));
  EXPECT_EQ(Filled(Eigen::Vector2d{kNaN, kNaN}), Eigen::Vector2d::Zero());
}

TEST(CutWindowTest, WorksWithoutSetPoints) {
  Record record = Example(30);
  record.set_points.resize(0, 0);
  const auto window = CutWindow(record, 15, 1.0, 1.0);
  ASSERT_TRUE(window.ok());
  EXPECT_EQ(window->set_points.size(), 0);
}

}  // namespace
}  // namespace mle
