// mle_correct on databases: the numbers of the same rows in a CSV file,
// mistakes in one line with exit code 2, and no password in anything that is
// written.

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"
#include "tests/apps/started_command.h"
#include "tests/mle/database/postgresql_server.h"
#include "tests/mle/database/sqlite_file.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kPassword[] = "geheim-4711";  // PostgresqlServer::kPassword

// "('2024-03-04 06:00:00', 1, 2), …", and the same rows as CSV with dates.
struct Dated {
  std::string csv;
  std::string values;
  std::string columns;
};

// A record with minutes from 0 on as one from 4 March 2024 on.
Dated WithDates(const std::string& path) {
  Dated dated;
  std::vector<std::string> values;
  for (const std::vector<std::string>& row : ParsedCsv(path)) {
    std::vector<std::string> cells(row.begin() + 1, row.end());
    if (dated.columns.empty()) {
      dated.columns = absl::StrJoin(cells, ",");
      dated.csv = absl::StrCat("time,", dated.columns, "\n");
      continue;
    }
    const int seconds = static_cast<int>(60.0 * std::stod(row[0]) + 0.5);
    const auto two = [](int number) {
      return absl::StrCat(number < 10 ? "0" : "", number);
    };
    const std::string time =
        absl::StrCat("2024-03-04 ", two(6 + seconds / 3600), ":",
                     two(seconds / 60 % 60), ":", two(seconds % 60));
    absl::StrAppend(&dated.csv, time, ",", absl::StrJoin(cells, ","), "\n");
    values.push_back(
        absl::StrCat("('", time, "',", absl::StrJoin(cells, ","), ")"));
  }
  dated.values = absl::StrJoin(values, ",\n");
  return dated;
}

// What of a result does not depend on where the records came from.
nlohmann::json Numbers(nlohmann::json result) {
  for (const char* const key : {"command", "flags", "inputs"}) {
    result.erase(key);
  }
  return result;
}

// Every file below a folder, and where the text is in it.
std::vector<std::string> FilesWith(const std::string& folder,
                                   const std::string& text) {
  std::vector<std::string> found;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() &&
        absl::StrContains(Content(entry.path().string()), text)) {
      found.push_back(entry.path().string());
    }
  }
  return found;
}

class DatabaseTest : public ::testing::Test {
 protected:
  DatabaseTest()
      : example_(WithHalvedGain()), dated_(WithDates(example_.data)) {}

  std::vector<std::string> Flags(const std::string& data,
                                 const std::string& folder,
                                 const std::vector<std::string>& more) const {
    return CorrectionFlags(example_.model, data, folder, more);
  }

  const HeaterExample example_;
  const Dated dated_;
};

TEST_F(DatabaseTest, SqliteGivesTheNumbersOfTheFile) {
  const SqliteFile file;
  file.Run(absl::StrCat("CREATE TABLE trend (time, ", dated_.columns,
                        "); INSERT INTO trend VALUES ", dated_.values));
  const ScratchFolder& scratch = example_.scratch;
  const std::string csv = scratch.Write("dated.csv", dated_.csv);
  const nlohmann::json of_file =
      Correct(Flags(csv, scratch / "of_file", {}), scratch / "of_file");
  const nlohmann::json of_table =
      Correct(Flags(file.name(), scratch / "of_table", {"--table=trend"}),
              scratch / "of_table");
  EXPECT_EQ(of_file["decision"], "corrected");
  EXPECT_EQ(Numbers(of_file).dump(), Numbers(of_table).dump());
  ASSERT_EQ(of_table["inputs"]["data"].size(), 1u);
  const nlohmann::json& data = of_table["inputs"]["data"][0];
  EXPECT_EQ(data["path"], file.name() + ", table trend");
  EXPECT_EQ(std::string(data["sha256"]).size(), 64u);
  EXPECT_GT(data["bytes"], 10000);
  EXPECT_THAT(Content(scratch / "of_table/report.html"),
              HasSubstr("table trend"));

  // The same rows are the same bytes, by whatever query.
  const nlohmann::json of_query = Correct(
      Flags(file.name(), scratch / "of_query",
            {"--query=SELECT * FROM trend WHERE time > '2024' ORDER BY 1"}),
      scratch / "of_query");
  EXPECT_EQ(of_query["inputs"]["data"][0]["sha256"], data["sha256"]);
}

TEST_F(DatabaseTest, MistakesEndWithOneLine) {
  const SqliteFile file;
  file.Run(absl::StrCat("CREATE TABLE trend (time, ", dated_.columns,
                        "); INSERT INTO trend VALUES ", dated_.values));
  const std::string out = example_.scratch / "none";
  const auto refused = [&](const std::string& data,
                           const std::vector<std::string>& more) {
    const report::ProcessResult run = RunTested(Flags(data, out, more));
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(out));
    return run.err;
  };
  EXPECT_THAT(refused(file.name(), {}),
              HasSubstr("--data: of a database either --table or --query must "
                        "be given"));
  EXPECT_THAT(refused(file.name(), {"--table=trends"}),
              AllOf(HasSubstr("--table=trends is not in the database"),
                    HasSubstr("nearest: 'trend'")));
  EXPECT_THAT(refused(file.name(), {"--table=trend", "--columns=y1,q9"}),
              HasSubstr("no column 'q9'"));
  EXPECT_THAT(refused(file.name(), {"--query=SELECT * FROM trend WHERE 0"}),
              HasSubstr("the query returns no rows"));
  EXPECT_THAT(refused(file.name(), {"--table=trend", "--begin=2025-01-01"}),
              HasSubstr("the table has no rows between --begin and --end"));
  EXPECT_THAT(refused(file.path(), {}), HasSubstr("name it sqlite:FILE"));
  EXPECT_THAT(refused("mysql://h/plant", {"--table=trend"}),
              HasSubstr("postgresql://USER@HOST/NAME"));
  EXPECT_THAT(refused(example_.data, {"--table=trend"}),
              HasSubstr("--table and --columns are for databases"));
  for (const std::string& name :
       {absl::StrCat("postgresql://reader:", kPassword, "@host/plant"),
        absl::StrCat("postgresql://host/plant?password=", kPassword),
        absl::StrCat("odbc:DSN=plant;PWD=", kPassword)}) {
    EXPECT_THAT(
        refused(name, {"--table=trend"}),
        AllOf(HasSubstr("has a password in it"), Not(HasSubstr(kPassword))));
  }
  EXPECT_EQ(file.Value("SELECT count(*) FROM trend"), "1001");
}

TEST_F(DatabaseTest, TagsAreProposedAndRangesCut) {
  const SqliteFile file;
  file.Run(absl::StrCat("CREATE TABLE trend (time, ", dated_.columns,
                        "); INSERT INTO trend VALUES ", dated_.values));
  const std::string tags = example_.scratch / "tags.csv";
  const report::ProcessResult proposed =
      RunTested(Flags(file.name(), example_.scratch / "none",
                      {"--table=trend", "--propose_tags=" + tags}));
  EXPECT_EQ(proposed.exit_code, 0) << proposed.err;
  EXPECT_THAT(Content(tags), HasSubstr("y1_setpoint,y1_setpoint,1,0,"));
  const report::ProcessResult cut =
      RunTested(Flags(file.name(), example_.scratch / "none",
                      {"--table=trend", "--dry_run", "--begin=2024-03-04 06:30",
                       "--end=2024-03-04 09:00"}));
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_THAT(cut.out, AllOf(HasSubstr("2024-03-04 06:30"),
                             HasSubstr("2024-03-04 09:00"), HasSubstr("601")));
}

class ServerTest : public DatabaseTest {
 protected:
  void SetUp() override {
    if (!PostgresqlServer::IsInstalled()) {
      GTEST_SKIP() << "Debian's package postgresql is not installed";
    }
    server_.emplace();
    ASSERT_TRUE(server_->is_running());
    std::string types = dated_.columns + ",";
    for (std::size_t at = 0; (at = types.find(',', at)) != std::string::npos;) {
      constexpr char kType[] = " double precision";
      types.insert(at, kType);
      at += sizeof(kType);
    }
    types.pop_back();
    server_->Run(absl::StrCat(
        "SET timezone = 'UTC'; CREATE TABLE trend (time timestamptz, ", types,
        "); INSERT INTO trend VALUES ", dated_.values, ";"));
  }

  std::optional<PostgresqlServer> server_;
};

TEST_F(ServerTest, NumbersOfTheFileAndNoPasswordAnywhere) {
  const ScratchFolder& scratch = example_.scratch;
  const std::string csv = scratch.Write("dated.csv", dated_.csv);
  const nlohmann::json of_file =
      Correct(Flags(csv, scratch / "of_file", {}), scratch / "of_file");
  const std::string out = scratch / "of_server";
  std::vector<std::string> flags =
      Flags(server_->name("reader"), out,
            {"--table=trend", "--verbose", "--figures=true"});
  const report::ProcessResult run =
      RunTested(flags, {absl::StrCat("PGPASSWORD=", kPassword)});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Numbers(of_file).dump(),
            Numbers(ParsedJson(out + "/result.json")).dump());
  EXPECT_THAT(run.out + run.err, Not(HasSubstr(kPassword)));
  EXPECT_THAT(FilesWith(out, kPassword), ::testing::IsEmpty());
  // The records are drawn over dates.
  EXPECT_THAT(Content(out + "/records.svg"),
              AllOf(HasSubstr("data-dates=\"1709532000 60 UTC\""),
                    HasSubstr(">07:00<"), HasSubstr(">10:00<")));
  // What is searched for would be found.
  EXPECT_THAT(FilesWith(out, "of_server"), Not(::testing::IsEmpty()));

  const report::ProcessResult wrong =
      RunTested(flags, {"PGPASSWORD=falsch-0815"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("password authentication failed"),
                               Not(HasSubstr("falsch-0815"))));
  const report::ProcessResult none =
      RunTested(flags, {"PGPASSFILE=/nonexistent"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("PGPASSWORD"));
}

// On a terminal, which does not show what is typed.
TEST_F(ServerTest, PasswordIsAskedForOnATerminal) {
  std::vector<std::string> line =
      Flags(server_->name("reader"), example_.scratch / "none",
            {"--table=trend", "--dry_run"});
  line.insert(line.begin(), MLE_TESTED_COMMAND);
  std::vector<char*> words;
  for (std::string& word : line) words.push_back(word.data());
  words.push_back(nullptr);
  int terminal = -1;
  const pid_t command = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(command, 0);
  if (command == 0) {
    ::unsetenv("PGPASSWORD");
    ::setenv("PGPASSFILE", "/nonexistent", 1);
    ::execv(words[0], words.data());
    ::_exit(127);
  }
  std::string shown;
  bool is_typed = false;
  char c = 0;
  while (read(terminal, &c, 1) == 1) {
    shown += c;
    if (is_typed || !absl::StrContains(shown, "Password of ") || c != ' ' ||
        !absl::StrContains(shown, server_->folder() + ": ")) {
      continue;
    }
    const std::string typed = absl::StrCat(kPassword, "\n");
    EXPECT_EQ(write(terminal, typed.data(), typed.size()),
              static_cast<ssize_t>(typed.size()));
    is_typed = true;
  }
  int status = -1;
  EXPECT_EQ(waitpid(command, &status, 0), command);
  close(terminal);
  EXPECT_EQ(status, 0) << shown;
  EXPECT_TRUE(is_typed);
  EXPECT_THAT(shown, AllOf(HasSubstr("table trend"), Not(HasSubstr("geheim"))));
}

// Killed while the command waits for more rows.
TEST_F(ServerTest, ServerKilledInMidReadLeavesNothing) {
  const std::string out = example_.scratch / "killed";
  const std::string log = example_.scratch / "killed.log";
  StartedCommand command(
      MLE_TESTED_COMMAND,
      Flags(server_->name(), out,
            {"--query=SELECT *, CASE WHEN time > '2024-03-04 08:00Z' THEN "
             "pg_sleep(600)::text END AS note FROM trend",
             "--ignore_other_columns"}),
      log);
  command.Await([&] {
    return server_->Value(
               "SELECT count(*) FROM pg_stat_activity WHERE wait_event = "
               "'PgSleep'") == "1";
  });
  EXPECT_FALSE(command.HasEnded());
  server_->Kill();
  EXPECT_EQ(command.ExitCode(), 2);
  EXPECT_THAT(Content(log), AllOf(HasSubstr("error: --data: postgresql://"),
                                  HasSubstr("server closed the connection")));
  EXPECT_FALSE(std::filesystem::exists(out + "/result.json"));
}

}  // namespace
}  // namespace mle
