// What mle_reproduce answers to flags and files it cannot use: exit code 2, one
// line that names the flag or file and what would be right, and no output.

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct BadInput {
  std::vector<std::string> arguments;
  std::vector<std::string> named;  // what the message must hold
};

void ExpectRefused(const std::vector<BadInput>& inputs) {
  for (const BadInput& bad : inputs) {
    const ScratchFolder scratch;
    std::vector<std::string> arguments = {"--out=" + scratch / "out"};
    arguments.insert(arguments.end(), bad.arguments.begin(),
                     bad.arguments.end());
    SCOPED_TRACE(::testing::PrintToString(bad.arguments));
    const report::ProcessResult result = RunTested(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, StartsWith("error: "));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1)
        << result.err;
    for (const std::string& name : bad.named) {
      EXPECT_THAT(result.err, HasSubstr(name));
    }
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
  }
}

constexpr char kColumn[] = MLE_SOURCE_FOLDER "/configs/wood_berry.json";
constexpr char kAgedColumn[] =
    MLE_SOURCE_FOLDER "/configs/wood_berry_gain.json";

// A process model of one input and one output.
std::string SingleModel(const std::string& input, const std::string& gain) {
  return R"({"name": "heater", "time_unit": "min",
    "inputs": [{"name": ")" +
         input + R"(", "unit": "%"}],
    "outputs": [{"name": "temperature", "unit": "K"}],
    "elements": [{"output": "temperature", "input": ")" +
         input + R"(", "gain": )" + gain +
         R"(, "time_constant": 5, "delay": 1}]})";
}

TEST(MleReproduceBadInput, UnknownFlagsAndStrayArguments) {
  ExpectRefused({
      {{"--seed=3"}, {"--seed", "--help"}},
      {{"--nosuch"}, {"--nosuch", "--help"}},
      {{"gain"}, {"'gain'", "--help"}},
      {{"--"}, {"'--'"}},
      {{"--seeds"}, {"--seeds", "value"}},
  });
}

TEST(MleReproduceBadInput, ValuesOfTheWrongKind) {
  ExpectRefused({
      {{"--seeds=abc"}, {"--seeds=abc", "whole number"}},
      {{"--seeds=a\nb"}, {"--seeds=a\\nb: 'a\\nb' is not a whole number"}},
      {{"--seeds=99999999999"}, {"--seeds=99999999999", "2147483647"}},
      {{"--first_seed=-1"}, {"--first_seed=-1", "from 0"}},
      {{"--order=1.5"}, {"--order=1.5", "whole number"}},
      {{"--sample_time=fast"}, {"--sample_time=fast", "not a number"}},
      {{"--figures=maybe"}, {"--figures=maybe", "true nor false"}},
      {{"--output_weight=x"}, {"--output_weight=x", "'x' is not a number"}},
      {{"--move_weight=1,,2"}, {"--move_weight=1,,2", "'' is not a number"}},
      {{"--conversion_noise_variance=x"}, {"--conversion_noise_variance=x"}},
  });
}

TEST(MleReproduceBadInput, ValuesOutOfRange) {
  ExpectRefused({
      {{"--seeds=0"}, {"--seeds=0", "[1, 10000]"}},
      {{"--seeds=-3"}, {"--seeds=-3", "[1, 10000]"}},
      {{"--seeds=2147483647"}, {"--seeds=2147483647", "[1, 10000]"}},
      {{"--seeds=2", "--first_seed=18446744073709551615"},
       {"--first_seed=18446744073709551615", "--seeds=2"}},
      {{"--threads=-1"}, {"--threads=-1"}},
      {{"--sample_time=0"}, {"--sample_time=0", "> 0"}},
      {{"--sample_time=nan"}, {"--sample_time=nan", "> 0"}},
      {{"--sample_time=1e-300"}, {"--sample_time=1e-300", "samples"}},
      {{"--noise_variance=-1"}, {"--noise_variance=-1", "≥ 0"}},
      {{"--noise_variance=inf"}, {"--noise_variance=inf", "finite"}},
      {{"--conversion_noise_variance=-1"},
       {"--conversion_noise_variance=-1", "≥ 0"}},
      {{"--conversion_penalty=nan"}, {"--conversion_penalty=nan", "finite"}},
      {{"--disturbance_variance_ratio=-1"},
       {"--disturbance_variance_ratio=-1", "≥ 0"}},
      {{"--setpoint_step=0"}, {"--setpoint_step=0", "other than 0"}},
      {{"--step_time=nan"}, {"--step_time=nan", "finite"}},
  });
}

TEST(MleReproduceBadInput, AControllerThatCannotBe) {
  ExpectRefused({
      {{"--control_horizon=31"},
       {"--control_horizon=31", "--prediction_horizon=30"}},
      {{"--control_horizon=0"}, {"--control_horizon=0", "≥ 1"}},
      {{"--prediction_horizon=2147483647"},
       {"--prediction_horizon", "2147483647", "too long"}},
      {{"--control_period=0.3"},
       {"--control_period=0.3", "--sample_time=0.2", "multiple"}},
      {{"--control_period=1e300"}, {"--control_period=1e+300"}},
      {{"--output_weight=-1"}, {"--output_weight", "-1", "≥ 0"}},
      {{"--output_weight=1,2,3"}, {"--output_weight=1,2,3", "3", "2"}},
      {{"--move_weight=0.1,-2"}, {"--move_weight", "-2", "≥ 0"}},
      {{"--output_weight=0", "--move_weight=0"}, {"weight", "move_weight"}},
  });
}

TEST(MleReproduceBadInput, RecordsThatAreTooShort) {
  ExpectRefused({
      {{"--window=600"},
       {"--window=600", "--step_time=500", "-100 to 1100", "--duration=1000"}},
      {{"--duration=1e-9"}, {"--window=200", "--duration=1e-09"}},
      {{"--order=3000"}, {"--order=3000", "2001 samples"}},
      {{"--order=2147483647"}, {"--order=2147483647"}},
      {{"--order=0"}, {"--order=0", "≥ 1"}},
      {{"--conversion_duration=31"},
       {"--conversion_duration=31", "--order=150", "600", "at least 150"}},
      {{"--response_horizon=0.2"}, {"--response_horizon=0.2", "at least 0.8"}},
      {{"--response_horizon=1e9"},
       {"--response_horizon=1000000000", "at most"}},
  });
}

TEST(MleReproduceBadInput, ChoiceOfThePenalty) {
  ExpectRefused({
      {{"--lambda_grid_step=0"}, {"--lambda_grid_step", "> 0"}},
      {{"--lambda_grid_step=1"}, {"--lambda_grid_step", "not above"}},
      {{"--lambda_grid_step=1e-300"}, {"--lambda_grid_step", "at most"}},
      {{"--lambda_grid_max=nan"}, {"--lambda_grid_max", "nan"}},
      {{"--selection=best"}, {"--selection=best", "known are", "blocks"}},
      {{"--selection=blocks", "--selection_folds=1"},
       {"--selection_folds=1", "≥ 2"}},
      {{"--selection=blocks", "--selection_block=-1"},
       {"--selection_block=-1", "≥ 0"}},
      {{"--solver=simplex"}, {"--solver=simplex", "known are homotopy, ceres"}},
      {{"--estimators=arx,magic"},
       {"--estimators", "'magic'", "known are output_error, arx"}},
      {{"--estimators=arx:magic"}, {"--estimators", "'magic'", "chi_square"}},
      {{"--estimators=combined:adequacy"},
       {"--estimators", "change_test", "combined"}},
      {{"--estimators=arx,arx"}, {"--estimators", "'arx' is named twice"}},
      {{"--scaling=none"}, {"--scaling=none", "known are standardise"}},
  });
}

TEST(MleReproduceBadInput, ChoiceOfTheAblations) {
  ExpectRefused({
      {{"--ablations=speed"}, {"--ablations", "'speed'", "raw_scaling"}},
      {{"--ablations=all,raw_scaling"}, {"--ablations", "named twice"}},
      {{"--ablation_seeds=0"}, {"--ablation_seeds=0", "≥ 1"}},
  });
}

TEST(MleReproduceBadInput, Cases) {
  const std::string model = std::string("--model=") + kColumn;
  const std::string plant = kAgedColumn;
  ExpectRefused({
      {{"--cases=drift"}, {"--cases", "'drift'", "gain and delay"}},
      {{"--cases="}, {"--cases"}},
      {{"--cases=gain,gain"}, {"--cases", "'gain' is named twice"}},
      {{model}, {"--model", "--plants"}},
      {{"--plants=a:" + plant}, {"--model", "--plants"}},
      {{model, "--plants=" + plant}, {"--plants", "NAME:FILE"}},
      {{model, "--plants=,"}, {"--plants"}},
      {{model, "--plants=../a:" + plant}, {"--plants", "'../a'", "letters"}},
      {{model, "--plants=a:" + plant + ",a:" + plant},
       {"--plants", "'a' is named twice"}},
      {{model, "--plants=a:" + plant, "--cases=gain"}, {"--cases", "--model"}},
  });
}

TEST(MleReproduceBadInput, ModelFiles) {
  const ScratchFolder scratch;
  const std::string heater =
      scratch.Write("heater.json", SingleModel("power", "2"));
  const std::string steam =
      scratch.Write("steam.json", SingleModel("steam", "2"));
  const std::string torn = scratch.Write("torn.json", "{\"name\": ");
  const std::string none = scratch / "none.json";
  const std::string model = "--model=" + heater;
  ExpectRefused({
      {{"--model=" + none, "--plants=a:" + heater}, {"--model", none}},
      {{model, "--plants=a:" + none}, {"--plants", none}},
      {{model, "--plants=a:" + torn}, {"--plants", torn, "line"}},
      {{"--model=/", "--plants=a:" + heater}, {"--model", "folder"}},
      {{model, "--plants=a:" + steam},
       {"--plants", "\"power\"", "\"steam\"", heater, steam}},
      {{model, "--plants=a:" + heater, "--output_weight=1,2",
        "--selection=blocks"},
       {"--output_weight=1,2", "2 values", "1"}},
      // One output gives one set-point change.
      {{model, "--plants=a:" + heater, "--selection=leave_change_out"},
       {"two set-point changes", "--selection=blocks"}},
  });
}

TEST(MleReproduceBadInput, FlagFiles) {
  const ScratchFolder scratch;
  const std::string misspelled =
      scratch.Write("misspelled", "# a comment\n\n--ordr=20\n");
  const std::string bare = scratch.Write("bare", "--seeds=1\norder=20\n");
  const std::string endless = scratch.Write("endless", "");
  scratch.Write("endless", "--flagfile=" + endless + "\n");
  ExpectRefused({
      {{"--flagfile=" + scratch / "none"}, {"--flagfile", "none"}},
      {{"--flagfile=" + misspelled}, {misspelled + ":3", "--ordr"}},
      {{"--flagfile=" + bare}, {bare + ":2", "'order=20'"}},
      {{"--flagfile=" + endless}, {endless, "deep"}},
  });
}

TEST(MleReproduceBadInput, FoldersThatCannotBeWrittenTo) {
  const ScratchFolder scratch;
  const std::string file = scratch.Write("file", "here first\n");
  for (const std::string& out : {file, file + "/below", std::string()}) {
    SCOPED_TRACE(out);
    const report::ProcessResult result = RunTested({"--out=" + out});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, StartsWith("error: --out: "));
    EXPECT_THAT(result.err, HasSubstr(out));
  }
  EXPECT_EQ(Content(file), "here first\n");
}

TEST(MleReproduceBadInput, AReadOnlyFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  const ScratchFolder scratch;
  const std::string folder = scratch / "read_only";
  ASSERT_EQ(mkdir(folder.c_str(), 0555), 0);
  const report::ProcessResult result = RunTested({"--out=" + folder});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, StartsWith("error: --out: "));
  EXPECT_THAT(result.err, HasSubstr(folder));
}

}  // namespace
}  // namespace mle
