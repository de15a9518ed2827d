#include "mle/data/historian.h"

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// An even record is read as it stands, to the last bit.
TEST(HistorianTest, EvenRecordsComeThroughUnchanged) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  std::string text = "time,level,level_setpoint,steam\n";
  std::vector<double> level;
  std::vector<double> steam;
  for (int k = 0; k < 500; ++k) {
    level.push_back(normal(engine));
    steam.push_back(1e6 * normal(engine));
    char row[128];
    std::snprintf(row, sizeof(row), "%.1f,%.17g,%d,%.17g\n", 0.2 * k,
                  level.back(), k >= 250 ? 1 : 0, steam.back());
    text += row;
  }
  const HistorianImport import = ImportOk(text);
  ASSERT_EQ(import.records.size(), 1u);
  const Record& record = import.records[0];
  EXPECT_TRUE(record.Validate().ok());
  EXPECT_EQ(record.sample_time, 0.2);
  EXPECT_EQ(record.start_time, 0.0);
  EXPECT_EQ(RowOf(record.outputs), level);
  EXPECT_EQ(RowOf(record.inputs), steam);
  EXPECT_EQ(record.set_points(0, 249), 0.0);
  EXPECT_EQ(record.set_points(0, 250), 1.0);
  EXPECT_EQ(import.report.num_gaps, 0);
  EXPECT_FALSE(import.report.averaged);
}

TEST(HistorianTest, RecognisesSeparatorsAndDecimalCommas) {
  for (const std::string text :
       {"time;level;steam\n0,0;1,5;2\n0,5;2,5;-3,25e1\n",
        "time\tlevel\tsteam\r\n0,0\t1,5\t2\r\n0,5\t2,5\t-3,25e1\r\n",
        "sep=;\ntime;level;steam\n0,0;1,5;2\n0,5;2,5;-3,25e1\n",
        "\xEF\xBB\xBFtime,level,steam\n0.0,1.5,2\n0.5,2.5,-32.5\n",
        "time,level,steam\n\"0,0\",\"1,5\",2\n\"0,5\",\"2,5\",\"-3,25e1\"\n",
        "time;level;steam\n0.0;1.5;2\n0.5;2.5;-32.5"}) {
    const HistorianImport import = ImportOk(text);
    ASSERT_EQ(import.records.size(), 1u) << text;
    EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1.5, 2.5));
    EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(2, -32.5));
    EXPECT_EQ(import.records[0].sample_time, 0.5);
  }
}

TEST(HistorianTest, AmbiguousNumbersAreErrorsThatSaySo) {
  EXPECT_THAT(Error("time;level;steam\n0;1,234;2\n1;2,345;3\n"),
              HasSubstr("a.csv: line 2, column 2: '1,234' may have a decimal "
                        "comma or one between thousands; declare"));
  EXPECT_THAT(Error("time;level;steam\n0;1,5;2\n1;2.5;3\n"),
              HasSubstr("line 2, column 2: '1,5' has a comma, but '2.5' in "
                        "line 3 a point"));
  EXPECT_THAT(Error("time;level;steam\n0;1.234,5;2\n1;2;3\n"),
              HasSubstr("thousands"));
  EXPECT_THAT(Error("time;level,steam\n0;1;2\n"), HasSubstr("separator"));
  // One clear field settles it, as does a declaration.
  EXPECT_EQ(ImportOk("time;level;steam\n0;1,234;2\n1;0,5;3\n")
                .records[0]
                .outputs(0, 0),
            1.234);
  HistorianOptions options;
  options.decimal = ',';
  EXPECT_EQ(ImportOk("time;level;steam\n0;1,234;2\n1;2,345;3\n", options)
                .records[0]
                .outputs(0, 1),
            2.345);
}

TEST(HistorianTest, OtherColumnsArePassedOverOnRequestOnly) {
  const std::string text =
      "time,level,remark,steam\n0,1,\"so, so\",2\n1,2,x,3\n";
  EXPECT_THAT(Error(text), HasSubstr("line 1, column 3: 'remark' is neither"));
  HistorianOptions options;
  options.columns.ignore_other_columns = true;
  const HistorianImport import = ImportOk(text, options);
  EXPECT_EQ(import.report.files[0].num_ignored_columns, 1);
  EXPECT_THAT(import.report.files[0].ignored_columns, ElementsAre("remark"));
}

TEST(HistorianTest, TagsAreMappedWithTheirUnits) {
  HistorianOptions options;
  options.columns.time_column = "Timestamp";
  options.columns.tags = {{"LIC101.PV", "level", 0.01, -1.0},
                          {"LIC101.SP", "level_setpoint", 0.01, -1.0},
                          {"FC7.OP", "steam"}};
  const Record record = ImportOk(
                            "FC7.OP,LIC101.SP,Timestamp,LIC101.PV\n"
                            "5,100,0,150\n6,200,1,50\n",
                            options)
                            .records[0];
  EXPECT_THAT(RowOf(record.outputs), ElementsAre(0.5, -0.5));
  EXPECT_THAT(RowOf(record.set_points), ElementsAre(0.0, 1.0));
  EXPECT_THAT(RowOf(record.inputs), ElementsAre(5.0, 6.0));

  options.columns.tags = {{"x", "levle"}};
  EXPECT_THAT(Error("time\n", options), HasSubstr("'levle'"));
  options.columns.tags = {{"x", "level", 0.0}};
  EXPECT_THAT(Error("time\n", options), HasSubstr("scale is 0"));
}

TEST(HistorianTest, AUsualNameOfTheColumnOfTimesIsTaken) {
  const std::string rows = ",steam,level\n0,5,1\n1,6,2\n";
  for (const char* name : {"Timestamp", "DateTime", "DATE", "time"}) {
    EXPECT_EQ(ImportOk(name + rows, {}).records[0].samples(), 2) << name;
  }
  // Which one, of two?
  EXPECT_THAT(Error("Date,Timestamp,steam,level\n0,0,5,1\n1,1,6,2\n", {}),
              HasSubstr("there is no column 'time'"));
  HistorianOptions declared;
  declared.columns.time_column = "Zeit";
  EXPECT_THAT(Error("Timestamp" + rows, declared),
              HasSubstr("there is no column 'Zeit'"));
}

TEST(HistorianTest, BadSamplesAreCountedByCause) {
  HistorianOptions options;
  options.bad_values = {"-9999", "Wartung"};
  options.max_gap = 0.0;
  const HistorianImport import = ImportOk(
      "time,level,level_quality,steam\n0,1,Good,2\n1,,good,2\n2,NaN,192,2\n"
      "3,-9999.0,GOOD,2\n4,Bad Input,Good,2\n5,7,Bad,2\n6,8,0,2\n"
      "7,Wartung,192.0,2\n8,9,Good,2\n",
      options);
  const BadSampleCounts& bad = import.report.channels[0].bad;
  EXPECT_EQ(bad.empty, 1);
  EXPECT_EQ(bad.not_a_number, 1);
  EXPECT_EQ(bad.declared, 3);
  EXPECT_EQ(bad.quality, 2);
  EXPECT_EQ(import.report.channels[0].missing, 7);
  EXPECT_THAT(RowOf(import.records[0].outputs),
              ElementsAre(1, IsNan(), IsNan(), IsNan(), IsNan(), IsNan(),
                          IsNan(), IsNan(), 9));
  EXPECT_THAT(Error("time,level,steam\n0,1,2\n1,bude,3\n"),
              HasSubstr("line 3, column 2 ('level'): 'bude' is not a finite"));
  EXPECT_THAT(
      Error("time,level,level.quality,steam\n0,1,0,2\n1,1,0,3\n"),
      HasSubstr("the qualities found are '0'; declare which of them mean"));
}

TEST(HistorianTest, ShortGapsAreBridgedAndLongOnesSplit) {
  std::string text = "time,level,steam\n";
  for (int k = 0; k < 40; ++k) {
    if (k == 3 || k == 4 || (k >= 10 && k < 30)) continue;
    absl::StrAppend(&text, k, ",", k, ",", k % 2, "\n");
  }
  const HistorianImport import = ImportOk(text);
  ASSERT_EQ(import.records.size(), 2u);
  EXPECT_EQ(import.records[0].samples(), 10);
  EXPECT_TRUE(std::isnan(import.records[0].outputs(0, 3)));
  EXPECT_EQ(import.records[0].inputs(0, 3), 0.0);  // held
  EXPECT_EQ(import.records[0].inputs(0, 4), 0.0);
  EXPECT_EQ(import.records[1].start_time, 30.0);
  EXPECT_EQ(import.report.num_gaps, 2);
  EXPECT_FALSE(import.report.gaps[0].splits);
  EXPECT_TRUE(import.report.gaps[1].splits);
  EXPECT_EQ(import.report.channels[0].bridged, 0);
  EXPECT_EQ(import.report.channels[0].missing, 2);
  EXPECT_EQ(import.report.channels[1].bridged, 2);
}

TEST(HistorianTest, TimesThatDoNotIncreaseAreErrorsWithTheirLine) {
  const std::string twice = "time,level,steam\n0,1,2\n1,1,2\n1,1,2\n2,1,2\n";
  EXPECT_THAT(Error(twice),
              HasSubstr("line 4, column 1 ('time'): time 1 is duplicated"));
  HistorianOptions options;
  options.skip_repeated_times = true;
  EXPECT_EQ(ImportOk(twice, options).report.repeated_rows, 1);
  const std::string back =
      "time,level,steam\n0,1,2\n1,1,2\n2,1,2\n0.5,1,2\n3,1,2\n";
  EXPECT_THAT(Error(back), HasSubstr("line 5, column 1 ('time'): time 0.5 "
                                     "follows 2"));
  options.skip_backward_times = true;
  EXPECT_EQ(ImportOk(back, options).report.backward_rows, 1);
  EXPECT_EQ(ImportOk(back, options).records[0].samples(), 4);
}

TEST(HistorianTest, ClocksThatAreSetBackNeedTheirZone) {
  std::string text = "time,level,steam\n";
  for (const char* time : {"00:30", "01:00", "01:30", "02:00", "02:30", "02:00",
                           "02:30", "03:00", "03:30"}) {
    absl::StrAppend(&text, "2024-10-27 ", time, ":00,1,2\n");
  }
  EXPECT_THAT(Error(text),
              HasSubstr("line 7, column 1 ('time'): time 2024-10-27 02:00 "
                        "follows 2024-10-27 02:30; times must increase. It "
                        "goes back by an hour"));
  HistorianOptions options;
  options.clock.time_zone = "Europe/Berlin";
  const HistorianImport import = ImportOk(text, options);
  ASSERT_EQ(import.records.size(), 1u);
  EXPECT_EQ(import.records[0].samples(), 9);
  EXPECT_EQ(import.report.num_gaps, 0);
  EXPECT_EQ(import.records[0].sample_time, 30.0);

  // In spring an hour does not exist.
  EXPECT_THAT(
      Error("time,level,steam\n2024-03-31 01:30:00,1,2\n"
            "2024-03-31 02:30:00,1,2\n",
            options),
      HasSubstr("'2024-03-31 02:30:00' is not a date and time as the first one "
                "is, one that exists in Europe/Berlin"));
  // Neither what the machine has, nor files.
  for (const char* const zone :
       {"Atlantis", "libc:localtime", "localtime", "/etc/localtime",
        "file:/etc/localtime", "../zoneinfo/UTC", ":UTC"}) {
    options.clock.time_zone = zone;
    EXPECT_THAT(Error(text, options),
                HasSubstr(absl::StrCat("no time zone '", zone, "'")));
  }
}

TEST(HistorianTest, DatesMayHaveTheDayFirstIfDeclared) {
  const std::string text =
      "time;level;steam\n31.12.2023 23:59:00;1;2\n1.1.2024 0:00;1;2\n";
  EXPECT_THAT(Error(text), HasSubstr("line 2, column 1"));
  HistorianOptions options;
  options.clock.format = TimeFormat::kDayFirst;
  EXPECT_EQ(ImportOk(text, options).records[0].sample_time, 1.0);
  options.clock.format = TimeFormat::kMonthFirst;
  EXPECT_EQ(ImportOk("time,level,steam\n12/31/2023 11:59:00 PM,1,2\n"
                     "1/1/2024 12:00 AM,1,2\n",
                     options)
                .records[0]
                .sample_time,
            1.0);
  options.clock.format = TimeFormat::kNumbers;
  options.clock.number_unit = "s";
  EXPECT_EQ(ImportOk("time,level,steam\n0,1,2\n60,1,2\n", options)
                .records[0]
                .sample_time,
            1.0);
}

TEST(HistorianTest, DatesNeedAUnitOfTime) {
  const ProcessModel odd("odd", "shift", {{"steam", ""}}, {{"level", ""}});
  EXPECT_THAT(
      std::string(Import("time,level,steam\n2024-02-28 23:59:48,1,2\n", {}, odd)
                      .status()
                      .message()),
      HasSubstr("dates need a time_unit of s, min, h or d"));
}

TEST(HistorianTest, FilesAreJoinedInTime) {
  const std::string late = "steam,time,level\n7,3,1\n7,4,2\n";
  const std::string early = "time;level;steam\n0;1,5;2\n1;1;2\n2;1;2\n";
  const auto import = ImportHistorianSources(
      {TextSource("late.csv", late), TextSource("early.csv", early)}, Tank(),
      {});
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->records.size(), 1u);
  EXPECT_THAT(RowOf(import->records[0].outputs), ElementsAre(1.5, 1, 1, 1, 2));
  EXPECT_EQ(import->report.files[0].name, "early.csv");
  const auto overlap = ImportHistorianSources(
      {TextSource("a.csv", early), TextSource("b.csv", early)}, Tank(), {});
  EXPECT_THAT(std::string(overlap.status().message()),
              HasSubstr("b.csv: line 2, column 1 ('time'): time 0 follows 2"));
  const auto mixed = ImportHistorianSources(
      {TextSource("a.csv", early),
       TextSource("b.csv", "time,level,steam\n2024-01-01 00:00,1,2\n")},
      Tank(), {});
  EXPECT_THAT(std::string(mixed.status().message()),
              HasSubstr("b.csv: its times are dates"));
}

TEST(HistorianTest, OptionsOutOfRangeAreNamed) {
  const auto error = [](auto change) {
    HistorianOptions options;
    change(options);
    return Error("time,level,steam\n0,0,1\n1,4,2\n", options);
  };
  using Options = HistorianOptions;
  EXPECT_THAT(error([](Options& o) { o.separator = '|'; }),
              AllOf(HasSubstr("separator"), HasSubstr("'|'"),
                    HasSubstr("a comma, a semicolon or a tab")));
  EXPECT_THAT(error([](Options& o) { o.decimal = '\''; }),
              AllOf(HasSubstr("decimal"), HasSubstr("a point or a comma")));
  EXPECT_THAT(error([](Options& o) { o.lines_above_header = -1; }),
              AllOf(HasSubstr("lines_above_header"), HasSubstr("-1")));
  EXPECT_THAT(error([](Options& o) { o.rows_below_header = -2; }),
              AllOf(HasSubstr("rows_below_header"), HasSubstr("-2")));
  EXPECT_THAT(error([](Options& o) { o.sample_time = -0.5; }),
              AllOf(HasSubstr("sample_time"), HasSubstr("-0.5")));
  EXPECT_THAT(error([](Options& o) { o.max_gap = HUGE_VAL; }),
              AllOf(HasSubstr("max_gap"), HasSubstr("finite")));
  EXPECT_THAT(error([](Options& o) { o.max_samples = 1; }),
              AllOf(HasSubstr("max_samples"), HasSubstr("at least 2")));
  EXPECT_THAT(error([](Options& o) { o.limits.max_columns = 0; }),
              AllOf(HasSubstr("limits"), HasSubstr("0 columns")));
}

TEST(HistorianTest, ReportsCanBeRead) {
  HistorianOptions options;
  options.columns.ignore_other_columns = true;
  const HistorianImport import = ImportOk(
      "time,level,steam,other\n2024-01-01 00:00:00,1,2,x\n"
      "2024-01-01 00:01:00,,2,x\n2024-01-01 00:02:00,1,2,x\n",
      options);
  const std::string report = import.report.FullReport("min");
  EXPECT_THAT(report, HasSubstr("3 rows of 1 files: 1 records, 3 samples"));
  EXPECT_THAT(report, HasSubstr("1 columns ignored: other"));
  EXPECT_THAT(report, HasSubstr("time 0 is 2024-01-01T00:00:00Z"));
  EXPECT_THAT(report, HasSubstr("level: 1 bad in the files, 1 empty; 0 samples "
                                "bridged, 1 stay bad"));
}

TEST(HistorianTest, FilesThatCannotBeReadAreNamed) {
  const ScratchFolder folder;
  for (const std::string& path :
       {folder / "no_such_file.csv", folder.path(), std::string("/dev/zero")}) {
    const absl::Status status =
        ImportHistorian({path}, Tank(), HistorianOptions()).status();
    EXPECT_FALSE(status.ok());
    EXPECT_THAT(std::string(status.message()), HasSubstr(path));
  }
  const std::string path =
      folder.Write("tank.csv", "time,level,steam\n0,1,2\n1,1,2\n");
  EXPECT_TRUE(ImportHistorian({path}, Tank(), HistorianOptions()).ok());
  EXPECT_FALSE(ImportHistorian(std::vector<std::string>(), Tank(), {}).ok());
}

// Of a text how far in time, of a file how much of it as well; false ends it.
TEST(HistorianTest, ProgressIsToldAndCanStop) {
  std::string text = "time,steam,level\n";
  for (int k = 0; k < 3500; ++k) absl::StrAppend(&text, k, ",1.25,2.5\n");
  std::vector<ImportProgress> told;
  HistorianOptions options;
  options.progress = [&](const ImportProgress& progress) {
    told.push_back(progress);
    return told.size() < 5;
  };
  ASSERT_TRUE(Import(text, options).ok());
  ASSERT_EQ(told.size(), 3);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(told[k].source, "a.csv");
    EXPECT_EQ(told[k].rows, 1000 * (k + 1));
    EXPECT_EQ(told[k].reached, absl::StrCat(1000 * (k + 1) - 1));
    EXPECT_LT(told[k].fraction, 0.0);
  }
  const ScratchFolder folder;
  const std::string path = folder.Write("tank.csv", text);
  const absl::Status status = ImportHistorian({path}, Tank(), options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
  ASSERT_EQ(told.size(), 5);
  EXPECT_EQ(told[4].rows, 2000);
  EXPECT_GE(told[4].fraction, told[3].fraction);
  EXPECT_GT(told[3].fraction, 0.2);
  EXPECT_LE(told[4].fraction, 1.0);
}

}  // namespace
}  // namespace mle
