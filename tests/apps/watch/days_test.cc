#include <cmath>

#include "apps/watch/source.h"
#include "apps/watch/update.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::watch {
namespace {

using ::testing::ElementsAre;

constexpr int kDay = 20000;
constexpr int kSamplesADay = 96;  // every 15 min

// Samples from `first` to `last`, counted from the begin of kDay; output and
// input tell which.
Record Samples(int first, int last) {
  Record record;
  record.sample_time = 15.0;
  record.start_time = kDay * kSecondsOfDay + first * 900.0;
  const int count = last - first + 1;
  record.outputs = Eigen::RowVectorXd::LinSpaced(count, first, last);
  record.inputs = -record.outputs;
  return record;
}

DatedRecords Data(std::vector<Record> records) {
  return {.records = std::move(records), .seconds_per_unit = 60.0};
}

TEST(DaysTest, ADayIsOverWithItsLastSample) {
  EXPECT_THAT(ClosedDays(Data({Samples(-10, kSamplesADay - 1)})),
              ElementsAre(kDay - 1, kDay));
  EXPECT_THAT(ClosedDays(Data({Samples(-10, kSamplesADay - 3)})),
              ElementsAre(kDay - 1));
  // Later records say so too, though the end of the day is missing.
  EXPECT_THAT(ClosedDays(Data({Samples(0, 10),
                               Samples(2 * kSamplesADay, 3 * kSamplesADay)})),
              ElementsAre(kDay, kDay + 2));
}

TEST(DaysTest, ADayHasWhatGoesBeforeIt) {
  const DatedRecords data = Data({Samples(-50, 30), Samples(40, 200)});
  const WatchBatch batch = DayOf(data, kDay, 20);
  EXPECT_EQ(batch.first, 20);
  ASSERT_EQ(batch.record.samples(), 20 + kSamplesADay);
  for (int k = 0; k < batch.record.samples(); ++k) {
    const int number = k - 20;
    if (number > 30 && number < 40) {
      EXPECT_TRUE(std::isnan(batch.record.outputs(0, k))) << number;
    } else {
      EXPECT_EQ(batch.record.outputs(0, k), number);
      EXPECT_EQ(batch.record.inputs(0, k), -number);
    }
  }
  // As far as there is anything.
  EXPECT_EQ(DayOf(data, kDay, 70).first, 50);
  EXPECT_EQ(DayOf(data, kDay + 10, 20).record.samples(), 0);
}

TEST(DaysTest, TheChecksumIsOfTheDaysSamples) {
  const std::string own = ChecksumOf(DayOf(Data({Samples(-50, 95)}), kDay, 20));
  EXPECT_EQ(own.size(), 16U);
  // What lies outside does not matter.
  EXPECT_EQ(ChecksumOf(DayOf(Data({Samples(-20, 300)}), kDay, 20)), own);
  DatedRecords corrected = Data({Samples(-50, 95)});
  corrected.records[0].outputs(0, 60) += 1e-9;
  EXPECT_NE(ChecksumOf(DayOf(corrected, kDay, 20)), own);
}

TEST(DaysTest, NamesAreDates) {
  EXPECT_EQ(NameOfDay(0), "1970-01-01");
  EXPECT_EQ(NameOfDay(19782), "2024-02-29");
}

TEST(DaysTest, FileNamesOfControllersLeadNowhereElse) {
  EXPECT_EQ(FileNameOf("Column-1"), "Column-1");
  EXPECT_EQ(FileNameOf(".."), "_2e_2e");
  EXPECT_EQ(FileNameOf("a b"), "a_20b");
  EXPECT_NE(FileNameOf("a_20b"), FileNameOf("a b"));
}

}  // namespace
}  // namespace mle::watch
