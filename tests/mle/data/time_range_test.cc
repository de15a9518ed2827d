// The part of records that is read, of files.

#include "mle/data/time_range.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kDates[] =
    "time,level,steam\n2024-03-04 06:00,1,1\n2024-03-04 06:01,2,1\n"
    "2024-03-04 06:02,3,1\n2024-03-04 06:03,4,1\n2024-03-04 06:04,5,1\n";
constexpr char kNumbers[] =
    "time,level,steam\n0,1,1\n1,2,1\n2,3,1\n3,4,1\n4,5,1\n";

TEST(TimeRangeTest, BothLimitsAreIncluded) {
  const HistorianImport dates = ImportOk(
      kDates, {.begin = "2024-03-04 06:01", .end = "2024-03-04T06:03Z"});
  EXPECT_THAT(RowOf(dates.records[0].outputs), ElementsAre(2, 3, 4));
  EXPECT_EQ(dates.report.Times("min").At(0.0), "2024-03-04 06:01");
  const HistorianImport numbers =
      ImportOk(kNumbers, {.begin = "1", .end = "3.0"});
  EXPECT_THAT(RowOf(numbers.records[0].outputs), ElementsAre(2, 3, 4));
  EXPECT_EQ(numbers.records[0].start_time, 1.0);
  EXPECT_THAT(RowOf(ImportOk(kNumbers, {.begin = "2.5"}).records[0].outputs),
              ElementsAre(4, 5));
}

// What lies outside may be anything but of another form of time.
TEST(TimeRangeTest, RowsOutsideAreNotLookedAt) {
  const std::string text = absl::StrCat(kNumbers, "5,Stoerung,1\n6,1,1\n");
  EXPECT_THAT(Error(text), HasSubstr("'Stoerung'"));
  EXPECT_EQ(ImportOk(text, {.end = "4"}).report.rows, 5);
}

TEST(TimeRangeTest, DatesAreInTheZoneOfTheRecords) {
  HistorianOptions options = {.begin = "2024-03-04 06:02"};
  options.clock.time_zone = "Europe/Berlin";
  EXPECT_THAT(RowOf(ImportOk(kDates, options).records[0].outputs),
              ElementsAre(3, 4, 5));
  options.begin = "2024-03-04 05:02Z";
  EXPECT_THAT(RowOf(ImportOk(kDates, options).records[0].outputs),
              ElementsAre(3, 4, 5));
  // A day is its midnight.
  EXPECT_EQ(ImportOk(kDates, {.begin = "2024-03-04"}).report.rows, 5);
  EXPECT_THAT(Error(kDates, {.end = "2024-03-04"}),
              HasSubstr("none of its 5 rows is up to 2024-03-04"));
}

TEST(TimeRangeTest, LongTablesAndNewestFirst) {
  const std::string text =
      "tag,time,value\nlevel,3,4\nsteam,3,1\nlevel,2,3\nsteam,2,1\n"
      "level,1,2\nsteam,1,1\nlevel,0,1\nsteam,0,1\n";
  EXPECT_THAT(
      RowOf(ImportOk(text, {.begin = "1", .end = "2"}).records[0].outputs),
      ElementsAre(2, 3));
  EXPECT_THAT(RowOf(ImportOk("time,level,steam\n3,4,1\n2,3,1\n1,2,1\n0,1,1\n",
                             {.begin = "1"})
                        .records[0]
                        .outputs),
              ElementsAre(2, 3, 4));
}

TEST(TimeRangeTest, MistakesAreNamed) {
  EXPECT_THAT(Error(kDates, {.begin = "noon"}),
              HasSubstr("begin: 'noon' is not a number, nor a date"));
  EXPECT_THAT(Error(kDates, {.begin = "3"}),
              HasSubstr("begin is '3', a number, but the times of the records "
                        "are dates"));
  EXPECT_THAT(Error(kNumbers, {.end = "2024-03-04 06:00"}),
              HasSubstr("end is '2024-03-04 06:00', a date, but"));
  EXPECT_THAT(Error(kNumbers, {.begin = "3", .end = "1"}),
              HasSubstr("end is '1', before begin, '3'"));
  EXPECT_THAT(Error(kNumbers, {.begin = "3", .end = "2024-03-04 06:00"}),
              HasSubstr("both must be dates, or both numbers"));
}

}  // namespace
}  // namespace mle
