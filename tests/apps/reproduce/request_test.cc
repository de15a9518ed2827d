// Flags and files that mle_reproduce cannot use: one line names the flag or
// file and what would be right.

#include "apps/reproduce/request.h"

#include <string>

#include "tests/apps/requested.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::reproduce {
namespace {

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

TEST(ReproduceRequestTest, ValuesOfTheWrongKind) {
  ExpectRefused<Request>({
      {{"--seeds=abc"}, {"--seeds=abc", "whole number"}},
      {{"--seeds=99999999999"}, {"--seeds=99999999999", "2147483647"}},
      {{"--first_seed=-1"}, {"--first_seed=-1", "from 0"}},
      {{"--order=1.5"}, {"--order=1.5", "whole number"}},
      {{"--sample_time=fast"}, {"--sample_time=fast", "must be a number"}},
      {{"--figures=maybe"}, {"--figures=maybe", "true or false"}},
      {{"--output_weight=x"}, {"--output_weight=x", "'x' is not a number"}},
      {{"--move_weight=1,,2"}, {"--move_weight=1,,2", "'' is not a number"}},
      {{"--conversion_noise_variance=x"}, {"--conversion_noise_variance=x"}},
  });
}

TEST(ReproduceRequestTest, ValuesOutOfRange) {
  ExpectRefused<Request>({
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

TEST(ReproduceRequestTest, AControllerThatCannotBe) {
  ExpectRefused<Request>({
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

TEST(ReproduceRequestTest, RecordsThatAreTooShort) {
  ExpectRefused<Request>({
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

TEST(ReproduceRequestTest, ChoiceOfThePenalty) {
  ExpectRefused<Request>({
      {{"--lambda_grid_step=0"}, {"--lambda_grid_step", "> 0"}},
      {{"--lambda_grid_step=1"}, {"--lambda_grid_step", "not above"}},
      {{"--lambda_grid_step=1e-300"}, {"--lambda_grid_step", "at most"}},
      {{"--lambda_grid_max=nan"}, {"--lambda_grid_max", "nan"}},
      {{"--selection=best"}, {"--selection=best", "choose from", "blocks"}},
      {{"--selection=blocks", "--selection_folds=1"},
       {"--selection_folds=1", "≥ 2"}},
      {{"--selection=blocks", "--selection_block=-1"},
       {"--selection_block=-1", "≥ 0"}},
      {{"--solver=simplex"},
       {"--solver=simplex", "choose from homotopy, ceres"}},
      {{"--estimators=arx,magic"},
       {"--estimators", "'magic'", "choose from output_error, arx"}},
      {{"--estimators=arx:magic"}, {"--estimators", "'magic'", "chi_square"}},
      {{"--estimators=output_error:adequacy"},
       {"--estimators", "change_test", "output_error"}},
      {{"--estimators=arx,arx"}, {"--estimators", "'arx' is named twice"}},
      {{"--scaling=none"}, {"--scaling=none", "choose from standardise"}},
  });
}

TEST(ReproduceRequestTest, ChoiceOfTheAblations) {
  ExpectRefused<Request>({
      {{"--ablations=speed"}, {"--ablations", "'speed'", "raw_scaling"}},
      {{"--ablations=all,raw_scaling"}, {"--ablations", "named twice"}},
      {{"--ablation_seeds=0"}, {"--ablation_seeds=0", "≥ 1"}},
  });
}

TEST(ReproduceRequestTest, Cases) {
  const std::string model = std::string("--model=") + kColumn;
  const std::string plant = kAgedColumn;
  ExpectRefused<Request>({
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

TEST(ReproduceRequestTest, ModelFiles) {
  const ScratchFolder scratch;
  const std::string heater =
      scratch.Write("heater.json", SingleModel("power", "2"));
  const std::string steam =
      scratch.Write("steam.json", SingleModel("steam", "2"));
  const std::string torn = scratch.Write("torn.json", "{\"name\": ");
  const std::string none = scratch / "none.json";
  const std::string model = "--model=" + heater;
  ExpectRefused<Request>({
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

}  // namespace
}  // namespace mle::reproduce
