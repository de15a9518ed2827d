#include "mle/maintain/tag_clocks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/data/loop_records.h"
#include "tests/mle/maintain/large_plant.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using testing::LoopModel;
using testing::LoopRecord;

std::vector<TagClock> FindClocks(const Record& record) {
  return *FindTagClocks(LoopModel(), {record});
}

void MakeLate(int samples,
              Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> row) {
  const Eigen::RowVectorXd before = row;
  const auto n = static_cast<int>(row.size());
  for (int k = 0; k < n; ++k) {
    row(k) = before(std::clamp(k - samples, 0, n - 1));
  }
}

TEST(TagClocksTest, FindsALateOutput) {
  for (const int late : {-4, 4, 6}) {
    for (int i = 0; i < 2; ++i) {
      Record record = LoopRecord();
      MakeLate(late, record.outputs.row(i));
      const std::vector<TagClock> clocks = FindClocks(record);
      ASSERT_EQ(clocks.size(), 1u) << late << " " << i;
      EXPECT_TRUE(clocks[0].is_output);
      EXPECT_EQ(clocks[0].channel, i);
      EXPECT_NEAR(clocks[0].late, 0.25 * late, 4.0 * clocks[0].error);
      EXPECT_LT(clocks[0].error, 0.1);
      EXPECT_FALSE(clocks[0].impossible);
    }
  }
}

TEST(TagClocksTest, ACorrectedClockIsRight) {
  const Record right = LoopRecord();
  for (const bool output : {true, false}) {
    for (const int late : {-6, 5}) {
      Record record = right;
      MakeLate(late, output ? record.outputs.row(0) : record.inputs.row(0));
      const std::vector<TagClock> clocks = FindClocks(record);
      ASSERT_EQ(clocks.size(), 1u);
      std::vector<Record> records = {record};
      CorrectClock(clocks[0], records);
      EXPECT_TRUE(FindTagClocks(LoopModel(), records)->empty());
      // Between samples on straight lines; noise of 0.02.
      const auto& before = output ? right.outputs : right.inputs;
      const auto& after = output ? records[0].outputs : records[0].inputs;
      EXPECT_LT(
          (after - before).row(0).segment(20, 3960).norm() / std::sqrt(3960.0),
          output ? 0.04 : 1e-12);
      // What was not read is not known.
      EXPECT_EQ(after.row(0).array().isNaN().count() > 0, true);
    }
  }
}

TEST(TagClocksTest, FindsALateInput) {
  for (const int late : {-6, 3}) {
    Record record = LoopRecord();
    MakeLate(late, record.inputs.row(0));
    const std::vector<TagClock> clocks = FindClocks(record);
    ASSERT_EQ(clocks.size(), 1u);
    EXPECT_FALSE(clocks[0].is_output);
    EXPECT_EQ(clocks[0].channel, 0);
    EXPECT_NEAR(clocks[0].late, 0.25 * late, 4.0 * clocks[0].error);
  }
}

TEST(TagClocksTest, FindsALateInputOfALargePlant) {
  const ProcessModel model = testing::LargeModel();
  Record record = testing::LargeRecord();
  EXPECT_TRUE(FindTagClocks(model, {record})->empty());
  MakeLate(3, record.inputs.row(0));
  const std::vector<TagClock> clocks = *FindTagClocks(model, {record});
  ASSERT_EQ(clocks.size(), 1u);
  EXPECT_FALSE(clocks[0].is_output);
  EXPECT_EQ(clocks[0].channel, 0);
  EXPECT_NEAR(clocks[0].late, 3.0, 4.0 * clocks[0].error);
}

// The output moves two minutes before its input, whose dead time is one.
TEST(TagClocksTest, KnowsWhatIsImpossible) {
  Record record = LoopRecord();
  MakeLate(-12, record.outputs.row(0));
  const std::vector<TagClock> clocks = FindClocks(record);
  ASSERT_EQ(clocks.size(), 1u);
  EXPECT_TRUE(clocks[0].impossible);
  EXPECT_THAT(clocks[0].Describe(LoopModel()), HasSubstr("early"));
}

// A dead time of one element alone would explain as much, if it could be
// negative.
TEST(TagClocksTest, OneElementIsNoExplanationBelowZero) {
  ProcessModel model = LoopModel();
  TransferFunction& weak = model.element(1, 0);
  weak = TransferFunction::FirstOrder(0.03 * weak.StaticGain(),
                                      weak.TimeConstant(), weak.delay());
  Record record = LoopRecord(model, {}, StaticGains(model));
  MakeLate(12, record.inputs.row(0));
  const std::vector<TagClock> clocks = *FindTagClocks(model, {record});
  ASSERT_EQ(clocks.size(), 1u);
  EXPECT_FALSE(clocks[0].is_output);
  EXPECT_TRUE(clocks[0].impossible);
  EXPECT_NEAR(clocks[0].late, 3.0, 4.0 * clocks[0].error);
}

TEST(TagClocksTest, LeavesRightModels) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double walk : {0.0, 0.003, 0.03}) {
      Record record = LoopRecord({.walk = walk, .seed = seed});
      EXPECT_TRUE(FindClocks(record).empty());
      testing::Quantise(0.05, record.outputs);
      EXPECT_TRUE(FindClocks(record).empty());
    }
  }
}

// One element, gains, time constants: not what a clock does.
TEST(TagClocksTest, LeavesAgedElements) {
  for (int element = 0; element < 4; ++element) {
    for (int what = 0; what < 3; ++what) {
      ProcessModel aged = LoopModel();
      TransferFunction& g = aged.element(element / 2, element % 2);
      g = TransferFunction::FirstOrder(
          (what == 0 ? 0.5 : 1.0) * g.StaticGain(),
          (what == 1 ? 1.5 : 1.0) * g.TimeConstant(),
          g.delay() + (what == 2 ? 1.5 : 0.0));
      EXPECT_TRUE(
          FindClocks(LoopRecord(aged, {}, StaticGains(LoopModel()))).empty())
          << element << " " << what;
    }
  }
}

}  // namespace
}  // namespace mle
