// Mistakes in exports and what mle_correct answers: exit code 2 and one line
// that names the file and the flag that helps.

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "apps/report/process.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

struct Mistake {
  std::string what;
  std::vector<std::string> files;
  std::vector<std::string> flags;
  std::string message;  // a part of it
};

constexpr char kHeader[] = "time,y1,y2,u1,u2\n";

// Rows at these times, with values that change.
std::string Rows(const std::vector<std::string>& times,
                 const std::string& header = kHeader) {
  std::string text = header;
  for (std::size_t k = 0; k < times.size(); ++k) {
    absl::StrAppend(&text, times[k], ",", k % 7, ",", k % 5, ",1,", k % 3,
                    "\n");
  }
  return text;
}

std::vector<Mistake> Mistakes() {
  const std::string minutes = Rows({"0", "1", "2"});
  return {
      // Times.
      {"day or month first",
       {Rows({"03/04/24 06:00", "03/04/24 06:01"})},
       {},
       "day_first (2024-04-03) or --time_format=month_first (2024-03-04)"},
      {"day first, and nothing else possible",
       {Rows({"13.04.2024 06:00", "13.04.2024 06:01"})},
       {},
       "declare --time_format=day_first (2024-04-13)"},
      {"days of Excel",
       {Rows({"45355.25", "45355.2506944", "45355.2513889"})},
       {},
       "look like the days of Excel; declare --time_format=excel"},
      {"a form of time that is not known",
       {Rows({"4. Tag 6 Uhr"})},
       {},
       "declare another one, such as --time_format='%d.%m.%Y %H:%M'"},
      {"another form than declared",
       {Rows({"2024-03-04 06:00"})},
       {"--time_format=month_first"},
       "of the form that --time_format=month_first declares"},
      {"a form without a year",
       {minutes},
       {"--time_format=%d.%m. %H:%M"},
       "has no year (%Y or %y)"},
      {"an hour twice, in autumn",
       {Rows({"2024-10-27 01:30", "2024-10-27 02:00", "2024-10-27 02:30",
              "2024-10-27 02:00", "2024-10-27 02:30", "2024-10-27 03:00"})},
       {},
       "as clocks do in autumn: declare --time_zone, such as"},
      {"a time twice",
       {Rows({"0", "1", "1", "2"})},
       {},
       "rows at the same time be ignored (--skip_repeated_times=true)"},
      {"seconds that were lost",
       {Rows({"0", "0", "0", "1", "1", "1", "2", "2", "2", "3", "3", "3"})},
       {},
       "3 rows share each time: their seconds were lost"},
      {"no header",
       {Rows({"0", "1", "2"}, "")},
       {},
       "there is no header: samples ("},
      {"fewer names than columns",
       {Rows({"0", "1", "2"}, "")},
       {"--header=time,y1"},
       "--header has 2 names, line 1 has"},
      {"tags in a column of another name",
       {"what,a,b,when\ny1,1,1,2024-03-04 06:00\ny2,5,1,2024-03-04 06:00\n"},
       {},
       "with tags in the column 'what'; name all three"},
      {"a time that goes back",
       {Rows({"0", "1", "2", "0.5", "3"})},
       {},
       "rows that go back be ignored (--skip_backward_times=true)"},
      {"files that all begin at 0",
       {minutes, minutes},
       {},
       "--separate_files=true takes them one after another"},
      {"files with dates and with numbers",
       {minutes, Rows({"2024-03-04 06:00", "2024-03-04 06:01"})},
       {},
       "must agree. --time_format may have one value for each file"},
      {"more forms of time than files",
       {minutes},
       {"--time_format=iso,iso"},
       "must have one value, or one for each of the 1 files"},
      {"a unit of time that is not known",
       {minutes},
       {"--number_unit=fortnight"},
       "times are declared in 'fortnight'"},
      {"a time zone that is not known",
       {minutes},
       {"--time_zone=Mars/Olympus"},
       "there is no time zone 'Mars/Olympus'"},
      {"a date for records without dates",
       {minutes},
       {"--change_times=2024-03-04 06:00"},
       "--change_times has the date '2024-03-04 06:00', but the times"},
      {"a time of a change that is no time",
       {minutes},
       {"--change_times=noon"},
       "--change_times=noon: 'noon' is not a number, nor a date such as"},
      // Shapes.
      {"an Excel workbook",
       {std::string("PK\x03\x04\x14\0\0\0", 8) + "[Content_Types].xml"},
       {},
       "the file is an Excel workbook (xlsx); save its sheet as CSV UTF-8"},
      {"an old Excel workbook",
       {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"},
       {},
       "the file is an Excel workbook of the old kind (xls); save its"},
      {"a Parquet file",
       {"PAR1\x15\x04"},
       {},
       "the file is a Parquet file; write it as CSV first"},
      {"a page of a web server",
       {"<!DOCTYPE html><html>login</html>"},
       {},
       "a page of HTML or XML, not a table as text; export CSV"},
      {"UTF-16",
       {std::string("\xFF\xFEt\0i\0", 6)},
       {},
       "the file is in UTF-16; save it as UTF-8"},
      {"an empty file",
       {"\n"},
       {},
       "the file is empty; a record begins with a header"},
      {"a text that is not a table",
       {"Dear colleague,\nthe record is attached.\n"},
       {},
       "this is not a table of records: no line has names of columns"},
      {"a file in JSON",
       {"{\n \"name\": \"tank\"\n}\n"},
       {},
       "the file is JSON, not a table as text; export the records as CSV"},
      {"a header alone",
       {kHeader},
       {},
       "there is no row below the header; a record needs samples"},
      {"two separators",
       {"time;y1,y2\n0;1;2\n"},
       {},
       "declare --separator=semicolon or --separator=comma"},
      {"numbers that may be thousands",
       {"time;y1;y2;u1;u2\n0;1,234;1;1;1\n1;2,345;1;1;1\n"},
       {},
       "may have a decimal comma or one between thousands; declare --decimal="},
      {"points and commas",
       {"time;y1;y2;u1;u2\n0;1,5;1.5;1;1\n1;2,5;1;1;1\n"},
       {},
       "declare which it is, such as --decimal=comma"},
      {"fields that hold the separator",
       {Rows({"0", "1"}) + "2,1,5,1,1,0\n"},
       {},
       "must be quoted, or another one be declared (--separator)"},
      {"rows of a long table twice",
       {"tag,time,value\ny1,0,1\ny1,1,1\ny1,1,1\n"},
       {},
       "such rows are ignored with --skip_repeated_times=true"},
      {"rows when something changes",
       {"tag,time,value\ny1,0,1\ny1,2.5,1\ny1,9,1\ny2,0,1\ny2,3.1,1\n"
        "u1,0,1\nu1,7.7,1\nu2,0,1\nu2,4.1,1\n"},
       {},
       "declare the sample time of the records, such as --sample_time="},
      // Tags.
      {"a column that is missing",
       {Rows({"0"}, "time,y1,y2.PV,u1,u2\n")},
       {},
       "there is no column 'y2' (nearest: 'y2.PV'); the header must name"},
      {"another name of the time",
       {Rows({"0"}, "Zeit,y1,y2,u1,u2\n")},
       {},
       "there is no column 'time'"},
      {"a tag that the file does not have",
       {minutes},
       {"--tags=TI101=y1"},
       "there is no column 'TI101'"},
      {"columns that are not of the model",
       {"time,y1,y2,u1,u2,remark,user\n0,1,1,1,1,x,y\n"},
       {},
       "nor are 'user'; other columns are ignored with"},
      {"a column twice",
       {Rows({"0"}, "time,y1,y1,u1,u2\n")},
       {},
       "column 3: 'y1' is duplicated"},
      {"a channel that the model does not have",
       {minutes},
       {"--tags=TI101=y7"},
       "'y7' is not an input, output or <output>_setpoint of the model"},
      {"a file of tags that is not there",
       {minutes},
       {"--tag_file=/no/such/tags.csv"},
       "--tag_file: "},
      // Samples.
      {"words that are not known",
       {Rows({"0", "1"}) + "2,Stoerung,1,1,1\n3,Stoerung,1,1,aus\n"},
       {},
       "3 samples are like this, 'Stoerung' (2), 'aus' (1)"},
      {"qualities that are not known",
       {"time,y1,y1_quality,y2,u1,u2\n0,1,X9,1,1,1\n1,1,X9,1,1,1\n"},
       {},
       "declare which of them mean good, such as --good_qualities=X9"},
      {"no good sample",
       {"time,y1,y2,u1,u2\n0,,1,1,1\n1,,1,1,1\n"},
       {},
       "column 'y1' has no good sample in any row (2 empty"},
  };
}

TEST(MleCorrectImport, MistakesAreExplainedWithTheFlagThatHelps) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("model.json", HeaterJson(Heater()));
  for (const Mistake& mistake : Mistakes()) {
    SCOPED_TRACE(mistake.what);
    std::vector<std::string> paths;
    for (const std::string& file : mistake.files) {
      paths.push_back(
          scratch.Write(absl::StrCat("f", paths.size(), ".csv"), file));
    }
    std::vector<std::string> flags = {"--model=" + model,
                                      "--data=" + absl::StrJoin(paths, ","),
                                      "--out=" + scratch / "out", "--dry_run"};
    flags.insert(flags.end(), mistake.flags.begin(), mistake.flags.end());
    const report::ProcessResult result = RunTested(flags);
    EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, HasSubstr("error: "));
    EXPECT_THAT(result.err, HasSubstr(mistake.message));
  }
}

// The example's record with dates and tags of a historian, newest first.
std::string AsExport(const std::string& csv) {
  std::vector<std::string> lines = absl::StrSplit(csv, '\n', absl::SkipEmpty());
  std::string text =
      "Plant 7,,\n" +
      absl::StrReplaceAll(lines[0], {{"y1_setpoint", "TIC101.SP"},
                                     {"y1", "TI101.PV"},
                                     {"u1", "FC7.OP"}}) +
      "\n";
  for (std::size_t k = lines.size() - 1; k > 0; --k) {
    const std::size_t comma = lines[k].find(',');
    double minutes = 0.0;
    EXPECT_TRUE(absl::SimpleAtod(lines[k].substr(0, comma), &minutes));
    absl::StrAppend(
        &text,
        absl::FormatTime("%d-%b-%y %H:%M:%S",
                         absl::FromUnixSeconds(1709532000) +
                             absl::Seconds(std::round(60.0 * minutes)),
                         absl::UTCTimeZone()),
        lines[k].substr(comma), "\n");
  }
  return text;
}

// From the proposal of tags to the result, with dates in all that is said.
TEST(MleCorrectImport, AnExportOfPiIsReadAndDatesAreInTheResult) {
  const HeaterExample example(WithHalvedGain());
  const std::string data =
      example.scratch.Write("pi.csv", AsExport(Content(example.data)));
  const std::string tags = example.scratch / "tags.csv";
  const auto flags = [&](const std::vector<std::string>& more) {
    return CorrectionFlags(example.model, data, example.out, more);
  };
  const report::ProcessResult proposed =
      RunTested(flags({"--propose_tags=" + tags}));
  ASSERT_EQ(proposed.exit_code, 0) << proposed.err;
  EXPECT_THAT(proposed.out, HasSubstr("--tag_file=" + tags));
  // What is still to be written, and nothing that is not needed.
  EXPECT_THAT(proposed.out, HasSubstr("Write into the column channel: 'y1', "));
  EXPECT_THAT(proposed.out, HasSubstr("Set points are probably 'TIC101.SP'; "
                                      "their channels are 'y1_setpoint'"));
  EXPECT_EQ(proposed.out.find("--ignore_other_columns"), std::string::npos);
  EXPECT_THAT(Content(tags), HasSubstr("TI101.PV,"));
  // As a user completes it.
  example.scratch.Write(
      "tags.csv",
      "tag,channel\nti101.pv,y1\nTIC101.SP,y1_setpoint\nFC7.OP,u1\n");
  const report::ProcessResult dry =
      RunTested(flags({"--tag_file=" + tags, "--dry_run"}));
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  for (const char* const part :
       {"from (as recorded)", "2024-03-04 06:00", "the newest rows stand first",
        "1 line above the header passed over. (--lines_above_header)"}) {
    EXPECT_THAT(dry.out, HasSubstr(part));
  }
  const nlohmann::json plain = example.Run();
  const nlohmann::json result = Correct(
      flags({"--tag_file=" + tags, "--truth=" + example.plant}), example.out);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["windows"][0]["from"], plain["windows"][0]["from"]);
  EXPECT_FALSE(plain["windows"][0].contains("from_date"));
  const double from = result["windows"][0]["from"];
  EXPECT_EQ(result["windows"][0]["from_date"],
            absl::FormatTime("%Y-%m-%dT%H:%M:%S+00:00",
                             absl::FromUnixSeconds(1709532000) +
                                 absl::Seconds(std::round(60.0 * from)),
                             absl::UTCTimeZone()));
  EXPECT_TRUE(result["windows"][0]["set_point_changes"][0].contains("date"));
  const std::string page = Content(example.out + "/report.html");
  EXPECT_THAT(page, HasSubstr("Made on 20"));
  EXPECT_THAT(page, HasSubstr("from records of 2024-03-04 06:00 to "));

  // A date of a change is the same as its time.
  const auto change = [&](const std::string& time) {
    return RunTested(flags({"--tag_file=" + tags, "--dry_run",
                            "--change_times=" + time}))
        .out;
  };
  EXPECT_THAT(change("04-Mar-24 07:00"), HasSubstr("at 2024-03-04 07:00"));
  EXPECT_EQ(change("2024-03-04 07:00"), change("60"));
}

// The same record compressed, and from standard input, gives the same result.
TEST(MleCorrectImport, CompressedFilesAreReadAsTheyAre) {
  const HeaterExample example(WithHalvedGain());
  const absl::StatusOr<report::ProcessResult> packed =
      report::RunProcess("gzip", {"-k", example.data}, "");
  ASSERT_TRUE(packed.ok()) << packed.status();
  const auto run = [&](const std::string& data, const std::string& input) {
    const auto result = report::RunProcess(
        MLE_TESTED_COMMAND,
        CorrectionFlags(example.model, data, example.out, {"--dry_run"}),
        input);
    EXPECT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->exit_code, 0) << result->err;
    return result->out.substr(result->out.find("Channels"));
  };
  const std::string plain = run(example.data, "");
  EXPECT_EQ(run(example.data + ".gz", ""), plain);
  EXPECT_EQ(run("-", Content(example.data)), plain);
  EXPECT_EQ(run("-", Content(example.data + ".gz")), plain);
}

}  // namespace
}  // namespace mle
