#include "mle/data/segments.h"

#include <limits>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

// Of one output and two inputs that tell the sample, counted from time 0.
Record Window(int first, int samples, bool set_points = true) {
  Record record;
  record.start_time = 0.1 * first;
  record.sample_time = 0.1;
  record.outputs.resize(1, samples);
  record.inputs.resize(2, samples);
  for (int k = 0; k < samples; ++k) {
    record.outputs(0, k) = first + k;
    record.inputs.col(k) << 2 * (first + k), 3 * (first + k);
  }
  if (set_points) record.set_points = record.outputs;
  return record;
}

TEST(JoinAdjoiningTest, JoinsWindowsWithoutAGap) {
  const std::vector<Record> windows = {Window(7, 10), Window(17, 5),
                                       Window(22, 4)};
  const Segments segments = JoinAdjoining(windows);
  ASSERT_EQ(segments.records.size(), 1u);
  const Record& all = segments.records[0];
  ASSERT_TRUE(all.Validate().ok());
  const Record whole = Window(7, 19);
  EXPECT_EQ(all.start_time, whole.start_time);
  EXPECT_EQ(all.outputs, whole.outputs);
  EXPECT_EQ(all.inputs, whole.inputs);
  EXPECT_EQ(all.set_points, whole.set_points);
  ASSERT_EQ(segments.windows.size(), 3u);
  EXPECT_EQ(segments.windows[2].segment, 0);
  EXPECT_EQ(segments.windows[2].first, 15);
  EXPECT_EQ(segments.windows[2].samples, 4);
  EXPECT_EQ(segments.WindowAt(0, 0.7), 0);
  EXPECT_EQ(segments.WindowAt(0, 1.6), 0);
  EXPECT_EQ(segments.WindowAt(0, 1.7), 1);
  EXPECT_EQ(segments.WindowAt(0, 2.5), 2);
}

TEST(JoinAdjoiningTest, LeavesOthersApart) {
  Record slower = Window(41, 5);
  slower.sample_time = 0.2;
  slower.start_time = 4.1;
  const std::vector<Record> windows = {
      Window(0, 10), Window(11, 10),  // a sample is missing
      Window(0, 41),                  // earlier
      slower, Window(49, 3, false)    // another clock; no set points
  };
  const Segments segments = JoinAdjoining(windows);
  ASSERT_EQ(segments.records.size(), windows.size());
  for (int w = 0; w < 5; ++w) {
    EXPECT_EQ(segments.records[w].outputs, windows[w].outputs);
    EXPECT_EQ(segments.windows[w].segment, w);
    EXPECT_EQ(segments.windows[w].first, 0);
    EXPECT_EQ(segments.WindowAt(w, segments.records[w].start_time), w);
  }
}

// What comes before the first output only says what the inputs did.
TEST(JoinAdjoiningTest, ALeadIsPartOfTheSegmentAndNotOfTheWindow) {
  Record first = Window(7, 10);
  first.outputs.leftCols(4).setConstant(
      std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(first.lead(), 4);
  const Segments segments = JoinAdjoining({first, Window(17, 5)});
  ASSERT_EQ(segments.records.size(), 1u);
  EXPECT_EQ(segments.records[0].samples(), 15);
  EXPECT_EQ(segments.windows[0].first, 4);
  EXPECT_EQ(segments.windows[0].samples, 6);
  EXPECT_EQ(segments.windows[1].first, 10);
  EXPECT_TRUE(Adjoin(segments.windows[0], segments.windows[1]));
  // Without any output there is nothing to lead to.
  first.outputs.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(first.lead(), 0);
}

}  // namespace
}  // namespace mle
