// mle_lifecycle as its users call it.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/page_tables.h"
#include "tests/apps/readable_page.h"
#include "tests/apps/report/browser.h"
#include "tests/apps/report/shown_figures.h"
#include "tests/apps/started_command.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kTank[] = R"({"name": "tank", "time_unit": "min",
  "inputs": [{"name": "steam", "unit": ""}],
  "outputs": [{"name": "level", "unit": ""}],
  "elements": [{"output": "level", "input": "steam",
                "gain": 2, "time_constant": 8, "delay": 3}]})";
// In days: the gain halves within 60.
constexpr char kFouling[] = R"({"time_factor": 1440, "elements": [
  {"output": "level", "input": "steam", "gain": [[0, 1.0], [60, 0.5]]}]})";

// Sixty days of a tank, a change every fifth.
class MleLifecycleTest : public ::testing::Test {
 protected:
  MleLifecycleTest()
      : model_(scratch_.Write("tank.json", kTank)),
        ageing_(scratch_.Write("fouling.json", kFouling)) {}

  std::vector<std::string> Arguments(
      const std::string& out, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "--model=" + model_,
        "--ageing=" + ageing_,
        "--years=0.165",
        "--change_every=5d",
        "--sample_time=1",
        "--move_weight=2",
        "--policies=never,output_error:2,test:1,perfect",
        "--seeds=2",
        "--out=" + (scratch_ / out),
        "--nofigures"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  report::ProcessResult Run(const std::string& out,
                            const std::vector<std::string>& more = {}) {
    return RunTested(Arguments(out, more));
  }

  // Lives that are finished and kept.
  int LivesIn(const std::string& out) const {
    std::ifstream journal(scratch_ / (out + "/journal.txt"));
    const std::string text(std::istreambuf_iterator<char>(journal), {});
    const auto lines = std::count(text.begin(), text.end(), '\n');
    return std::max(static_cast<int>(lines) - 1, 0);
  }

  // The cost a year of a policy in a result.
  static double CostOf(const nlohmann::json& result, std::size_t policy) {
    return result.at("rates")
        .at(0)
        .at("policies")
        .at(policy)
        .at("cost_per_year")
        .at("mean");
  }

  ScratchFolder scratch_;
  std::string model_;
  std::string ageing_;
};

TEST_F(MleLifecycleTest, WritesWhatItFound) {
  const report::ProcessResult run = Run("out", {"--ageing_rates=0,1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("output_error:2"));
  const nlohmann::json result = ParsedJson(scratch_ / "out/result.json");
  EXPECT_EQ(result.at("version"), 1);
  const nlohmann::json& rates = result.at("rates");
  ASSERT_EQ(rates.size(), 2u);
  // Nothing ages at the rate 0: never is as good as perfect there, and with
  // ageing it is not.
  const auto policy = [&](int rate, int p) {
    return rates.at(rate).at("policies").at(p);
  };
  EXPECT_EQ(policy(0, 0).at("distance"), 0.0);
  EXPECT_EQ(policy(0, 0).at("cost_per_year"), policy(0, 3).at("cost_per_year"));
  EXPECT_GT(policy(1, 0).at("distance"), 0.0);
  EXPECT_LT(policy(1, 1).at("distance"),
            0.5 * policy(1, 0).at("distance").get<double>());
  EXPECT_GT(policy(1, 2).at("step_tests"), 0.0);

  const auto rows = ParsedCsv(scratch_ / "out/lifecycle.csv");
  ASSERT_GT(rows.size(), 50u);
  EXPECT_EQ(rows[0][0], "ageing_rate");
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  // The report stands without figures as well.
  EXPECT_THAT(Content(scratch_ / "out/report.html"),
              HasSubstr("What each policy costs"));
}

// Differences over the same lives, in the file as on the page.
TEST_F(MleLifecycleTest, PoliciesAreComparedWithTheCheapest) {
  const report::ProcessResult run =
      Run("out", {"--seeds=3", "--price_test_hour=0", "--currency=EUR"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = ParsedJson(scratch_ / "out/result.json");
  EXPECT_EQ(result.at("currency"), "EUR");
  const nlohmann::json& rate = result.at("rates").at(0);
  double least = 0.0;
  for (const nlohmann::json& policy : rate.at("policies")) {
    if (policy.at("policy") == rate.at("cheapest")) {
      least = policy.at("cost_per_year").at("mean");
    }
  }
  for (const nlohmann::json& policy : rate.at("policies")) {
    SCOPED_TRACE(policy.at("policy").get<std::string>());
    const nlohmann::json& over = policy.at("over_cheapest_per_year");
    const double cost = policy.at("cost_per_year").at("mean");
    EXPECT_NEAR(over.at("mean"), cost - least, 1e-9 * (1.0 + cost));
    EXPECT_EQ(policy.at("told_apart_from_cheapest"),
              std::abs(over.at("mean").get<double>()) >
                  over.at("half_width_95").get<double>());
  }
  const std::string html = Content(scratch_ / "out/report.html");
  const PageTable table = TableOf(html, "What a year costs under each policy");
  ASSERT_EQ(table.rows.size(), 1u + 4u);
  EXPECT_EQ(table.rows[1][3], "cheapest");
  EXPECT_EQ(table.rows[4][3], "the reference");
  EXPECT_EQ(table.rows[4][0], "perfect model (the reference)");
  ExpectShows(table.rows[1][1], least);
  const nlohmann::json& perfect = rate.at("policies").at(3);
  ExpectShows(table.rows[4][2],
              perfect.at("over_cheapest_per_year").at("mean"));
  EXPECT_THAT(html, HasSubstr("--policies</span>=output_error:2"));
  EXPECT_THAT(html, HasSubstr(" EUR a year against never"));
  // What to do comes first, on the page and on the terminal.
  const std::size_t verdict = html.find("class=\"verdict changed\"");
  ASSERT_NE(verdict, std::string::npos);
  const std::string opening =
      html.substr(verdict, html.find("</header>") - verdict);
  EXPECT_THAT(opening, HasSubstr("<span class=\"badge\">update</span> Correct "
                                 "the model after every 2nd set-point change"));
  EXPECT_THAT(opening, HasSubstr("±\u00A0is half a 95\u00A0% interval"));
  EXPECT_THAT(run.out,
              HasSubstr("Correct the model after every 2nd set-point change."));
}

// As vector graphics, as a document's pictures, and in the page.
TEST_F(MleLifecycleTest, DrawsCostsAndTheirCourse) {
  const report::ProcessResult run =
      Run("out", {"--ageing_rates=0.5,1", "--seeds=3", "--figures=true",
                  "--currency=EUR",
                  "--policies=never,output_error:1,output_error:2,test:1,"
                  "test:2,on_demand:0.7,perfect"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err.find("warning"), std::string::npos) << run.err;
  for (const char* const name : {"policy_costs", "over_time"}) {
    SCOPED_TRACE(name);
    const std::string stem = scratch_ / "out/" + name;
    EXPECT_THAT(Content(stem + ".svg"), HasSubstr("</svg>"));
    EXPECT_THAT(Content(stem + ".pdf"), StartsWith("%PDF"));
  }
  EXPECT_EQ(
      report::FiguresOf(Content(scratch_ / "out/report.html"), true).size(),
      2u);
  EXPECT_THAT(Content(scratch_ / "out/report.html"),
              HasSubstr("Saving a year against never updating"));
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  // Costs, and two over the years.
  ExpectReadable(scratch_ / "out/report.html", "lifecycle", 3,
                 {.badge = "update"});
  ExpectFitsPaper(scratch_ / "out/report.html", "lifecycle_paper");
}

TEST_F(MleLifecycleTest, SetPointsChangeAtControlInstants) {
  const report::ProcessResult run =
      Run("out", {"--control_period=7", "--policies=never", "--seeds=1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = ParsedCsv(scratch_ / "out/lifecycle.csv");
  ASSERT_GT(rows.size(), 5u);
  ASSERT_EQ(rows[0][3], "day");
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k][4].empty()) continue;  // The end of the life.
    const double periods = std::stod(rows[k][3]) * 24.0 * 60.0 / 7.0;
    EXPECT_NEAR(periods, std::round(periods), 1e-4) << k;
  }
}

TEST_F(MleLifecycleTest, ThreadsAndInterruptionsChangeNoByte) {
  ASSERT_EQ(Run("one", {"--threads=1"}).exit_code, 0);
  // A run that has lost some of its lives makes them again, and only them.
  std::filesystem::copy(scratch_ / "one", scratch_ / "rest",
                        std::filesystem::copy_options::recursive);
  std::filesystem::remove(scratch_ / "rest/lifecycle.csv");
  std::string journal = Content(scratch_ / "rest/journal.txt");
  for (const char* const lost : {"\noutput_error:2,1,1,", "\nnever,1,2,"}) {
    const std::size_t begin = journal.find(lost);
    ASSERT_NE(begin, std::string::npos) << lost;
    journal.erase(begin, journal.find('\n', begin + 1) - begin);
  }
  scratch_.Write("rest/journal.txt", journal);
  const report::ProcessResult rest = Run("rest");
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.err, HasSubstr("6 of 8 lives are done"));
  const std::string lines = Content(scratch_ / "one/lifecycle.csv");
  EXPECT_EQ(Content(scratch_ / "rest/lifecycle.csv"), lines);
  EXPECT_EQ(ParsedJson(scratch_ / "rest/result.json").at("rates"),
            ParsedJson(scratch_ / "one/result.json").at("rates"));
  EXPECT_EQ(LivesIn("rest"), 8);
  // Parts make the same lives, and the run of all only brings them together.
  for (const char* const part : {"--part=1/2", "--part=2/2"}) {
    const report::ProcessResult run = Run("parts", {part, "--threads=2"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("without --part"));
  }
  EXPECT_EQ(LivesIn("parts/parts/1-of-2"), 4);
  const report::ProcessResult all = Run("parts");
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.err, HasSubstr("8 of 8 lives are done"));
  EXPECT_EQ(Content(scratch_ / "parts/lifecycle.csv"), lines);
}

TEST_F(MleLifecycleTest, ARunThatIsStoppedGoesOnWhereItWas) {
  ASSERT_EQ(Run("whole").exit_code, 0);
  int stopped = 0;
  // Asked to stop, or killed, after a life more each time; it may be done.
  for (const int signal : {SIGINT, SIGKILL, SIGTERM}) {
    const std::string log = scratch_ / absl::StrCat("log", signal);
    StartedCommand command(MLE_TESTED_COMMAND,
                           Arguments("stopped", {"--threads=1"}), log);
    const int before = LivesIn("stopped");
    command.Await([&] { return LivesIn("stopped") > before; });
    command.Send(signal);
    const int exit_code = command.ExitCode();
    if (exit_code == 0) continue;
    ++stopped;
    if (signal == SIGKILL) {
      EXPECT_EQ(exit_code, 128 + SIGKILL) << Content(log);
    } else {
      EXPECT_EQ(exit_code, 1) << Content(log);
      EXPECT_THAT(Content(log), HasSubstr("Stopped: "));
    }
  }
  EXPECT_GT(stopped, 0);
  ASSERT_EQ(Run("stopped").exit_code, 0);
  EXPECT_EQ(Content(scratch_ / "stopped/lifecycle.csv"),
            Content(scratch_ / "whole/lifecycle.csv"));
}

TEST_F(MleLifecycleTest, OtherPricesAndCurrenciesNeedNoNewSimulation) {
  const std::vector<std::string> prices = {
      "--price_movement=0", "--price_violation=0", "--price_engineer_hour=0",
      "--price_test_hour=0"};
  std::vector<std::string> dear = prices;
  dear.emplace_back("--price_squared_error=700");
  std::vector<std::string> cheap = prices;
  cheap.emplace_back("--price_squared_error=100");
  cheap.emplace_back("--currency=€");
  ASSERT_EQ(Run("out", dear).exit_code, 0);
  const nlohmann::json at_700 = ParsedJson(scratch_ / "out/result.json");
  const report::ProcessResult again = Run("out", cheap);
  ASSERT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, HasSubstr("8 of 8 lives are done"));
  EXPECT_THAT(again.out, HasSubstr("ageing rate 1, €"));
  const nlohmann::json at_100 = ParsedJson(scratch_ / "out/result.json");
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_NEAR(CostOf(at_700, p), 7.0 * CostOf(at_100, p),
                1e-9 * CostOf(at_700, p));
  }
}

TEST_F(MleLifecycleTest, OtherSettingsAreSimulatedAnew) {
  ASSERT_EQ(Run("out", {"--policies=never"}).exit_code, 0);
  const std::string before = Content(scratch_ / "out/lifecycle.csv");
  const report::ProcessResult other =
      Run("out", {"--policies=never", "--noise_variance=0.002"});
  ASSERT_EQ(other.exit_code, 0);
  EXPECT_THAT(other.err, Not(HasSubstr("lives are done")));
  EXPECT_NE(Content(scratch_ / "out/lifecycle.csv"), before);
}

// A plant that never was what the model says: to be right pays from the
// beginning, and windows that are too old are not used.
TEST_F(MleLifecycleTest, ThePlantMayDifferFromTheModelFromTheBeginning) {
  std::string other = kTank;
  other.replace(other.find("\"gain\": 2"), 9, "\"gain\": 3");
  const std::string plant = scratch_.Write("plant.json", other);
  const report::ProcessResult run = Run(
      "out", {"--plant=" + plant, "--ageing_rates=0", "--window_age=12d",
              "--test_move=0.7", "--policies=never,output_error:1,perfect"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = ParsedJson(scratch_ / "out/result.json");
  const nlohmann::json& policies = result.at("rates").at(0).at("policies");
  EXPECT_GT(policies.at(0).at("distance"), 0.0);
  EXPECT_LT(policies.at(1).at("distance"),
            0.8 * policies.at(0).at("distance").get<double>());
  EXPECT_EQ(policies.at(2).at("distance"), 0.0);
}

TEST_F(MleLifecycleTest, MistakesEndWithOneLine) {
  const std::string file = scratch_.Write("file", "");
  for (const std::string& mistake :
       {std::string("--policies=sometimes"), "--out=" + file}) {
    const report::ProcessResult result = Run("wrong", {mistake});
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, HasSubstr(mistake.substr(0, mistake.find('='))));
  }
}

TEST_F(MleLifecycleTest, ALifeWithAChangedDigitIsSimulatedAgain) {
  ASSERT_EQ(Run("out", {"--policies=never"}).exit_code, 0);
  const std::string before = Content(scratch_ / "out/lifecycle.csv");
  const std::string name = "out/journal.txt";
  const std::string whole = Content(scratch_ / name);
  std::string changed = whole;
  const std::size_t at = changed.find("\"squared_error\"");
  const std::size_t digit = changed.find_first_of("123456789", at);
  changed[digit] = changed[digit] == '1' ? '2' : '1';
  const std::size_t broken_off = whole.size() - 100;
  for (const std::string& damaged : {changed, whole.substr(0, broken_off)}) {
    scratch_.Write(name, damaged);
    const report::ProcessResult run = Run("out", {"--policies=never"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err,
                HasSubstr(damaged == changed ? "journal.txt:2: the line is"
                                             : "incomplete last line"));
    EXPECT_THAT(run.err, HasSubstr("1 of 2 lives are done"));
    EXPECT_EQ(Content(scratch_ / "out/lifecycle.csv"), before);
  }
}

}  // namespace
}  // namespace mle
