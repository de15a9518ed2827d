#include "mle/maintain/record_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"
#include "tests/mle/maintain/tank_records.h"
#include "tests/mle/maintain/two_input_model.h"

namespace mle {
namespace {

// Five settling times and more; a side has one and a half of them.
constexpr int kSegment = 240;
constexpr int kSide = 69;

// In which an input moves by so much for a third of the time.
Record Segment(int number, int input, double size) {
  Record record;
  record.start_time = number * kSegment;
  record.sample_time = 1.0;
  record.inputs.setZero(2, kSegment);
  record.inputs.row(input)
      .segment(kSegment / 3, kSegment / 3)
      .setConstant(size);
  record.outputs.setConstant(1, kSegment, number);
  record.set_points.setZero(1, kSegment);
  return record;
}

// Of each record, what lies beyond the sides: the first segment and how many
// there are. Every sample is where it was.
std::vector<std::pair<int, int>> KeptIn(const std::vector<Record>& records) {
  std::vector<std::pair<int, int>> kept;
  for (const Record& record : records) {
    EXPECT_TRUE(record.Validate().ok());
    for (int k = 0; k < record.samples(); ++k) {
      if (std::isnan(record.outputs(0, k))) continue;
      EXPECT_EQ(record.outputs(0, k), std::floor(record.time(k) / kSegment));
    }
    const int first = static_cast<int>(record.start_time) + kSide;
    kept.emplace_back(first / kSegment,
                      (record.samples() - 2 * kSide) / kSegment);
    EXPECT_EQ(first % kSegment, 0);
    EXPECT_EQ((record.samples() - 2 * kSide) % kSegment, 0);
  }
  return kept;
}

TEST(RecordScanTest, KeepsEverythingThatThereIsRoomFor) {
  const ProcessModel model = testing::TwoInputModel();
  RecordScan scan(model, 4 * kSegment);
  for (int w = 0; w < 4; ++w) {
    ASSERT_TRUE(scan.Take(Segment(w, w % 2, 1.0), w != 0 && w != 2).ok());
  }
  const std::vector<Record> records = scan.Finish();
  ASSERT_EQ(records.size(), 2);
  for (int r = 0; r < 2; ++r) {
    EXPECT_EQ(records[r].start_time, 2 * r * kSegment);
    EXPECT_EQ(records[r].samples(), 2 * kSegment);
    EXPECT_EQ(records[r].outputs(0, kSegment), 2 * r + 1);
  }
  EXPECT_TRUE(scan.Notes().empty());
}

// Of a hundred segments the few in which the inputs move most, of each input
// as many; none is joined with one that does not follow it.
TEST(RecordScanTest, KeepsWhatInformsMostWhereverItStands) {
  const ProcessModel model = testing::TwoInputModel();
  RecordScan scan(model, 4 * kSegment);
  const std::vector<int> moved = {3, 4, 57, 98};
  for (int w = 0; w < 100; ++w) {
    const bool moves = std::find(moved.begin(), moved.end(), w) != moved.end();
    ASSERT_TRUE(scan.Take(Segment(w, w % 2, moves ? 1.0 : 0.1), w > 0).ok());
  }
  const std::vector<Record> records = scan.Finish();
  EXPECT_EQ(KeptIn(records),
            (std::vector<std::pair<int, int>>{{3, 2}, {57, 1}, {98, 1}}));
  ASSERT_EQ(scan.Notes().size(), 1);
  // Of each input two segments of 1 and 48 of 0.1: 1 - (2/2.48)^1/2.
  EXPECT_EQ(scan.Notes()[0].text,
            "Of 100 stretches of the records 4 were kept while they were read, "
            "the most informative: 1374 of 24000 samples. With all of them "
            "standard errors of gains would be expected to be smaller by 10 % "
            "in the median, by 10 % at most.");
}

// What cannot be measured says nothing.
TEST(RecordScanTest, ASegmentWithoutOutputsIsLeftOut) {
  const ProcessModel model = testing::TwoInputModel();
  RecordScan scan(model, 2 * kSegment);
  for (int w = 0; w < 8; ++w) {
    Record segment = Segment(w, w % 2, w < 2 ? 5.0 : w < 4 ? 1.0 : 0.2);
    if (w < 2)
      segment.outputs.setConstant(std::numeric_limits<double>::quiet_NaN());
    ASSERT_TRUE(scan.Take(std::move(segment), w > 0).ok());
  }
  EXPECT_EQ(KeptIn(scan.Finish()), (std::vector<std::pair<int, int>>{{2, 2}}));
}

// Two weeks of a tank that moves in a few hours of them: the same windows are
// found as where all is held.
TEST(RecordScanTest, ALongRecordIsReadInAFewSegments) {
  const ProcessModel model = testing::Tank(1.0);
  const Record tank = testing::TankRecord(model, 0.02, 1);
  std::string text = "time,valve,level,level_setpoint\n";
  const auto add = [&](int at, int k) {
    absl::StrAppend(&text, at * 0.5, ",", tank.inputs(0, k), ",",
                    tank.outputs(0, k), ",", tank.set_points(0, k), "\n");
  };
  const int quiet = 20 * tank.samples();
  for (int k = 0; k < quiet; ++k) add(k, 0);
  for (int k = 0; k < tank.samples(); ++k) add(quiet + k, k);
  for (int k = 0; k < quiet; ++k) {
    add(quiet + tank.samples() + k, tank.samples() - 1);
  }
  RecordOptions options;
  const auto whole =
      LoadSources({TextSource("weeks.csv", text)}, model, {}, options);
  ASSERT_TRUE(whole.ok()) << whole.status();
  options.most_samples_in_memory = 3 * tank.samples();
  const auto scanned =
      LoadSources({TextSource("weeks.csv", text)}, model, {}, options);
  ASSERT_TRUE(scanned.ok()) << scanned.status();
  EXPECT_EQ(scanned->report.samples, whole->report.samples);
  EXPECT_LT(scanned->report.kept_samples, 4 * tank.samples());
  ASSERT_EQ(scanned->windows.size(), whole->windows.size());
  for (std::size_t w = 0; w < whole->windows.size(); ++w) {
    EXPECT_EQ(BeginOf(scanned->windows[w]), BeginOf(whole->windows[w]));
    EXPECT_EQ(EndOf(scanned->windows[w]), EndOf(whole->windows[w]));
    EXPECT_EQ(scanned->windows[w].record.inputs,
              whole->windows[w].record.inputs);
  }
  EXPECT_NE(scanned->notes.back().text.find("stretches of the records"),
            std::string::npos);
}

}  // namespace
}  // namespace mle
