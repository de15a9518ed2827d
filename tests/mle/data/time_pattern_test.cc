// Forms of times: what they read, what they refuse, and what is recognised.

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/data/time_format.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::optional<double> Read(const std::string& pattern,
                           const std::string& text) {
  const absl::StatusOr<TimePattern> compiled = TimePattern::Create(pattern);
  EXPECT_TRUE(compiled.ok()) << compiled.status();
  if (!compiled.ok()) return std::nullopt;
  const std::optional<CivilTime> time = compiled->Read(text);
  if (!time) return std::nullopt;
  return SecondsSinceEpoch(*time);
}

// Seconds from GNU date, as in date -u -d '2024-03-04 06:05:00' +%s.
constexpr double kMarchTime = 1709532300.0;

TEST(TimePatternTest, FieldsAreRead) {
  EXPECT_EQ(Read("%d.%m.%Y %H:%M", "04.03.2024 06:05"), kMarchTime);
  EXPECT_EQ(Read("%d.%m.%Y %H:%M", "4.3.2024 6:05"), kMarchTime);
  EXPECT_EQ(Read("%m/%d/%y %I:%M %p", "3/4/24 6:05 pm"), kMarchTime + 43200);
  EXPECT_EQ(Read("%m/%d/%y %I:%M %p", "3/4/24 12:05 a.m."), kMarchTime - 21600);
  EXPECT_EQ(Read("%d-%b-%y %H:%M:%S", "04-MAR-24 06:05:00.5"),
            kMarchTime + 0.5);
  EXPECT_EQ(Read("%d-%b-%y %H:%M:%S", "04-mar-24 06:05:07,25"),
            kMarchTime + 7.25);
  EXPECT_EQ(Read("%B %d %Y at %H:%M", "March 4 2024 AT 06:05"), kMarchTime);
  EXPECT_EQ(Read("%Y%m%dT%H%M", "20240304T0605"), kMarchTime);
  EXPECT_EQ(Read("%H:%M %d|%m|%Y%z", "06:05 04|03|2024+0100"),
            kMarchTime - 3600);
  EXPECT_EQ(Read("%%%Y %[%m%] %d %H:%M", "%2024  [3]   4 06:05"), kMarchTime);
  EXPECT_EQ(Read("%d-%b-%y %H:%M", "01-Jan-69 00:00"), -31536000.0);
  EXPECT_EQ(Read("%d-%b-%y %H:%M", "01-Dez-68 00:00"), 3121545600.0);
}

TEST(TimePatternTest, PartsInBracketsMayBeMissing) {
  const std::string pattern = "%Y-%m-%d %H[:%M[:%S]][[ ]%z]";
  EXPECT_EQ(Read(pattern, "2024-03-04 06:05:00Z"), kMarchTime);
  EXPECT_EQ(Read(pattern, "2024-03-04 06:05 +01:00"), kMarchTime - 3600);
  EXPECT_EQ(Read(pattern, "2024-03-04 06"), kMarchTime - 300);
  EXPECT_FALSE(Read(pattern, "2024-03-04 06:").has_value());
  EXPECT_FALSE(Read(pattern, "2024-03-04 06:05:00 ").has_value());
}

TEST(TimePatternTest, RefusesOtherTextAndTimesThatDoNotExist) {
  for (const char* const text :
       {"", "04.03.2024", "04.03.2024 06:5", "31.02.2024 06:05",
        "04.13.2024 06:05", "04.03.24 06:05", "04.03.2024 24:01",
        "04.03.2024 06:60", "04.03.2024 06:05 ", "x04.03.2024 06:05"}) {
    EXPECT_FALSE(Read("%d.%m.%Y %H:%M", text).has_value()) << text;
  }
  EXPECT_FALSE(Read("%m/%d/%Y %H:%M %p", "3/4/2024 13:05 PM").has_value());
  EXPECT_FALSE(Read("%m/%d/%Y %H:%M %p", "3/4/2024 0:05 AM").has_value());
  EXPECT_FALSE(Read("%d-%b-%y %H:%M", "04-Ma-24 06:05").has_value());
}

TEST(TimePatternTest, PatternsThatCannotBeAreExplained) {
  const auto error = [](const char* pattern) {
    return std::string(TimePattern::Create(pattern).status().message());
  };
  EXPECT_THAT(error("%d.%m.%Y %T"), AllOf(HasSubstr("'%T'"), HasSubstr("%H")));
  EXPECT_THAT(error("%d.%m.%Y %H:%M%"), HasSubstr("'%'"));
  EXPECT_THAT(error("%d.%m.%Y[ %H:%M"), HasSubstr("not closed"));
  EXPECT_THAT(error("%d.%m.%Y] %H:%M"), HasSubstr("not open"));
  EXPECT_THAT(error("[[[[[[[[[[%d"), HasSubstr("too many brackets"));
  EXPECT_THAT(error("%d.%m. %H:%M"), HasSubstr("no year"));
  EXPECT_THAT(error("%d %Y %H:%M"), HasSubstr("no month"));
  EXPECT_THAT(error("%m %Y %H:%M"), HasSubstr("no day"));
  EXPECT_THAT(error("%d.%m.%Y"), HasSubstr("no hour"));
}

// Each form by its own example, and no certain one by two forms.
TEST(TimeFormatTest, CertainFormsAreDistinct) {
  for (const TimeForm& form : TimeForms()) {
    if (form.patterns.empty()) continue;
    EXPECT_TRUE(ReadCivilTime(form.example, form)) << form.name;
    for (const TimeForm& other : TimeForms()) {
      if (other.name == form.name || !form.is_certain) continue;
      EXPECT_FALSE(ReadCivilTime(form.example, other))
          << form.name << " read as " << other.name;
    }
  }
}

// Three rows at these times.
std::string RowsAt(const std::vector<std::string>& times) {
  std::string text = "time;level;steam\n";
  for (std::size_t k = 0; k < times.size(); ++k) {
    absl::StrAppend(&text, times[k], ";", k, ";", 10 + k, "\n");
  }
  return text;
}

HistorianOptions By(const ClockOptions& clock) {
  HistorianOptions options;
  options.clock = clock;
  return options;
}

struct Stamps {
  std::vector<std::string> times;  // 6:05, 6:06, 6:07 of 4 March 2024
  TimeFormat format;
};

TEST(RecordTimesTest, FormsAreRecognisedIfCertain) {
  for (const Stamps& stamps : std::vector<Stamps>{
           {{"04-Mar-24 06:05:00", "04-Mar-24 06:06:00", "04-Mar-24 06:07:00"},
            TimeFormat::kMonthName},
           {{"04-MAR-24 06:05:00.0", "04-MAR-24 06:06:00.0",
             "04-MAR-24 06:07:00.0"},
            TimeFormat::kMonthName},
           {{"4 Mar 2024 6:05 AM", "4 Mar 2024 6:06 AM", "4 Mar 2024 6:07 AM"},
            TimeFormat::kMonthName},
           {{"2024/03/04 06:05", "2024/03/04 06:06", "2024/03/04 06:07"},
            TimeFormat::kYearFirst},
           {{"2024-03-04T06:05Z", "2024-03-04 06:06:00", "2024-03-04 06:07:00"},
            TimeFormat::kIso},
           {{"1709532300", "1709532360", "1709532420"}, TimeFormat::kUnix},
           {{"1709532300000", "1709532360000", "1709532420000"},
            TimeFormat::kUnixMilliseconds}}) {
    SCOPED_TRACE(stamps.times[0]);
    const auto import = Import(RowsAt(stamps.times));
    ASSERT_TRUE(import.ok()) << import.status();
    EXPECT_EQ(import->report.files[0].time_form, FormOf(stamps.format).name);
    EXPECT_EQ(import->report.time_origin, kMarchTime);
    EXPECT_EQ(import->report.sample_time, 1.0);
    ASSERT_EQ(import->records.size(), 1u);
    EXPECT_EQ(import->records[0].samples(), 3);
  }
}

TEST(RecordTimesTest, OthersAreReadAsDeclared) {
  const auto origin = [](const std::vector<std::string>& times,
                         const ClockOptions& clock) {
    const auto import = Import(RowsAt(times), By(clock));
    EXPECT_TRUE(import.ok()) << import.status();
    if (!import.ok()) return 0.0;
    EXPECT_NEAR(import->records[0].sample_time, 1.0, 1e-9);
    EXPECT_EQ(import->records[0].samples(), 3);
    return import->report.time_origin.value_or(0.0);
  };
  EXPECT_EQ(origin({"04/03/24 06:05", "04/03/24 06:06", "04/03/24 06:07"},
                   {.format = TimeFormat::kDayFirst}),
            kMarchTime);
  EXPECT_EQ(origin({"03/04/24 06:05", "03/04/24 06:06", "03/04/24 06:07"},
                   {.format = TimeFormat::kMonthFirst}),
            kMarchTime);
  EXPECT_EQ(origin({"060524.03.04", "060624.03.04", "060724.03.04"},
                   {.format = TimeFormat::kPattern, .pattern = "%H%M%y.%m.%d"}),
            kMarchTime);
  // 45355 is 2024-03-04 (Excel: =DATEVALUE("2024-03-04")).
  EXPECT_EQ(origin({"45355.2534722222", "45355.2541666667", "45355.2548611111"},
                   {.format = TimeFormat::kExcel}),
            kMarchTime);
}

TEST(RecordTimesTest, WhatIsNotCertainIsAsked) {
  EXPECT_THAT(Error(RowsAt({"03/04/24 06:00"})),
              AllOf(HasSubstr("a.csv: line 2, column 1 ('time'): "
                              "'03/04/24 06:00' is not certain"),
                    HasSubstr("time_format = day_first (2024-04-03)"),
                    HasSubstr("time_format = month_first (2024-03-04)")));
  EXPECT_THAT(Error(RowsAt({"13/04/24 06:00"})),
              AllOf(HasSubstr("time_format = day_first (2024-04-13)"),
                    Not(HasSubstr("month_first"))));
  EXPECT_THAT(Error(RowsAt({"noon"})),
              AllOf(HasSubstr("'noon' is not a time"),
                    HasSubstr("time_format = '%d.%m.%Y %H:%M'")));
  EXPECT_THAT(Error(RowsAt({"2024-03-04 06:00"}),
                    By({.format = TimeFormat::kDayFirst})),
              HasSubstr("the form that time_format = day_first declares "
                        "(29.02.2024 12:34)"));
  EXPECT_THAT(
      Error(RowsAt({"45355.25", "45355.2506944", "45355.2513889"})),
      AllOf(HasSubstr("days of Excel"), HasSubstr("time_format = excel"),
            HasSubstr("time_format = numbers")));
  EXPECT_TRUE(Import(RowsAt({"45355.25", "45355.2506944", "45355.2513889"}),
                     By({.format = TimeFormat::kNumbers}))
                  .ok());
  // Minutes of no special meaning stay minutes.
  EXPECT_TRUE(Import(RowsAt({"45355", "45356", "45357"})).ok());
}

TEST(RecordTimesTest, NewestRowsFirstAreTurnedRound) {
  const std::string oldest = RowsAt({"0", "1", "2"});
  const auto import = Import("time;level;steam\n2;9;3\n1;8;2\n0;7;1\n");
  ASSERT_TRUE(import.ok()) << import.status();
  const Record& record = import->records[0];
  EXPECT_EQ(record.outputs, (Eigen::RowVector3d(7, 8, 9)));
  EXPECT_EQ(record.inputs, (Eigen::RowVector3d(1, 2, 3)));
  EXPECT_TRUE(import->report.files[0].newest_first);
  EXPECT_EQ(import->report.files[0].first_time, 0.0);
  ASSERT_EQ(import->report.notes.size(), 1u);
  EXPECT_THAT(import->report.notes[0].text, HasSubstr("turned round"));

  // Dates count from the oldest, also beyond the rows that are looked at; of
  // two files the order does not matter.
  std::string late = "time;level;steam\n";
  for (int k = 9999; k >= 5000; --k) {
    absl::StrAppend(&late, 1709532300 + 60 * k, ";", k, ";1\n");
  }
  std::string early = "time;level;steam\n";
  for (int k = 0; k < 5000; ++k) {
    absl::StrAppend(&early, 1709532300 + 60 * k, ";", k, ";1\n");
  }
  for (const bool swap : {false, true}) {
    std::vector<HistorianSource> sources = {TextSource("late", late),
                                            TextSource("early", early)};
    if (swap) std::swap(sources[0], sources[1]);
    const auto both = ImportHistorianSources(sources, Tank(), {});
    ASSERT_TRUE(both.ok()) << both.status();
    EXPECT_EQ(both->report.time_origin, kMarchTime);
    ASSERT_EQ(both->records.size(), 1u);
    ASSERT_EQ(both->records[0].samples(), 10000);
    EXPECT_EQ(both->records[0].outputs(0, 9876), 9876.0);
  }
  // A row out of order is named by its line in the file.
  EXPECT_THAT(
      Error("time;level;steam\n9;1;1\n8;1;1\n7;1;1\n6;1;1\n5;1;1\n4;1;1\n"
            "3;1;1\n2;1;1\n1;1;1\n0;1;1\n-1;1;1\n-2;1;1\n6.5;1;1\n-3;1;1\n"),
      HasSubstr("line 13, column 1 ('time'): time -2 follows 6.5"));
}

// In autumn, read from the end.
TEST(RecordTimesTest, NewestFirstWithAnHourTwice) {
  std::string text = "time;level;steam\n";
  for (const char* const time : {"03:30", "03:00", "02:30", "02:00", "02:30",
                                 "02:00", "01:30", "01:00"}) {
    absl::StrAppend(&text, "2024-10-27 ", time, ":00;1;2\n");
  }
  const auto import = Import(text, By({.time_zone = "Europe/Berlin"}));
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->records[0].samples(), 8);
  EXPECT_EQ(import->report.num_gaps, 0);
}

TEST(RecordTimesTest, EachFileMayHaveItsOwnClock) {
  HistorianOptions options;
  options.clocks = {{.format = TimeFormat::kDayFirst},
                    {.format = TimeFormat::kMonthFirst}};
  const std::vector<HistorianSource> sources = {
      TextSource("a.csv", RowsAt({"4.3.24 06:05", "4.3.24 06:06"})),
      TextSource("b.csv", RowsAt({"3/4/24 06:07", "3/4/24 06:08"}))};
  const auto import = ImportHistorianSources(sources, Tank(), options);
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->records.size(), 1u);
  EXPECT_EQ(import->records[0].samples(), 4);
  options.clocks.resize(3);
  EXPECT_THAT(
      std::string(
          ImportHistorianSources(sources, Tank(), options).status().message()),
      AllOf(HasSubstr("one for each of the 2 files"), HasSubstr("there are 3"),
            HasSubstr("time_format")));
}

TEST(RecordTimesTest, FilesThatAllBeginAtZeroAreAQuestion) {
  const std::vector<HistorianSource> sources = {
      TextSource("a.csv", RowsAt({"0", "1", "2"})),
      TextSource("b.csv", RowsAt({"0", "1"}))};
  HistorianOptions options;
  EXPECT_THAT(
      std::string(
          ImportHistorianSources(sources, Tank(), options).status().message()),
      AllOf(HasSubstr("b.csv: line 2, column 1 ('time'): time 0 follows 2"),
            HasSubstr("a.csv and b.csv have the same times"),
            HasSubstr("separate_files = true takes them one after another")));
  options.separate_files = true;
  const auto import = ImportHistorianSources(sources, Tank(), options);
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->records.size(), 2u);
  EXPECT_EQ(import->records[0].outputs, (Eigen::RowVector3d(0, 1, 2)));
  EXPECT_EQ(import->records[1].outputs, (Eigen::RowVector2d(0, 1)));
  EXPECT_GT(import->records[1].start_time, 2.0 + 5.0);
}

}  // namespace
}  // namespace mle
