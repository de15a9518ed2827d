// Exports as loggers and laboratories write them: a time in two columns, no
// header, lost seconds, long tables by other names, 24:00, qualities by any
// name, samples that are taken now and then.

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/data/tag_file.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

auto HasNote(const std::string& part) {
  return Contains(Field(&ImportNote::text, HasSubstr(part)));
}

std::string ProposalError(const std::string& text,
                          const HistorianOptions& options = {}) {
  const absl::Status status =
      ProposeTags({TextSource("a.csv", text)}, Tank(), options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  return std::string(status.message());
}

absl::StatusOr<HistorianImport> ImportFiles(
    const std::vector<HistorianSource>& files,
    const HistorianOptions& options = {}) {
  return ImportHistorianSources(files, Tank(), options);
}

// A file for each tag, of its own separator, named in the header or by the
// file's name, with times of its own.
TEST(OneFileForEachTagTest, FilesAreJoinedByTheirTimes) {
  const HistorianSource level =
      TextSource("export/level.csv",
                 "Timestamp,Value\n2024-01-01 00:00,1\n2024-01-01 00:01,2\n"
                 "2024-01-01 00:02,3\n2024-01-01 00:03,4\n");
  const HistorianSource steam =
      TextSource("x.csv",
                 "steam;time\n5;2024-01-01 00:00\n5;2024-01-01 00:01\n"
                 "7;2024-01-01 00:02\n7;2024-01-01 00:03\n");
  const absl::StatusOr<HistorianImport> import = ImportFiles({level, steam});
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->records.size(), 1u);
  EXPECT_THAT(RowOf(import->records[0].outputs), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(RowOf(import->records[0].inputs), ElementsAre(5, 5, 7, 7));
  EXPECT_THAT(import->report.notes,
              HasNote("2 files with tags of their own, joined by their times"));
}

// The tags that have files are proposed; a file alone has no name to propose.
TEST(OneFileForEachTagTest, TagsAreProposedByTheNamesOfFiles) {
  const HistorianSource level =
      TextSource("LI7.csv.gz", "time,value\n0,1\n1,2\n");
  const HistorianSource steam = TextSource("b.csv", "time,FC2\n0,1\n1,2\n");
  const auto proposals = ProposeTags({level, steam}, Tank(), {});
  ASSERT_TRUE(proposals.ok()) << proposals.status();
  ASSERT_EQ(proposals->size(), 2u);
  EXPECT_EQ((*proposals)[0].tag, "LI7");
  EXPECT_EQ((*proposals)[1].tag, "FC2");
  EXPECT_THAT(ProposalError("time,value\n0,1\n1,2\n"),
              HasSubstr("there is nothing to propose"));
}

// January and February of each tag; the tags' names are mapped.
TEST(OneFileForEachTagTest, ATagMayHaveSeveralFiles) {
  HistorianOptions options;
  options.columns.tags = {{"TI1.PV", "level"}, {"FC2.OP", "steam"}};
  const absl::StatusOr<HistorianImport> import =
      ImportFiles({TextSource("1.csv", "time,FC2.OP\n0,5\n1,6\n"),
                   TextSource("2.csv", "time,FC2.OP\n2,7\n3,8\n"),
                   TextSource("3.csv", "time,TI1.PV\n0,1\n1,2\n"),
                   TextSource("4.csv", "time,TI1.PV\n2,3\n3,4\n")},
                  options);
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_THAT(RowOf(import->records[0].outputs), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(RowOf(import->records[0].inputs), ElementsAre(5, 6, 7, 8));
}

TEST(OneFileForEachTagTest, QualitiesAreOfTheTagOfTheirFile) {
  const HistorianSource level =
      TextSource("level.csv",
                 "time,value,status\n0,1,Good\n1,99,Bad\n2,3,Good\n3,4,Good\n");
  const HistorianSource steam =
      TextSource("steam.csv", "time,value\n0,5\n1,5\n2,7\n3,7\n");
  const absl::StatusOr<HistorianImport> import = ImportFiles({level, steam});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_THAT(RowOf(import->records[0].outputs), ElementsAre(1, IsNan(), 3, 4));
  EXPECT_THAT(RowOf(import->records[0].inputs), ElementsAre(5, 5, 7, 7));
}

// Dates are no numbers: beside one column of values words are qualities.
TEST(OneFileForEachTagTest, AllMayHaveQualitiesAndDates) {
  const auto text = [](int first) {
    return absl::StrCat("Timestamp;Value;Status\n2024-01-01 00:00;", first,
                        ";Good\n2024-01-01 00:01;", first + 1,
                        ";Good\n2024-01-01 00:02;99;Bad\n2024-01-01 00:03;",
                        first + 3, ";Good\n");
  };
  const absl::StatusOr<HistorianImport> import = ImportFiles(
      {TextSource("level.csv", text(1)), TextSource("steam.csv", text(5))});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_THAT(RowOf(import->records[0].outputs), ElementsAre(1, 2, IsNan(), 4));
}

// What is missing in all of them is said of all of them; a file that is not
// understood, or files of the same tags, are as before.
TEST(OneFileForEachTagTest, MistakesAreSaid) {
  const HistorianSource level = TextSource("a.csv", "time,level\n0,1\n1,2\n");
  const auto error = [&](const HistorianSource& other) {
    return std::string(ImportFiles({level, other}).status().message());
  };
  EXPECT_THAT(error(TextSource("b.csv", "time,fan\n0,1\n1,2\n")),
              AllOf(HasSubstr("a.csv and 1 more, joined: "),
                    HasSubstr("there is no column 'steam'")));
  EXPECT_THAT(error(TextSource("b.csv", "time,level\n2,1\n3,2\n")),
              HasSubstr("a.csv: line 1"));
  EXPECT_THAT(error(TextSource("b.csv", "time,steam\n0,1\n1\n")),
              HasSubstr("b.csv: line 3, column 1: the row ends after 1"));
}

TEST(TwoColumnsOfTimeTest, ADateAndATimeOfTheDayAreJoined) {
  for (const std::string text :
       {"date,time,level,steam\n2024-01-01,23:59:00,1,5\n"
        "2024-01-02,00:00:00,2,6\n2024-01-02,00:01:00,3,7\n",
        "Clock;Day;level;steam\n23:59;01.12.2024 00:00;1,5;5\n"
        "00:00;02.12.2024 00:00;2,5;6\n00:01;02.12.2024 00:00;3,5;7\n"}) {
    SCOPED_TRACE(text);
    HistorianOptions options;
    if (text[0] == 'C') options.clock.format = TimeFormat::kDayFirst;
    const HistorianImport import = ImportOk(text, options);
    ASSERT_EQ(import.records.size(), 1u);
    EXPECT_DOUBLE_EQ(import.records[0].sample_time, 1.0);
    EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(5, 6, 7));
    EXPECT_THAT(import.report.notes, HasNote("the time is '"));
  }
}

TEST(TwoColumnsOfTimeTest, SoAreATimeAndItsMilliseconds) {
  HistorianOptions options;
  options.clock.format = TimeFormat::kDayFirst;
  const std::string text =
      "Time,Milliseconds,level,steam\n15/06/2024 01:00:00,0,1,5\n"
      "15/06/2024 01:00:00,500,2,6\n15/06/2024 01:00:01,0,3,7\n";
  for (const bool declared : {false, true}) {
    if (declared) options.columns.time_column = "Time+Milliseconds";
    const HistorianImport import = ImportOk(text, options);
    ASSERT_EQ(import.records.size(), 1u);
    EXPECT_NEAR(import.records[0].sample_time, 0.5 / 60.0, 1e-6);
    EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 2, 3));
  }
}

TEST(TwoColumnsOfTimeTest, MayBeDeclaredAndMissing) {
  HistorianOptions options;
  options.columns.time_column = "Tag+Uhr";
  options.columns.ignore_other_columns = true;
  options.clock.format = TimeFormat::kPattern;
  options.clock.pattern = "%Y%m%d %H%M";
  EXPECT_THAT(RowOf(ImportOk("Uhr,Tag,level,steam\n2359,20240101,1,5\n"
                             "0000,20240102,2,6\n",
                             options)
                        .records[0]
                        .outputs),
              ElementsAre(1, 2));
  EXPECT_THAT(Error("Zeit,Tag,level,steam\n2359,20240101,1,5\n", options),
              HasSubstr("there is no column 'Uhr'"));
}

// A date that has its time, beside seconds since the start, is enough.
TEST(TwoColumnsOfTimeTest, OtherTablesAreReadAsBefore) {
  const HistorianImport import = ImportOk(
      "time,elapsed,level,steam\n2024-01-01 00:00,0,1,5\n"
      "2024-01-01 00:01,60,2,6\n",
      {.columns = {.ignore_other_columns = true}});
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 2));
  // The index of a data frame has no name.
  EXPECT_THAT(ImportOk(",level,steam\n2024-01-01 00:00,1,5\n"
                       "2024-01-01 00:01,2,6\n")
                  .records[0]
                  .samples(),
              2);
}

TEST(NoHeaderTest, IsSaidAndGiven) {
  const std::string text =
      "Jan 02 2020 00:00:07;19.00;None\nJan 02 2020 00:02:07;19.01;5\n"
      "Jan 02 2020 00:04:07;19.02;6\n";
  EXPECT_THAT(Error(text), AllOf(HasSubstr("a.csv: line 1: there is no header"),
                                 HasSubstr("'Jan 02 2020 00:00:07', '19.00'"),
                                 HasSubstr("header = ")));
  EXPECT_THAT(ProposalError(text), HasSubstr("there is no header"));
  EXPECT_THAT(Error("1577836800,225,210.0,nan\n1577836860,225,210.5,nan\n"),
              HasSubstr("there is no header"));
  HistorianOptions options;
  options.header = {"time", "level", "steam"};
  const HistorianImport import = ImportOk(text, options);
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(19, 19.01, 19.02));
  EXPECT_DOUBLE_EQ(import.records[0].sample_time, 2.0);
  options.header = {"time", "level"};
  EXPECT_THAT(Error(text, options),
              HasSubstr("header has 2 names, line 1 has 3 fields"));
  options.header = {"time", "level", "steam"};
  EXPECT_THAT(Error("Jan 02 2020 00:00:07;19.00;1\nJan 02 2020 00:01:07;x;1\n",
                    options),
              HasSubstr("a.csv: line 2, column 2 ('level'): 'x'"));
}

// Tags that are numbers are a header.
TEST(NoHeaderTest, IsNotSaidOfOthers) {
  HistorianOptions options;
  options.columns.tags = {{"101", "level"}, {"102", "steam"}};
  EXPECT_EQ(ImportOk("time,101,102\n0,1,5\n1,2,6\n", options).report.rows, 2);
}

TEST(LostSecondsTest, AreSaidAndSpread) {
  std::string text = "time;level;steam\n";
  // Begins with the second of three rows.
  int value = 0;
  for (int minute = 0; minute < 6; ++minute) {
    for (int row = minute == 0 ? 1 : 0; row < 3; ++row, ++value) {
      absl::StrAppend(&text, "2017-03-10 01:0", minute, ";", value, ";",
                      value % 5, "\n");
    }
  }
  EXPECT_THAT(Error(text), AllOf(HasSubstr("3 rows share each time"),
                                 HasSubstr("spread_repeated_times = true"),
                                 HasSubstr("skip_repeated_times = true")));
  HistorianOptions options;
  options.skip_repeated_times = true;
  const HistorianImport skipped = ImportOk(text, options);
  EXPECT_EQ(skipped.report.repeated_rows, 11);
  EXPECT_THAT(skipped.report.notes,
              HasNote("11 rows at a time that was already read"));
  options.skip_repeated_times = false;
  options.spread_repeated_times = true;
  const HistorianImport spread = ImportOk(text, options);
  ASSERT_EQ(spread.records.size(), 1u);
  EXPECT_NEAR(spread.records[0].sample_time, 1.0 / 3.0, 1e-6);
  EXPECT_THAT(
      RowOf(spread.records[0].outputs),
      ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
  EXPECT_THAT(spread.report.notes, HasNote("spread evenly"));
}

TEST(LostSecondsTest, OfLongTablesToo) {
  std::string text = "tag,time,value\n";
  for (int minute = 0; minute < 6; ++minute) {
    for (int row = 0; row < 2; ++row) {
      for (const std::string tag : {"level", "steam"}) {
        absl::StrAppend(&text, tag, ",2017-03-10 01:0", minute, ",",
                        2 * minute + row, "\n");
      }
    }
  }
  EXPECT_THAT(Error(text), AllOf(HasSubstr("one of 12 such rows"),
                                 HasSubstr("spread_repeated_times")));
  HistorianOptions options;
  options.spread_repeated_times = true;
  const HistorianImport import = ImportOk(text, options);
  EXPECT_THAT(RowOf(import.records[0].inputs),
              ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  options = {};
  options.skip_repeated_times = true;
  EXPECT_EQ(ImportOk(text, options).report.repeated_rows, 12);
}

TEST(LongTableNamesTest, OfOtherSystemsAreKnown) {
  for (const std::string header :
       {"entity_id,state,last_changed", "_field,_value,_time",
        "TagName,TagVal,DateTime", "TagName,vValue,DateTime",
        "sensor_name,reading_1,Zeit der Messung"}) {
    SCOPED_TRACE(header);
    const HistorianImport import = ImportOk(
        header +
        "\nlevel,1,2025-01-10T00:00:00.000Z\nsteam,5,2025-01-10T00:00:00.000Z\n"
        "level,2,2025-01-10T00:01:00.000Z\nsteam,6,2025-01-10T00:01:00.000Z\n");
    EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 2));
    EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(5, 6));
  }
}

TEST(LongTableNamesTest, AnnotationsAndRepeatedHeadersArePassedOver) {
  const std::string table =
      "#group,false,false,true\n#datatype,string,dateTime,double,string\n"
      ",result,_time,_value,_field\n,,2025-01-10T00:00:00Z,1,level\n"
      ",,2025-01-10T00:01:00Z,2,level\n";
  std::string other = absl::StrReplaceAll(table, {{",level", ",steam"}});
  const HistorianImport import = ImportOk(table + "\n" + other);
  EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(1, 2));
  EXPECT_THAT(import.report.notes, HasNote("3 rows of comments or repeated"));
}

TEST(LongTableNamesTest, WhatIsNotCertainIsAskedFor) {
  EXPECT_THAT(
      Error("what,a,b,when\nlevel,1,1,2025-01-10T00:00:00Z\n"
            "steam,5,1,2025-01-10T00:00:00Z\n"),
      AllOf(HasSubstr("a row for each sample, with tags in the column 'what'"),
            HasSubstr("tag_column = what, value_column and time_column")));
  HistorianOptions options;
  options.columns.tag_column = "wha";
  EXPECT_THAT(Error("what,a,when\nlevel,1,2025-01-10T00:00:00Z\n", options),
              HasSubstr("there is no column 'wha' (tag_column)"));
  // Without a name that is known nothing is proposed.
  EXPECT_THAT(ProposalError("what,a,when\nTI1,1,2025-01-10T00:00:00Z\n"
                            "FI2,5,2025-01-10T00:00:00Z\n"),
              HasSubstr("a row for each sample, with tags in 'what'"));
  EXPECT_THAT(ProposalError("TI1,FI2\n1,2\n2,3\n"),
              HasSubstr("no column is known to hold the time"));
}

TEST(CommentsTest, ArePassedOverAndCounted) {
  const HistorianImport import = ImportOk(
      "# logger 7\n# time,level,steam\n0,1,5\n# it \"rains\", a lot\n1,2,6\n"
      "// restarted\ntime,level,steam\n2,3,7\n");
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 2, 3));
  EXPECT_EQ(import.report.comment_rows, 3);
  // A word of a spreadsheet is a sample.
  EXPECT_THAT(RowOf(ImportOk("level,time,steam\n1,0,5\n#N/A,1,6\n3,2,7\n")
                        .records[0]
                        .outputs),
              ElementsAre(1, IsNan(), 3));
}

TEST(MidnightTest, MayBe24OfTheDayThatEnds) {
  const HistorianImport import = ImportOk(
      "time,level,steam\n2024-12-31 23:00,1,5\n2024-12-31 24:00,2,6\n"
      "2025-01-01 01:00,3,7\n");
  ASSERT_EQ(import.records.size(), 1u);
  EXPECT_DOUBLE_EQ(import.records[0].sample_time, 60.0);
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 2, 3));
  EXPECT_THAT(Error("time,level,steam\n2024-12-31 23:00,1,5\n"
                    "2024-12-31 24:01,2,6\n"),
              HasSubstr("'2024-12-31 24:01' is not"));
}

// The same samples give the same answer whatever the column is called.
TEST(QualityTest, IsKnownByAnyUsualName) {
  for (const std::string name :
       {"level_quality", "level.OPCQuality", "level TagQuality",
        "level::status", "level_status", "Quality level", "levelQuality",
        "level[q]", "OPCQuality"}) {
    for (const std::string good : {"Good", "192", "216", "GoodNonSpecific"}) {
      for (const std::string bad : {"Bad", "0", "24", "Uncertain"}) {
        SCOPED_TRACE(absl::StrCat(name, ": ", good, ", ", bad));
        const HistorianImport import =
            ImportOk(absl::StrCat("time,level,", name, ",steam\n0,1,", good,
                                  ",5\n1,2,", bad, ",6\n2,3,", good, ",7\n"));
        EXPECT_THAT(RowOf(import.records[0].outputs),
                    ElementsAre(1, IsNan(), 3));
        EXPECT_EQ(import.report.channels[0].bad.quality, 1);
        if (name == "level_quality") continue;  // as declared
        EXPECT_THAT(import.report.notes, HasNote("how good samples are"));
      }
    }
  }
}

TEST(QualityTest, FlagsAndFaultsAreToldApart) {
  const auto outputs = [](const std::string& name, const std::string& first,
                          const std::string& second) {
    return RowOf(
        ImportOk(absl::StrCat("time,level,", name, ",steam\n0,1,", first,
                              ",5\n1,2,", second, ",6\n2,3,", first, ",7\n"))
            .records[0]
            .outputs);
  };
  for (const std::string name : {"level_Good", "Good", "level.IsValid"}) {
    EXPECT_THAT(outputs(name, "True", "False"), ElementsAre(1, IsNan(), 3));
    EXPECT_THAT(outputs(name, "1", "0"), ElementsAre(1, IsNan(), 3));
  }
  for (const std::string name :
       {"level.Questionable", "Questionable", "level_Substituted"}) {
    EXPECT_THAT(outputs(name, "False", "True"), ElementsAre(1, IsNan(), 3));
    EXPECT_THAT(outputs(name, "0", "1"), ElementsAre(1, IsNan(), 3));
  }
}

TEST(QualityTest, OfLongTablesAllMustBeGood) {
  const HistorianImport import = ImportOk(
      "tag,time,value,Good,Questionable,Substituted\n"
      "level,0,1,True,False,False\nlevel,1,2,True,True,False\n"
      "level,2,3,True,False,True\nlevel,3,4,False,False,False\n"
      "level,4,5,True,False,False\nsteam,0,5,True,False,False\n"
      "steam,1,5,True,False,False\nsteam,2,5,True,False,False\n"
      "steam,3,6,True,False,False\nsteam,4,6,True,False,False\n");
  EXPECT_THAT(RowOf(import.records[0].outputs),
              ElementsAre(1, IsNan(), IsNan(), IsNan(), 5));
}

TEST(QualityTest, WhatIsNotUsualIsRefusedByName) {
  EXPECT_THAT(Error("time,level,level_QC,steam\n0,1,A7,5\n1,2,A7,6\n"),
              HasSubstr("if 'level_QC' says how good samples of 'level' are: "
                        "quality_suffixes = _QC"));
  EXPECT_THAT(Error("time,level,level::status,steam\n0,1,A7,5\n1,2,A7,6\n"),
              AllOf(HasSubstr("'level' has no good sample, as its quality"),
                    HasSubstr("good_qualities = A7")));
  HistorianOptions options;
  options.good_qualities = {"A7"};
  EXPECT_THAT(RowOf(ImportOk("time,level,level::status,steam\n0,1,A7,5\n"
                             "1,2,192,6\n2,3,A7,7\n",
                             options)
                        .records[0]
                        .outputs),
              ElementsAre(1, IsNan(), 3));
  // A status that is not of samples is a column as any other.
  EXPECT_THAT(Error("time,level,status,steam\n0,1,RUN,5\n1,2,RUN,6\n"),
              HasSubstr("'status' is neither time nor"));
}

// A laboratory's tag in a long table: its samples are not held.
TEST(PointsTest, OutputsThatAreMeasuredNowAndThenAreNotHeld) {
  std::string text = "tag,time,value\n";
  for (int k = 0; k < 60; ++k)
    absl::StrAppend(&text, "steam,", k, ",", k, "\n");
  for (int k = 0; k < 6; ++k) {
    absl::StrAppend(&text, "level,", 10 * k + 0.4 * (k % 2), ",", 100 + k,
                    "\n");
  }
  HistorianOptions options;
  options.sample_time = 1.0;
  const HistorianImport import = ImportOk(text, options);
  ASSERT_EQ(import.records.size(), 1u);
  const std::vector<double> level = RowOf(import.records[0].outputs);
  int measured = 0;
  for (std::size_t k = 0; k < level.size(); ++k) {
    if (level[k] == level[k]) ++measured;
  }
  EXPECT_EQ(measured, 6);
  EXPECT_EQ(level[0], 100);
  EXPECT_EQ(level[11], 101);  // of 10.4
  EXPECT_EQ(level[20], 102);
  // Who says so has them held.
  options.empty_fields = EmptyFields::kUnchanged;
  EXPECT_EQ(RowOf(ImportOk(text, options).records[0].outputs)[5], 100);
}

}  // namespace
}  // namespace mle
