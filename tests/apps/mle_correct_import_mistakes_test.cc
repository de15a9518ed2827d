// Mistakes in exports and what mle_correct answers: exit code 2 and one line
// that names the file and the flag that helps. docs/records.md has the same
// table.

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

struct Mistake {
  std::string what;  // as in the table of docs/records.md
  std::vector<std::string> files;
  std::vector<std::string> flags;
  std::string message;  // a part of it, as in the table
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

// What is tested is what is said.
TEST(MleCorrectImport, TheTableOfMistakesIsTheOneInTheDocs) {
  const std::string docs = Content(MLE_RECORDS_PAGE);
  std::string table;
  for (const Mistake& mistake : Mistakes()) {
    const std::string row =
        absl::StrCat("| ", mistake.what, " | ", mistake.message, " |\n");
    absl::StrAppend(&table, row);
    EXPECT_TRUE(absl::StrContains(docs, row)) << "not in " << MLE_RECORDS_PAGE;
  }
  EXPECT_TRUE(absl::StrContains(docs, "|---|---|\n" + table))
      << "the table should be\n"
      << table;
}

}  // namespace
}  // namespace mle
