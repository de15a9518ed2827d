// What mle_reproduce writes: results.json (whose form tests/docs checks),
// curves that agree with it, the same bytes whatever the threads, and all of it
// without rsvg-convert too.

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/page_tables.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

namespace fs = std::filesystem;

std::set<std::string> NamesIn(const std::string& folder) {
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

TEST(MleReproduceOutputs, HelpShowsTheFlagsMostNeeded) {
  const std::string help = RunTested({"--help"}).out;
  EXPECT_THAT(help, HasSubstr("  --seeds "));
  EXPECT_THAT(help, Not(HasSubstr("--lambda_grid_max")));
  for (const char* const flag : {"-h", "-help", "--helpshort"}) {
    EXPECT_EQ(RunTested({flag}).out, help) << flag;
  }
}

// All of them are in docs/commands.md, which is made of this.
TEST(MleReproduceOutputs, HelpListsEveryFlagWithItsDefault) {
  const std::string help = RunTested({"--help=all"}).out;
  for (const char* const part :
       {"--cases [gain,delay]", "--conversion_noise_variance []",
        "--lambda_grid_step [1e-06]", "] min, > 0", "Exit codes"}) {
    EXPECT_THAT(help, HasSubstr(part));
  }
  // Not those of the libraries.
  EXPECT_THAT(help, Not(HasSubstr("--logtostderr")));
  for (const char* const flag : {"-h=all", "--helpfull"}) {
    EXPECT_EQ(RunTested({flag}).out, help) << flag;
  }
}

TEST(MleReproduceOutputs, ResultsFollowTheContract) {
  const ScratchFolder scratch;
  const std::string out = scratch / "a/new/folder";
  const report::ProcessResult result = RunTested(
      SmallRun(out, {"--seeds=2", "--first_seed=7", "--selection=paper"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(NamesIn(out), UnorderedElementsAre(
                                "results.json", "report.html", "curve_gain.csv",
                                "curve_delay.csv", "step_response_gain.csv",
                                "step_response_delay.csv"));
  const nlohmann::json results = ParsedJson(out + "/results.json");
  EXPECT_EQ(results["version"], 1);
  ASSERT_EQ(results["cases"].size(), 2u);
  EXPECT_EQ(results["cases"][0]["name"], "gain");
  EXPECT_EQ(results["cases"][1]["name"], "delay");
  for (const nlohmann::json& one : results["cases"]) {
    EXPECT_TRUE(one["summary"].is_object());
    ASSERT_EQ(one["runs"].size(), 2u);
    EXPECT_EQ(one["runs"][0]["seed"], 7);
    EXPECT_EQ(one["runs"][1]["seed"], 8);
    for (const nlohmann::json& run : one["runs"]) {
      EXPECT_LE(run["E_oracle"], run["E_star"]);
      EXPECT_LE(run["E_oracle"], run["E_zero"]);
      EXPECT_LE(run["max_relative_duality_gap"], 1e-9);
    }
  }
}

TEST(MleReproduceOutputs, CurvesAgreeWithTheResults) {
  const ScratchFolder scratch;
  const std::string out = scratch / "out";
  const report::ProcessResult result =
      RunTested(SmallRun(out, {"--cases=gain", "--selection=paper"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json results = ParsedJson(out + "/results.json");
  const nlohmann::json run = results["cases"][0]["runs"][0];

  const auto curve = ParsedCsv(out + "/curve_gain.csv");
  // 0, 1e-4, …, 1e-2, below the header.
  ASSERT_EQ(curve.size(), 102u);
  EXPECT_EQ(curve[0][0], "lambda");
  EXPECT_EQ(curve[0][1], "E");
  std::map<double, double> E;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    ASSERT_EQ(curve[i].size(), curve[0].size());
    const double lambda = std::stod(curve[i][0]);
    EXPECT_NEAR(lambda, 1e-4 * static_cast<double>(i - 1), 1e-12);
    E[lambda] = std::stod(curve[i][1]);
  }
  // The curves are printed to twelve digits.
  const auto at = [&](double lambda) {
    auto found = E.lower_bound(lambda - 5e-5);
    return found == E.end() ? 0.0 : found->second;
  };
  const double E_zero = run["E_zero"];
  const double E_star = run["E_star"];
  EXPECT_NEAR(at(0.0), E_zero, 1e-11 * E_zero);
  EXPECT_NEAR(at(run["lambda_star"]), E_star, 1e-11 * E_star);
  const double E_oracle = run["E_oracle"];
  EXPECT_NEAR(at(run["lambda_oracle"]), E_oracle, 1e-11 * E_oracle);
  for (const auto& [lambda, distance] : E) {
    EXPECT_GE(distance, E_oracle * (1.0 - 1e-11)) << "at " << lambda;
  }

  // Time, and four models of four pairs; E from the responses is E.
  const auto responses = ParsedCsv(out + "/step_response_gain.csv");
  ASSERT_EQ(responses.size(), 122u);
  double before = 0.0, after = 0.0;
  for (std::size_t k = 1; k < responses.size(); ++k) {
    ASSERT_EQ(responses[k].size(), 17u);
    EXPECT_NEAR(std::stod(responses[k][0]), 0.5 * static_cast<double>(k - 1),
                1e-9);
    for (std::size_t pair = 0; pair < 4; ++pair) {
      const double truth = std::stod(responses[k][5 + pair]);
      before += std::pow(std::stod(responses[k][1 + pair]) - truth, 2);
      after += std::pow(std::stod(responses[k][9 + pair]) - truth, 2);
    }
  }
  EXPECT_EQ(responses[0][1], "overhead/reflux initial");
  EXPECT_EQ(responses[0][5], "overhead/reflux true");
  EXPECT_EQ(responses[0][9], "overhead/reflux corrected");
  const double E_initial = results["cases"][0]["E_initial"];
  EXPECT_NEAR(before, E_initial, 1e-9 * E_initial);
  // Differences of responses of about 20, to twelve digits each.
  EXPECT_NEAR(after, E_star, 1e-7 * E_star);
}

// The estimators asked for, on the same records.
TEST(MleReproduceOutputs, CompareEstimators) {
  const ScratchFolder scratch;
  const report::ProcessResult result =
      RunTested(SmallRun(scratch / "out", {"--seeds=2", "--cases=gain"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("estimators side by side"));
  const nlohmann::json one =
      ParsedJson(scratch / "out/results.json")["cases"][0];
  ASSERT_EQ(one["runs"].size(), 2u);
  for (const nlohmann::json& run : one["runs"]) {
    const nlohmann::json& estimators = run["estimators"];
    EXPECT_EQ(estimators.contains("ceres"), run == one["runs"][0]);
    for (const auto& [name, values] : estimators.items()) {
      EXPECT_TRUE(values["change_proposed"]) << name;
      EXPECT_LT(values["E"], one["E_initial"]) << name;
      EXPECT_LT(values["p_value"], 0.01) << name;
    }
    EXPECT_EQ(estimators["arx"]["E"], run["E_star"]);
    EXPECT_LT(estimators["output_error"]["E"], estimators["arx"]["E"]);
    EXPECT_TRUE(run["E_limit"].is_number());
  }
  const nlohmann::json& first = one["runs"][0];
  EXPECT_NEAR(first["estimators"]["ceres"]["E"], first["E_star"],
              1e-3 * first["E_star"].get<double>());
  // None asked for, none there.
  const report::ProcessResult none =
      RunTested(SmallRun(scratch / "none", {"--cases=gain", "--estimators="}));
  ASSERT_EQ(none.exit_code, 0) << none.err;
  const nlohmann::json without =
      ParsedJson(scratch / "none/results.json")["cases"][0]["runs"][0];
  EXPECT_FALSE(without.contains("estimators"));
  EXPECT_EQ(without["E_star"], first["E_star"]);
}

TEST(MleReproduceOutputs, ThePageShowsTheValuesOfTheResults) {
  const ScratchFolder scratch;
  const report::ProcessResult run = RunTested(
      SmallRun(scratch / "out", {"--cases=gain", "--seeds=2", "--ablations=all",
                                 "--estimators=arx,output_error"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result =
      ParsedJson(scratch / "out/results.json")["cases"][0];
  const std::string html = Content(scratch / "out/report.html");
  const auto distances = TableOf(html, "Case gain: squared distance E").rows;
  ExpectShows(distances[1][2], result["E_initial"]);
  const std::pair<std::size_t, const char*> rows[] = {
      {2, "E_star"}, {3, "E_oracle"}, {5, "E_zero"}};
  for (const auto& [row, name] : rows) {
    const nlohmann::json& summary = result["summary"][name];
    ExpectShows(distances[row][2], summary["mean"]);
    ExpectShows(distances[row][3], summary["best"]);
    ExpectShows(distances[row][4], summary["worst"]);
    ExpectShows(distances[row][5], summary["standard_deviation"]);
  }
  const auto gains = TableOf(html, "Case gain: corrected gains").rows;
  const auto delays = TableOf(html, "Case gain: corrected dead times").rows;
  for (std::size_t pair = 0; pair < 4; ++pair) {
    const auto of = [&](const char* name) -> double {
      return result["summary"][name][pair / 2][pair % 2];
    };
    ExpectShows(gains[1 + pair][2], of("static_gain_error_rms"));
    ExpectShows(gains[1 + pair][3], of("fopdt_gain_error_rms"));
    ExpectShows(delays[1 + pair][4], of("fopdt_delay_error_rms"));
  }
  const auto mean = [&](const auto& value_of) {
    double sum = 0.0;
    for (int s = 0; s < 2; ++s) sum += 0.5 * value_of(s).template get<double>();
    return sum;
  };
  const auto estimators = TableOf(html, "Case gain: estimators").rows;
  for (std::size_t row = 1; row <= 2; ++row) {
    ExpectShows(
        estimators[row][2], mean([&](int s) {
          return result["runs"][s]["estimators"][estimators[row][0]]["E"];
        }));
  }
  ExpectShows(estimators[3][2],
              mean([&](int s) { return result["runs"][s]["E_limit"]; }));
  const auto ablations = TableOf(html, "Case gain: one decision").rows;
  ASSERT_EQ(ablations.size(), 2u + result["ablations"].size());
  ExpectShows(ablations[1][1], result["summary"]["E_star"]["mean"]);
  std::size_t row = 2;
  for (const char* name :
       {"noise_free_conversion", "raw_scaling", "matlab_stop",
        "lambda_per_output", "one_standard_error", "half_windows"}) {
    const nlohmann::json& runs = result["ablations"][name];
    ASSERT_EQ(runs.size(), 2u) << name;
    ExpectShows(ablations[row++][1], mean([&](int s) { return runs[s]["E"]; }));
  }
}

TEST(MleReproduceOutputs, DoNotDependOnThreadsOrTheRun) {
  const ScratchFolder scratch;
  for (const char* threads : {"1", "2", "0"}) {
    const report::ProcessResult result = RunTested(SmallRun(
        scratch / threads, {"--seeds=3", std::string("--threads=") + threads}));
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  const std::set<std::string> names = NamesIn(scratch / "1");
  EXPECT_EQ(names, NamesIn(scratch / "2"));
  for (const std::string& name : names) {
    if (name == "report.html") continue;  // it holds the command line
    const std::string one = Content(scratch / ("1/" + name));
    EXPECT_EQ(one, Content(scratch / ("2/" + name))) << name;
    EXPECT_EQ(one, Content(scratch / ("0/" + name))) << name;
  }
  // The same command makes the same page.
  const std::string page = Content(scratch / "1/report.html");
  const report::ProcessResult again =
      RunTested(SmallRun(scratch / "1", {"--seeds=3", "--threads=1"}));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(Content(scratch / "1/report.html"), page);
  // Nor on the company of other cases.
  const report::ProcessResult alone =
      RunTested(SmallRun(scratch / "alone", {"--seeds=3", "--cases=delay"}));
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_EQ(Content(scratch / "1/curve_delay.csv"),
            Content(scratch / "alone/curve_delay.csv"));
}

TEST(MleReproduceOutputs, FlagFilesStandForTheirFlags) {
  const ScratchFolder scratch;
  const std::string folder = scratch / "out";
  std::string lines = "# a small run\n";
  for (const std::string& argument : SmallRun(folder)) lines += argument + "\n";
  const std::string file = scratch.Write("small.flags", lines);
  const report::ProcessResult result = RunTested(
      {"--cases=gain", "--flagfile", file, "--nofigures", "--first_seed", "5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ParsedJson(folder + "/results.json")["cases"][0]["runs"][0]["seed"],
            5);
}

TEST(MleReproduceOutputs, WithoutRsvgConvertOnlyPngAndPdfAreMissing) {
  const ScratchFolder scratch;
  const std::vector<std::string> arguments =
      SmallRun(scratch / "out", {"--cases=gain", "--figures=true"});
  // A picture of a former run goes with it.
  fs::create_directory(scratch / "out");
  scratch.Write("out/overview.pdf", "of a former run");
  const report::ProcessResult result =
      RunTested(arguments, {"PATH=" + scratch / "no_programs"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("warning: rsvg-convert is not installed"));
  for (const std::string& name : NamesIn(scratch / "out")) {
    EXPECT_EQ(name.find(".png"), std::string::npos) << name;
    EXPECT_EQ(name.find(".pdf"), std::string::npos) << name;
  }
  EXPECT_THAT(NamesIn(scratch / "out"),
              IsSupersetOf({"results.json", "report.html", "overview.svg",
                            "step_responses_gain.svg"}));
  // The page has all its figures.
  const std::string page = Content(scratch / "out/report.html");
  EXPECT_THAT(page, HasSubstr("class=\"drawing\""));
  EXPECT_EQ(page.find("is missing"), std::string::npos);
}

TEST(MleReproduceOutputs, ALoopThatRunsAwayLeavesNothing) {
  const ScratchFolder scratch;
  const report::ProcessResult result =
      RunTested({"--out=" + scratch / "out", "--cases=delay",
                 "--disturbance_variance_ratio=1e9"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err,
              HasSubstr("error: case delay, seed 1: the closed loop diverges"));
  EXPECT_TRUE(fs::is_empty(scratch / "out"));
}

}  // namespace
}  // namespace mle
