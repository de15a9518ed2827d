// Exports of many systems and what is said of each: docs/records.md has the
// same table.

#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::ElementsAre;

struct Shape {
  std::string what;                // as in the table of docs/records.md
  std::vector<std::string> files;  // whose level is 1, 2, 3
  std::string said;                // a part of a note, or of the error
  bool is_read = true;
  HistorianOptions options = {};
};

HistorianOptions With(const std::function<void(HistorianOptions&)>& change) {
  HistorianOptions options;
  change(options);
  return options;
}

// Rows of a minute each.
std::string Table(const std::string& header, const std::string& first,
                  const std::string& second, const std::string& third) {
  return absl::StrCat(header, "\n", first, ",1,5\n", second, ",2,6\n", third,
                      ",3,7\n");
}

const char kZero[] = "2024-03-04 06:00";
const char kOne[] = "2024-03-04 06:01";
const char kTwo[] = "2024-03-04 06:02";

std::string Long(const std::string& header, const std::string& zone = "") {
  std::string text = header + "\n";
  for (const char* time : {kZero, kOne, kTwo}) {
    for (const char* tag : {"level", "steam"}) {
      absl::StrAppend(&text, tag, ",", time, zone, ",", 1 + (time[15] - '0'),
                      "\n");
    }
  }
  return text;
}

// Three rows a minute, of which the minute is left.
std::string LostSeconds() {
  std::string text = "time,level,steam\n";
  for (int k = 0; k < 12; ++k) {
    absl::StrAppend(&text, "2024-03-04 06:0", k / 3, ",", k + 1, ",", k % 5,
                    "\n");
  }
  return text;
}

std::vector<Shape> Shapes() {
  const std::string plain = Table("time,level,steam", kZero, kOne, kTwo);
  return {
      {"a date and a time of the day in two columns",
       {"Date,Time,level,steam\n2024-03-04,06:00,1,5\n2024-03-04,06:01,2,6\n"
        "2024-03-04,06:02,3,7\n"},
       "the time is 'Date+Time'"},
      {"a time and its milliseconds in two columns",
       {"Time,ms,level,steam\n2024-03-04 06:00:00,0,1,5\n"
        "2024-03-04 06:00:00,500,2,6\n2024-03-04 06:00:01,0,3,7\n"},
       "the time is 'Time+ms'"},
      {"a column of times of another name",
       {Table("Recorded at (UTC),level,steam", kZero, kOne, kTwo)},
       "the time is 'Recorded at (UTC)'"},
      {"titles above the header",
       {"Plant 7\nExported on Monday\n" + plain},
       "2 lines above the header passed over."},
      {"a row of units",
       {Table("time,level,steam\n,m,t/h", kZero, kOne, kTwo)},
       "1 row below the header passed over, as without time and numbers."},
      {"rows of descriptions and units",
       {Table("time,level,steam\n,Level of the tank,Steam\n,m,t/h", kZero, kOne,
              kTwo)},
       "2 rows below the header passed over"},
      {"comments, as loggers write them",
       {"time,level,steam\n# started\n" + plain.substr(plain.find('\n') + 1)},
       "1 row of comments or repeated headers: passed over."},
      {"the header again, where files were put together",
       {Table("time,level,steam", kZero, kOne,
              absl::StrCat(kTwo, ",3,7\ntime,level,steam\n2024-03-04 06:03"))},
       "1 row of comments or repeated headers: passed over."},
      {"the newest rows first",
       {absl::StrCat("time,level,steam\n", kTwo, ",3,7\n", kOne, ",2,6\n",
                     kZero, ",1,5\n")},
       "the newest rows stand first"},
      {"a row for each sample",
       {Long("tag,time,value")},
       "a long table, with a row for each sample, of 2 tags."},
      {"the same from Home Assistant",
       {Long("entity_id,last_changed,state", ":00+00:00")},
       "a long table, with a row for each sample"},
      {"the same from InfluxDB",
       {Long("#group,false,true\n_field,_time,_value")},
       "a long table, with a row for each sample"},
      {"the same from AVEVA Historian",
       {Long("TagName,DateTime,vValue")},
       "a long table, with a row for each sample"},
      {"the same, tags in a column of any name",
       {Long("Messstelle,Zeit,Wert")},
       "a long table, with a row for each sample"},
      {"one file for each tag",
       {absl::StrCat("Timestamp,level\n", kZero, ",1\n", kOne, ",2\n", kTwo,
                     ",3\n"),
        absl::StrCat("Timestamp,steam\n", kZero, ",5\n", kOne, ",6\n", kTwo,
                     ",7\n")},
       "2 files with tags of their own, joined by their times."},
      {"a quality beside its column",
       {absl::StrCat("time,level,level::status,steam\n", kZero, ",1,Good,5\n",
                     kOne, ",2,Good,6\n", kTwo, ",3,Good,7\n")},
       "'level::status' says how good samples are."},
      {"one quality for all columns",
       {absl::StrCat("time,OPCQuality,level,steam\n", kZero, ",192,1,5\n", kOne,
                     ",192,2,6\n", kTwo, ",192,3,7\n")},
       "'OPCQuality' says how good samples are."},
      {"seconds that were lost, to be spread",
       {LostSeconds()},
       "8 rows at a time that was already read: spread evenly",
       true,
       With([](HistorianOptions& o) { o.spread_repeated_times = true; })},
      {"rows twice, to be ignored",
       {absl::StrCat("time,level,steam\n", kZero, ",1,5\n", kOne, ",2,6\n",
                     kOne, ",2,6\n", kTwo, ",3,7\n")},
       "1 row at a time that was already read: ignored",
       true,
       With([](HistorianOptions& o) { o.skip_repeated_times = true; })},
      {"rows without a value",
       {absl::StrCat(plain, "2024-03-04 06:03,,\n2024-03-04 06:04,4,8\n")},
       "1 row without any good sample: left as gaps."},
      {"a time range",
       {plain + "2024-03-04 06:03,4,8\n"},
       "1 row outside of the time range: not read.",
       true,
       With([](HistorianOptions& o) { o.end = kTwo; })},
      {"semicolons and decimal commas",
       {"time;level;steam\n2024-03-04 06:00;1,0;5\n2024-03-04 06:01;2,0;6\n"
        "2024-03-04 06:02;3,0;7\n"},
       "separated by semicolon, decimal comma"},
      {"tabs",
       {"time\tlevel\tsteam\n0\t1\t5\n1\t2\t6\n2\t3\t7\n"},
       "separated by tab"},
      {"the separator in a line of its own",
       {"sep=;\ntime;level;steam\n0;1;5\n1;2;6\n2;3;7\n"},
       "separated by semicolon"},
      {"a byte-order mark and the ends of lines of Windows",
       {"\xEF\xBB\xBFtime,level,steam\r\n0,1,5\r\n1,2,6\r\n2,3,7\r\n"},
       "times as numbers"},
      {"months by name, as PI and IP.21 have them",
       {Table("Timestamp,level,steam", "04-Mar-24 06:00:00",
              "04-Mar-24 06:01:00", "04-Mar-24 06:02:00")},
       "times as month_name"},
      {"months by name, and AM",
       {Table("Timestamp,level,steam", "4 Mar 2024 6:00 AM",
              "4 Mar 2024 6:01 AM", "4 Mar 2024 6:02 AM")},
       "times as month_name"},
      {"seconds since 1970",
       {Table("time,level,steam", "1709532000", "1709532060", "1709532120")},
       "times as unix"},
      {"milliseconds since 1970",
       {Table("time,level,steam", "1709532000000", "1709532060000",
              "1709532120000")},
       "times as unix_ms"},
      {"dates with a zone",
       {Table("time,level,steam", "2024-03-04T06:00:00+01:00",
              "2024-03-04T06:01:00+01:00", "2024-03-04T06:02:00+01:00")},
       "time 0 is 2024-03-04T05:00:00"},
      {"the index of a data frame",
       {Table(",level,steam", kZero, kOne, kTwo)},
       "times as iso"},
      {"names in other case and with blanks",
       {Table("Time, LEVEL ,Steam", kZero, kOne, kTwo)},
       "level (column 'LEVEL'): 0 bad in the files"},
      {"midnight as 24:00",
       {Table("time,level,steam", "2024-03-03 23:59", "2024-03-03 24:00",
              "2024-03-04 00:01")},
       "time 0 is 2024-03-03T23:59:00"},
      {"words in place of values",
       {"time,level,steam\n0,1,5\n1,2,Bad Input\n2,3,7\n"},
       "1 bad values"},
      {"a name with its unit",
       {Table("time,level (m),steam", kZero, kOne, kTwo)},
       "there is no column 'level' (nearest: 'level (m)')",
       false},
      {"thousands with commas",
       {"time,level,steam\n0,\"1,000\",5\n1,\"2,000\",6\n"},
       "declare decimal",
       false},
      {"values with their unit",
       {"time,level,steam\n0,1 m,5\n1,2 m,6\n"},
       "'1 m' is not a finite number",
       false},
      {"states as words",
       {"time,level,steam\n0,1,Open\n1,2,Closed\n"},
       "Name those that mean bad in bad_values",
       false},
      {"a separator at the end of each row",
       {"time,level,steam,\n0,1,5,\n1,2,6,\n2,3,7,\n"},
       "ignore_other_columns = true",
       false},
      {"times of the day without a date",
       {Table("time,level,steam", "06:00:00", "06:01:00", "06:02:00")},
       "time_format",
       false},
  };
}

std::string SaidOf(const Shape& shape, std::vector<double>& level) {
  std::vector<HistorianSource> sources;
  for (const std::string& file : shape.files) {
    sources.push_back(
        TextSource(absl::StrCat("f", sources.size(), ".csv"), file));
  }
  const auto import = ImportHistorianSources(sources, Tank(), shape.options);
  EXPECT_EQ(import.ok(), shape.is_read) << import.status();
  if (!import.ok()) return std::string(import.status().message());
  level = RowOf(import->records.at(0).outputs);
  return import->report.FullReport("min");
}

TEST(ExportShapesTest, AreReadAndSaid) {
  for (const Shape& shape : Shapes()) {
    SCOPED_TRACE(shape.what);
    std::vector<double> level;
    EXPECT_THAT(SaidOf(shape, level), ::testing::HasSubstr(shape.said));
    if (!shape.is_read) continue;
    level.resize(3);
    EXPECT_THAT(level, ElementsAre(1, 2, 3));
  }
}

// What is tested is what is said.
TEST(ExportShapesTest, TheTableIsTheOneInTheDocs) {
  std::ifstream in(MLE_RECORDS_PAGE);
  const std::string docs(std::istreambuf_iterator<char>(in), {});
  std::string table = "|---|---|\n";
  for (const Shape& shape : Shapes()) {
    absl::StrAppend(&table, "| ", shape.what, " | ",
                    shape.is_read ? "" : "refused: ", shape.said, " |\n");
  }
  EXPECT_TRUE(absl::StrContains(docs, table)) << "the table should be\n"
                                              << table;
}

}  // namespace
}  // namespace mle
