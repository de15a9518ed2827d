// mle_correct as its users call it.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

TEST(MleCorrectTest, AChangedGainIsFoundAndCorrected) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result = example.Run();
  EXPECT_EQ(result["version"], 3);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_LT(result["test_of_no_change"]["p_value"], 1e-6);
  const nlohmann::json changed = ElementOf(result, "y1", "u1");
  EXPECT_TRUE(changed["aged"]);
  EXPECT_NEAR(changed["gain_ratio"], 0.5, 0.05);
  EXPECT_LE(changed["gain"]["corrected"]["lower"], 1.0 + 0.03);
  EXPECT_GE(changed["gain"]["corrected"]["upper"], 1.0 - 0.03);
  for (const auto& [output, input] :
       {std::pair("y1", "u2"), {"y2", "u1"}, {"y2", "u2"}}) {
    const nlohmann::json kept = ElementOf(result, output, input);
    EXPECT_FALSE(kept["aged"]) << output << input;
    EXPECT_EQ(kept["response_change"], 0.0);
  }
  EXPECT_LT(result["truth"]["E_corrected"],
            0.05 * result["truth"]["E_initial"].get<double>());
  // What it had not seen is predicted better.
  const nlohmann::json& y1 = result["validation"]["outputs"][0];
  EXPECT_EQ(y1["output"], "y1");
  for (const char* const horizon : {"one_step", "several_steps", "simulated"}) {
    EXPECT_GT(y1[horizon]["gain"],
              2.0 * y1[horizon]["standard_error"].get<double>());
  }
}

TEST(MleCorrectTest, SeveralChangesOfAllKindsAreCorrected) {
  Heater aged;
  aged.first.delay = 3.0;
  aged.fourth.time_constant = 8.0;
  const HeaterExample example(aged);
  const nlohmann::json result = example.Run();
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_NEAR(ElementOf(result, "y1", "u1")["delay_shift"], 2.0, 0.4);
  EXPECT_NEAR(
      ElementOf(result, "y2", "u2")["time_constant"]["corrected"]["value"], 8.0,
      0.8);
  EXPECT_LT(result["truth"]["E_corrected"],
            0.1 * result["truth"]["E_initial"].get<double>());
}

TEST(MleCorrectTest, AModelThatIsRightIsLeftAlone) {
  for (const char* const drift : {"0", "1e-6"}) {
    SCOPED_TRACE(drift);
    const HeaterExample example(
        Heater(), {"--drift_variance=" + std::string(drift), "--seed=4"});
    const nlohmann::json result = example.Run();
    EXPECT_EQ(result["decision"], "no_change");
    EXPECT_EQ(result["truth"]["E_corrected"], 0.0);
    EXPECT_EQ(Content(example.out + "/fopdt.json"),
              FormatProcessModel(*ReadProcessModel(example.model)));
    EXPECT_THAT(result["verdict"][0], HasSubstr("p = "));
    EXPECT_THAT(result["verdict"][0],
                HasSubstr(absl::StrFormat(
                    "(p = %#.2g for no change)",
                    result["test_of_no_change"]["p_value"].get<double>())));
  }
}

TEST(MleCorrectTest, AnInputThatDoesNotMoveKeepsItsElements) {
  // The third input stands still throughout.
  const std::string model_text = absl::StrReplaceAll(
      HeaterJson(Heater()),
      {{R"({"name": "u2", "unit": "%"}])",
        R"({"name": "u2", "unit": "%"}, {"name": "u3", "unit": "", "role": "disturbance"}])"},
       {"\n\"elements\": [",
        "\n\"elements\": [{\"output\": \"y2\", \"input\": \"u3\", \"gain\": 3, "
        "\"time_constant\": 4, \"delay\": 1},\n"}});
  const ScratchFolder scratch;
  const std::string model = scratch.Write("model.json", model_text);
  std::string aged = absl::StrReplaceAll(
      model_text, {{R"("u1", "gain": 2,)", R"("u1", "gain": 1,)"}});
  const std::string plant = scratch.Write("plant.json", aged);
  const std::string data = SimulateHeater(scratch, "run.csv", model, plant);
  const nlohmann::json result =
      Correct(CorrectionFlags(model, data, scratch / "out"), scratch / "out");
  EXPECT_EQ(result["decision"], "corrected");
  const nlohmann::json still = ElementOf(result, "y2", "u3");
  EXPECT_EQ(still["information"], "not_informed");
  EXPECT_EQ(still["state"], "not_informed");
  EXPECT_EQ(still["response_change"], 0.0);
  EXPECT_EQ(still["fopdt"]["gain"], 3.0);
  EXPECT_NEAR(ElementOf(result, "y1", "u1")["gain_ratio"], 0.5, 0.05);
  bool said = false;
  for (const std::string advice : result["advice"]) {
    said = said || (advice.find("u3") != std::string::npos &&
                    advice.find("step test") != std::string::npos);
  }
  EXPECT_TRUE(said) << result["advice"];
}

// What set points drive tells from one window, too, of which nothing else is
// held out.
TEST(MleCorrectTest, OneWindowIsCorrectedWhereSetPointsTell) {
  const HeaterExample example(WithHalvedGain(),
                              {"--setpoints=y1:60:1", "--duration=140"});
  const nlohmann::json result = example.Run();
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_LT(result["truth"]["E_corrected"],
            0.01 * result["truth"]["E_initial"].get<double>());
  EXPECT_EQ(result["windows"].size(), 1u);
  ASSERT_EQ(result["explanations"].size(), 1u);
  EXPECT_EQ(result["explanations"][0]["explanation"], "gain");
  EXPECT_EQ(result["judges"][0]["instruments"], "set_points");
  EXPECT_FALSE(result["judges"][0]["held_out"].empty());
  EXPECT_TRUE(result["validation"]["held_out"].empty());
  EXPECT_TRUE(result["validation"].contains("missing"));
  const nlohmann::json gain = ElementOf(result, "y1", "u1")["gain"];
  EXPECT_LT(gain["all_free"]["lower"], 1.03);
  EXPECT_GT(gain["all_free"]["upper"], 0.97);
  const nlohmann::json two = HeaterExample(WithHalvedGain()).Run();
  EXPECT_EQ(two["windows"].size(), 2u);
  EXPECT_EQ(two["decision"], "corrected");
}

// Steps of outputs that nobody measures, half as large as the set points'.
std::vector<std::string> Disturbance(const std::string& seed) {
  return {"--disturbance_step_rate=0.02", "--disturbance_step_deviation=0.5",
          "--seed=" + seed};
}

TEST(MleCorrectTest, ADisturbanceIsNotTakenForAgeing) {
  for (const char* const seed : {"1", "2", "3", "4"}) {
    SCOPED_TRACE(seed);
    const HeaterExample example(Heater(), Disturbance(seed));
    const nlohmann::json result = example.Run();
    EXPECT_EQ(result["decision"], "no_change");
    EXPECT_FALSE(result["warnings"].empty());  // the disturbance is seen
  }
}

TEST(MleCorrectTest, UnderADisturbanceACorrectionIsRightOrNotMade) {
  for (const char* const seed : {"1", "2", "3", "4"}) {
    SCOPED_TRACE(seed);
    const HeaterExample example(WithHalvedGain(), Disturbance(seed));
    const report::ProcessResult run =
        RunTested(CorrectionFlags(example.model, example.data, example.out,
                                  {"--truth=" + example.plant}));
    const nlohmann::json result = ParsedJson(example.out + "/result.json");
    const double before = result["truth"]["E_initial"];
    const double after = result["truth"]["E_corrected"];
    ASSERT_GT(before, 0.0);
    if (result["decision"] == "corrected") {
      EXPECT_LT(after, 0.05 * before);
    } else {
      EXPECT_EQ(after, before);
    }
    const bool decided =
        result["decision"] == "corrected" || result["decision"] == "no_change";
    EXPECT_EQ(run.exit_code, decided ? 0 : 1) << run.err;
  }
}

TEST(MleCorrectTest, AnotherTimeUnitGivesTheSameModel) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("min.json", HeaterJson(Heater()));
  const std::string plant =
      scratch.Write("aged_min.json", HeaterJson(WithHalvedGain()));
  const std::string data = SimulateHeater(scratch, "min.csv", model, plant);
  const std::string model_s =
      scratch.Write("s.json", HeaterJson(Heater(), "s", 60.0));
  const nlohmann::json in_minutes =
      Correct(CorrectionFlags(model, data, scratch / "min"), scratch / "min");
  // The same record, its times in minutes, for a model in seconds.
  const nlohmann::json in_seconds = Correct(
      CorrectionFlags(model_s, data, scratch / "s", {"--number_unit=min"}),
      scratch / "s");
  const nlohmann::json a = ElementOf(in_minutes, "y1", "u1");
  const nlohmann::json b = ElementOf(in_seconds, "y1", "u1");
  EXPECT_NEAR(b["fopdt"]["gain"].get<double>(), a["fopdt"]["gain"], 1e-5);
  EXPECT_NEAR(b["fopdt"]["time_constant"].get<double>() / 60.0,
              a["fopdt"]["time_constant"], 1e-4);
  EXPECT_NEAR(b["fopdt"]["delay"].get<double>() / 60.0, a["fopdt"]["delay"],
              1e-4);
}

TEST(MleCorrectTest, TheArxEstimatorCorrectsToo) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result =
      example.Run({"--estimator=arx", "--conversion_samples=20000"});
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_GT(result["lambda_star"], 0.0);
  EXPECT_LE(result["certificate"]["max_relative_duality_gap"], 1e-6);
  EXPECT_LT(result["truth"]["E_corrected"],
            0.1 * result["truth"]["E_initial"].get<double>());
  const HeaterExample right{Heater()};
  const nlohmann::json kept =
      right.Run({"--estimator=arx", "--conversion_samples=20000"});
  EXPECT_EQ(kept["decision"], "no_change");
}

// Parts of every window are held out: each has seen both set points move, so
// that ΔR can be validated from two windows.
TEST(MleCorrectTest, DeltaRIsValidatedFromTwoWindows) {
  const std::string configs = std::string(MLE_SOURCE_FOLDER) + "/configs/";
  const std::string model = configs + "wood_berry.json";
  const std::string plant = configs + "wood_berry_gain.json";
  const ScratchFolder scratch;
  const std::string data =
      SimulateHeater(scratch, "run.csv", model, plant,
                     {"--sample_time=1", "--control_period=1", "--duration=700",
                      "--setpoints=overhead:150:1,bottoms:450:1"});
  const nlohmann::json result =
      Correct(CorrectionFlags(model, data, scratch / "out",
                              {"--estimator=arx", "--conversion_samples=20000",
                               "--truth=" + plant}),
              scratch / "out", 0);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_LT(result["truth"]["E_corrected"],
            0.1 * result["truth"]["E_initial"].get<double>());
}

// Ceres solves what the path solves; a robust loss is another problem, near by
// where nothing is wrong with the records.
TEST(MleCorrectTest, SolversAgreeAndLossesAreTaken) {
  const HeaterExample example(WithHalvedGain());
  const std::vector<std::string> arx = {"--estimator=arx",
                                        "--conversion_samples=20000"};
  const auto run = [&](const std::string& flag) {
    std::vector<std::string> flags = arx;
    flags.push_back(flag);
    return example.Run(flags);
  };
  const nlohmann::json exact = run("--solver=homotopy");
  const nlohmann::json ceres = run("--solver=ceres");
  EXPECT_EQ(ceres["lambda_star"], exact["lambda_star"]);
  EXPECT_LE(ceres["certificate"]["max_relative_duality_gap"], 1e-6);
  const double E = exact["truth"]["E_corrected"];
  EXPECT_NEAR(ceres["truth"]["E_corrected"].get<double>(), E, 1e-3 * E);
  for (const char* const loss : {"--robust=huber", "--robust=cauchy"}) {
    SCOPED_TRACE(loss);
    const nlohmann::json robust = run(loss);
    EXPECT_EQ(robust["decision"], "corrected");
    EXPECT_LE(robust["certificate"]["max_relative_duality_gap"], 1e-6);
    EXPECT_NE(robust["truth"]["E_corrected"], exact["truth"]["E_corrected"]);
    EXPECT_LT(robust["truth"]["E_corrected"],
              0.1 * robust["truth"]["E_initial"].get<double>());
  }
}

// No gain, time constant and dead time make an inverse response; what is most
// like it is a longer dead time, and that something has happened is said.
TEST(MleCorrectTest, AnElementOfAnotherShapeIsNotPassedOver) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("model.json", HeaterJson(Heater()));
  const std::string plant = scratch.Write(
      "plant.json",
      absl::StrReplaceAll(
          HeaterJson(Heater()),
          {{R"("gain": 2, "time_constant": 5, "delay": 1)",
            R"("numerator": [-8, 2], "denominator": [15, 8, 1], "delay": 1)"}}));
  for (const char* const seed : {"1", "2", "3"}) {
    SCOPED_TRACE(seed);
    const std::string data = SimulateHeater(scratch, "run.csv", model, plant,
                                            {"--seed=" + std::string(seed)});
    RunTested(
        CorrectionFlags(model, data, scratch / "out",
                        {"--truth=" + plant, "--conversion_samples=20000"}));
    const nlohmann::json result = ParsedJson(scratch / "out/result.json");
    EXPECT_NE(result["decision"], "no_change");
    EXPECT_FALSE(result["explanations"].empty());
    EXPECT_GT(result["judges"][0]["before"], 2.0);
  }
}

TEST(MleCorrectTest, TheResultDoesNotDependOnTheThreads) {
  const HeaterExample example(WithHalvedGain());
  const auto without_flags = [&](const char* threads) {
    nlohmann::json result = example.Run({std::string("--threads=") + threads});
    result.erase("flags");
    result.erase("command");
    return result.dump();
  };
  const std::string one = without_flags("1");
  EXPECT_EQ(one, without_flags("2"));
}

TEST(MleCorrectTest, HelpNamesFlagsWithTheirDefaults) {
  const report::ProcessResult run = RunTested({"--help=all"});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* const flag :
       {"--model []", "--data []", "--out [correction]",
        "--estimator [output_error]", "--dry_run [false]", "--threads [0]",
        "--window_before [0] min, ≥ 0", "--confidence [0.95] in (0, 1)"}) {
    EXPECT_THAT(run.out, HasSubstr(flag));
  }
}

TEST(MleCorrectTest, TheVerdictHasAtMostSixLinesAndSaysWhatToDoFirst) {
  const HeaterExample example(WithHalvedGain());
  const std::vector<std::string> flags =
      CorrectionFlags(example.model, example.data, example.out);
  const report::ProcessResult run = RunTested(flags);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(run.out.find("Use the corrected model in the controller.\n"), 0u);
  EXPECT_THAT(run.out, HasSubstr("Gain of y1 ← u1 fell by "));
  EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 6);
  std::vector<std::string> verbose = flags;
  verbose.emplace_back("--verbose");
  const report::ProcessResult all = RunTested(verbose);
  EXPECT_EQ(all.out.find(run.out), 0u);
  EXPECT_THAT(all.out, HasSubstr("Residual tests"));
  EXPECT_THAT(all.out, HasSubstr("What to do"));
}

TEST(MleCorrectTest, TheVerdictSaysThatNothingHasChanged) {
  const HeaterExample example((Heater()));
  const report::ProcessResult run =
      RunTested(CorrectionFlags(example.model, example.data, example.out));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find("Keep the controller's model.\n"), 0u);
  EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 6);
}

TEST(MleCorrectTest, AWindowIsLeftOutByATimeInIt) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json all = example.Run();
  ASSERT_EQ(all["windows"].size(), 2u);
  const nlohmann::json& change = all["windows"][1]["set_point_changes"][0];
  const std::string flag =
      absl::StrFormat("--leave_out=%g", change["time"].get<double>());
  const report::ProcessResult run = RunTested(
      CorrectionFlags(example.model, example.data, example.out, {flag}));
  EXPECT_NE(run.exit_code, 2) << run.err;
  const nlohmann::json one = ParsedJson(example.out + "/result.json");
  ASSERT_EQ(one["windows"].size(), 1u);
  EXPECT_EQ(one["windows"][0], all["windows"][0]);
  EXPECT_THAT(one["notes"].dump(), HasSubstr("is left out, as asked for"));
  // A time in no window is a mistake.
  const report::ProcessResult none = RunTested(CorrectionFlags(
      example.model, example.data, example.out, {"--leave_out=1e6"}));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("--leave_out: no window contains"));
}

}  // namespace
}  // namespace mle
