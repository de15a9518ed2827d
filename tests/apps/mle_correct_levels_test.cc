// mle_correct on a level: a model with integrators, from file to files.

#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/exchange/model_file.h"
#include "mle/model/arx_model_json.h"
#include "mle/model/state_space_json.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

const std::string kConfigs = MLE_SOURCE_FOLDER "/configs/";

// The drum level of configs/, whose outflow valve has worn, in a closed loop
// with a change of its set point and one of the inflow.
class MleCorrectLevels : public ::testing::Test {
 protected:
  MleCorrectLevels() : data_(scratch_ / "run.csv"), out_(scratch_ / "out") {
    const absl::StatusOr<report::ProcessResult> made = report::RunProcess(
        MLE_SIMULATE_COMMAND,
        {"--model=" + kConfigs + "level.json",
         "--plant=" + kConfigs + "level_aged.json",
         "--setpoints=level:60:5,level:220:0",
         "--disturbances=inflow:140:2,inflow:300:0", "--duration=400",
         "--sample_time=0.2", "--noise_variance=0.01", "--seed=1",
         "--out=" + data_},
        "");
    EXPECT_TRUE(made.ok()) << made.status();
    if (made.ok()) {
      EXPECT_EQ(made->exit_code, 0) << made->err;
    }
  }

  nlohmann::json Run(const std::string& model) const {
    return Correct(CorrectionFlags(model, data_, out_,
                                   {"--truth=" + kConfigs + "level_aged.json"}),
                   out_);
  }

  const ScratchFolder scratch_;
  const std::string data_;
  const std::string out_;
};

TEST_F(MleCorrectLevels, TheAgedGainIsNamedAndTheRestKept) {
  const nlohmann::json result = Run(kConfigs + "level.json");
  EXPECT_EQ(result["decision"], "corrected");
  ASSERT_EQ(result["elements"].size(), 2U);
  const nlohmann::json& outflow = result["elements"][0];
  EXPECT_TRUE(outflow["aged"]);
  EXPECT_TRUE(outflow["integrating"]);
  EXPECT_EQ(outflow["time_constant"]["initial"], 0.0);
  const nlohmann::json& gain = outflow["gain"]["all_free"];
  EXPECT_NEAR(gain["value"], -0.25, 5.0 * double{gain["standard_error"]});
  EXPECT_LT(gain["standard_error"], 0.01);
  EXPECT_FALSE(result["elements"][1].value("aged", false));
  EXPECT_LT(result["truth"]["E_corrected"],
            0.05 * double{result["truth"]["E_initial"]});

  for (const char* name : {"/model.json", "/fopdt.json"}) {
    const auto model = ReadProcessModel(out_ + name);
    ASSERT_TRUE(model.ok()) << model.status();
    EXPECT_TRUE(model->element(0, 0).IsIntegratorWithLag());
    EXPECT_NEAR(model->element(0, 0).StaticGain(), -0.25, 0.02);
    EXPECT_EQ(model->element(0, 1).StaticGain(), 0.4);
    EXPECT_EQ(model->element(0, 1).TimeConstant(), 2.0);
  }
  // The free run of the ARX model is the ramp of the process model.
  const auto arx = ReadArxModel(out_ + "/arx.json");
  ASSERT_TRUE(arx.ok()) << arx.status();
  const auto model = ReadProcessModel(out_ + "/model.json");
  const StepResponse run = arx->model.ComputeStepResponse(1000);
  EXPECT_LT((run.values - model->ComputeStepResponse(0.2, 1000).values).norm(),
            1e-6);
  // So are the step responses of the state space, which is a model as well.
  const std::string states =
      scratch_.Write("states.json", Content(out_ + "/state_space.json"));
  const auto named = ReadStateSpace(states);
  ASSERT_TRUE(named.ok()) << named.status();
  const StepResponse ramps = named->system.ComputeStepResponse(1000);
  EXPECT_LT(
      (ramps.values - model->ComputeStepResponse(0.2, 1000).values).norm(),
      1e-6);

  EXPECT_EQ(Run(out_ + "/model.json")["decision"], "no_change");
  const nlohmann::json again = Run(states);
  EXPECT_EQ(again["decision"], "no_change");
  EXPECT_EQ(again["given_model"]["form"], "state_space");
}

TEST_F(MleCorrectLevels, StepResponsesThatEndInRampsAreCorrected) {
  const auto process = ReadProcessModel(kConfigs + "level.json");
  ASSERT_TRUE(process.ok());
  StepResponseModel given;
  given.channels = ProcessModel(process->name(), process->time_unit(),
                                process->inputs(), process->outputs());
  given.interval = 0.5;
  for (const int j : {1, 0}) {
    given.pairs.push_back(
        {0, j, process->element(0, j).StepResponse(0.5, 61).tail(60), true});
  }
  const nlohmann::json result =
      Run(scratch_.Write("level.csv", FormatStepResponseCsv(given)));
  EXPECT_EQ(result["decision"], "corrected");
  const auto corrected = ReadStepResponseModel(out_ + "/model_corrected.csv");
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  EXPECT_EQ(corrected->interval, 0.5);
  ASSERT_EQ(corrected->pairs.size(), 2U);
  EXPECT_EQ(corrected->length(), 60);
  EXPECT_TRUE(corrected->pairs[0].is_ramp);
  EXPECT_TRUE(corrected->pairs[1].is_ramp);
  EXPECT_EQ(corrected->pairs[0].coefficients, given.pairs[0].coefficients);
  const Eigen::VectorXd& ramp = corrected->pairs[1].coefficients;
  EXPECT_NEAR((ramp(59) - ramp(49)) / 5.0, -0.25, 0.02);
}

TEST_F(MleCorrectLevels, TheEstimatorArxIsRefused) {
  const report::ProcessResult result = RunTested(CorrectionFlags(
      kConfigs + "level.json", data_, out_, {"--estimator=arx"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("level ← outflow integrates"));
}

}  // namespace
}  // namespace mle
