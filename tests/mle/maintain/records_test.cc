#include "mle/maintain/records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "mle/data/segments.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

RecordData Prepared(const Record& record, const RecordOptions& options = {}) {
  absl::StatusOr<RecordData> data =
      PrepareRecords({record}, Tank(1.0), options);
  EXPECT_TRUE(data.ok()) << data.status();
  return data.ok() ? *std::move(data) : RecordData();
}

TEST(RecordDataTest, WindowsKnowTheInputsBeforeThem) {
  const Record record = TankRecord(Tank(1.0), 0.02, 1);
  const RecordData data = Prepared(record);
  ASSERT_EQ(data.windows.size(), 2u);
  EXPECT_EQ(data.lead, std::ceil(SettlingTime(Tank(1.0)) / 0.5));
  const std::vector<Record> windows = data.Records();
  for (std::size_t w = 0; w < 2; ++w) {
    const Record& window = windows[w];
    const int first = data.windows[w].first_sample;
    const int lead = std::min(data.lead, first);
    ASSERT_GT(lead, 0);
    EXPECT_TRUE(window.Validate().ok());
    EXPECT_EQ(window.lead(), lead);
    EXPECT_EQ(window.start_time, record.time(first - lead));
    EXPECT_EQ(window.inputs,
              record.inputs.middleCols(first - lead, window.samples()));
    EXPECT_EQ(window.set_points,
              record.set_points.middleCols(first - lead, window.samples()));
    EXPECT_EQ(window.outputs.rightCols(window.samples() - lead),
              data.windows[w].record.outputs);
  }
}

TEST(RecordDataTest, ALeadBeginsAfterABadInput) {
  Record record = TankRecord(Tank(1.0), 0.02, 1);
  const RecordData whole = Prepared(record);
  const int first = whole.windows[1].first_sample;
  record.inputs(0, first - 5) = std::numeric_limits<double>::quiet_NaN();
  RecordData data = whole;
  data.records = {record};
  EXPECT_EQ(data.Records()[1].lead(), 4);
  record.inputs(0, first - 1) = std::numeric_limits<double>::quiet_NaN();
  data.records = {record};
  EXPECT_EQ(data.Records()[1].lead(), 0);
  EXPECT_EQ(data.Records()[1].samples(), data.windows[1].record.samples());
}

TEST(RecordDataTest, WindowsThatAdjoinAreOneSegment) {
  RecordOptions options;
  options.windows.before = 90.0;
  options.windows.after = 150.0;
  const RecordData data = Prepared(TankRecord(Tank(1.0), 0.02, 1), options);
  ASSERT_EQ(data.windows.size(), 2u);
  ASSERT_TRUE(Adjoin(data.windows[0], data.windows[1]));
  const std::vector<Record> windows = data.Records();
  EXPECT_EQ(windows[1].lead(), 0);
  const Segments segments = JoinAdjoining(windows);
  ASSERT_EQ(segments.records.size(), 1u);
  EXPECT_EQ(segments.windows[0].first, windows[0].lead());
  EXPECT_TRUE(Adjoin(segments.windows[0], segments.windows[1]));
}

TEST(RecordDataTest, WithoutSetPointsThatMoveWholeRecordsAreTaken) {
  Record record = TankRecord(Tank(1.0), 0.02, 1);
  for (int k = 0; k < record.samples(); ++k) {
    record.inputs(0, k) = std::sin(0.3 * k);
  }
  record.set_points.setConstant(2.0);
  const RecordData data = Prepared(record);
  ASSERT_EQ(data.windows.size(), 1u);
  EXPECT_EQ(data.windows[0].record.samples(), record.samples());
  ASSERT_FALSE(data.warnings.empty());
  EXPECT_NE(data.warnings[0].text.find("stand for those of set points"),
            std::string::npos);

  record.inputs.setConstant(1.0);
  const auto still = PrepareRecords({record}, Tank(1.0), {});
  EXPECT_NE(still.status().message().find("nor does any input move"),
            std::string_view::npos);
}

}  // namespace
}  // namespace mle
