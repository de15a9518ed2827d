// mle_correct as its users call it.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"
#include "mle/model/step_response.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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

TEST(MleCorrectTest, TheFilesAgreeWithEachOther) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result = example.Run();
  const absl::StatusOr<ProcessModel> fopdt =
      ReadProcessModel(example.out + "/fopdt.json");
  ASSERT_TRUE(fopdt.ok()) << fopdt.status();
  EXPECT_DOUBLE_EQ(fopdt->element(0, 0).StaticGain(),
                   ElementOf(result, "y1", "u1")["fopdt"]["gain"]);
  const auto lines = ParsedCsv(example.out + "/step_response.csv");
  ASSERT_GT(lines.size(), 10u);
  const std::vector<std::string>& header = lines[0];
  ASSERT_EQ(header.size(), 1u + 5u * 4u);
  EXPECT_EQ(header[0], "time");
  EXPECT_EQ(header[1], "y1/u1 initial");
  EXPECT_EQ(header[5], "y1/u1 corrected");
  EXPECT_EQ(header[9], "y1/u1 true");
  EXPECT_EQ(header[13], "y1/u1 corrected_lower");
  EXPECT_EQ(header[17], "y1/u1 corrected_upper");
  // E from the file is E of the result, and the band lies about the response.
  double squared = 0.0;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    ASSERT_EQ(lines[k].size(), header.size());
    for (int c = 0; c < 4; ++c) {
      const double corrected = std::stod(lines[k][5 + c]);
      const double error = corrected - std::stod(lines[k][9 + c]);
      squared += error * error;
      EXPECT_LE(std::stod(lines[k][13 + c]), corrected);
      EXPECT_GE(std::stod(lines[k][17 + c]), corrected);
    }
  }
  // Values are written with 12 digits.
  EXPECT_NEAR(squared, result["truth"]["E_corrected"], 1e-8 * (1.0 + squared));
  const nlohmann::json arx = ParsedJson(example.out + "/arx.json");
  EXPECT_EQ(arx["R"].size(), 2u);
  EXPECT_EQ(arx["R"][0].size(), arx["order"].get<std::size_t>() * 4);
  // The corrected model is a plant for mle_simulate.
  SimulateHeater(example.scratch, "again.csv", example.out + "/fopdt.json",
                 example.plant);
}

TEST(MleCorrectTest, TheStateSpaceModelHasTheStepResponsesOfTheProcessModel) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result = example.Run({"--conversion_samples=30000"});
  const auto named = ReadStateSpace(example.out + "/state_space.json");
  ASSERT_TRUE(named.ok()) << named.status();
  const auto model = ReadProcessModel(example.out + "/model.json");
  ASSERT_TRUE(model.ok()) << model.status();
  const DiscreteStateSpace& system = named->system;
  EXPECT_EQ(result["state_space"]["written"], true);
  EXPECT_EQ(result["state_space"]["order"], system.order());
  const StepResponse found = system.ComputeStepResponse(400);
  const StepResponse wanted =
      model->ComputeStepResponse(system.sample_time, 400);
  double largest = 0.0;
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(named->outputs[i], model->outputs()[i].name);
    for (int j = 0; j < 2; ++j) {
      const double size = wanted.element(i, j).cwiseAbs().maxCoeff();
      const double off =
          (found.element(i, j) - wanted.element(i, j)).cwiseAbs().maxCoeff();
      if (size > 0.0) largest = std::max(largest, off / size);
      EXPECT_LE(off, size * (named->accuracy->largest_differences[i] + 1e-9));
    }
  }
  EXPECT_NEAR(result["state_space"]["largest_difference"], largest, 1e-6);
  EXPECT_LE(result["state_space"]["error_bound"].get<double>(), 0.01);
  EXPECT_THAT(Content(example.out + "/report.html"),
              HasSubstr("discrete state-space model"));
}

TEST(MleCorrectTest, TheArxModelHasTheStepResponsesOfTheProcessModel) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result = example.Run({"--conversion_samples=30000"});
  const nlohmann::json file = ParsedJson(example.out + "/arx.json");
  ArxModel arx;
  arx.sample_time = file["sample_time"];
  arx.order = file["order"];
  arx.num_outputs = arx.num_inputs = 2;
  arx.R.resize(2, 4 * arx.order);
  for (int i = 0; i < 2; ++i) {
    for (int n = 0; n < arx.R.cols(); ++n) arx.R(i, n) = file["R"][i][n];
  }
  const StepResponse response = arx.ComputeStepResponse(140);
  const StepResponse wanted = ReadProcessModel(example.out + "/fopdt.json")
                                  ->ComputeStepResponse(0.25, 140);
  EXPECT_LT(std::sqrt(SquaredDistance(response, wanted) /
                      wanted.values.squaredNorm()),
            1e-6);
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

TEST(MleCorrectTest, OneWindowCannotTellAndSaysWhatIsMissing) {
  const HeaterExample example(WithHalvedGain(),
                              {"--setpoints=y1:60:1", "--duration=140"});
  const nlohmann::json result = example.Run({}, 1);
  EXPECT_EQ(result["decision"], "cannot_tell");
  EXPECT_EQ(result["truth"]["E_corrected"], result["truth"]["E_initial"]);
  EXPECT_EQ(result["windows"].size(), 1u);
  EXPECT_EQ(result["reasons"].back()["code"], "nothing_held_out");
  EXPECT_TRUE(result["validation"]["held_out"].empty());
  EXPECT_TRUE(result["validation"].contains("missing"));
  // The estimate is there, right, and not used.
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
  int corrected = 0;
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
      ++corrected;
      EXPECT_LT(after, 0.05 * before);
    } else {
      EXPECT_EQ(after, before);
    }
    const bool decided =
        result["decision"] == "corrected" || result["decision"] == "no_change";
    EXPECT_EQ(run.exit_code, decided ? 0 : 1) << run.err;
  }
  EXPECT_GE(corrected, 2);
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

// No gain, time constant and dead time make an inverse response: what is fitted
// then is worse than the initial model, and says nothing of it.
TEST(MleCorrectTest, AnElementOfAnotherShapeIsSaidToBeOne) {
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
    EXPECT_FALSE(result["structure_adequate"]["adequate"]);
    bool said = false;
    for (const nlohmann::json& finding : result["findings"]) {
      said = said || finding["name"] == "structure_adequate";
    }
    EXPECT_TRUE(said) << result["findings"];
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

TEST(MleCorrectTest, TheDryRunWritesNothing) {
  const HeaterExample example(WithHalvedGain());
  const report::ProcessResult run = RunTested(
      CorrectionFlags(example.model, example.data, example.out, {"--dry_run"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Windows around set-point changes"));
  EXPECT_THAT(run.out, HasSubstr("y2 0 → 1"));
  EXPECT_FALSE(std::filesystem::exists(example.out));
}

TEST(MleCorrectTest, NamesAreTextWhateverTheyHold) {
  const std::string hostile = R"(<script>alert(1)</script> \"u1\" & 'x' 🌡)";
  const ScratchFolder scratch;
  const auto rename = [&](const Heater& heater) {
    return absl::StrReplaceAll(HeaterJson(heater), {{"u1", hostile}});
  };
  const std::string plain_model =
      scratch.Write("plain.json", HeaterJson(Heater()));
  const std::string plain_plant =
      scratch.Write("plain_aged.json", HeaterJson(WithHalvedGain()));
  const std::string plain =
      SimulateHeater(scratch, "plain.csv", plain_model, plain_plant);
  const std::string model = scratch.Write("model.json", rename(Heater()));
  const std::string data = scratch.Write(
      "run.csv",
      absl::StrReplaceAll(
          Content(plain),
          {{"u1", R"("<script>alert(1)</script> ""u1"" & 'x' 🌡")"}}));
  const nlohmann::json result =
      Correct(CorrectionFlags(model, data, scratch / "out"), scratch / "out");
  EXPECT_EQ(result["decision"], "corrected");
  const std::string name = R"(<script>alert(1)</script> "u1" & 'x' 🌡)";
  EXPECT_EQ(ElementOf(result, "y1", name)["aged"], true);
  const std::string page = Content(scratch / "out/report.html");
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(page, HasSubstr("🌡"));
  EXPECT_EQ(ParsedCsv(scratch / "out/step_response.csv")[0][1],
            "y1/" + name + " initial");
  EXPECT_TRUE(ReadProcessModel(scratch / "out/fopdt.json").ok());
}

TEST(MleCorrectTest, ChecksumsAndFlagsTieTheResultToItsInputs) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json result = example.Run({"--seed=7"});
  EXPECT_EQ(result["inputs"]["data"][0]["path"], example.data);
  EXPECT_EQ(result["inputs"]["data"][0]["bytes"],
            std::filesystem::file_size(example.data));
  const absl::StatusOr<report::ProcessResult> sum =
      report::RunProcess("sha256sum", {example.data}, "");
  ASSERT_TRUE(sum.ok()) << sum.status();
  EXPECT_EQ(result["inputs"]["data"][0]["sha256"], sum->out.substr(0, 64));
  EXPECT_EQ(result["flags"]["seed"], "7");
  EXPECT_THAT(result["command"].get<std::string>(), HasSubstr("--seed=7"));
}

TEST(MleCorrectTest, NothingThatIsWrittenIsNotANumber) {
  const HeaterExample example(WithHalvedGain(), {"--lost_probability=0.3"});
  example.Run();
  for (const char* const file :
       {"result.json", "arx.json", "state_space.json", "model.json",
        "fopdt.json", "step_response.csv"}) {
    const std::string content = Content(example.out + "/" + file);
    EXPECT_THAT(content, Not(HasSubstr("nan"))) << file;
    EXPECT_THAT(content, Not(HasSubstr("inf,"))) << file;
  }
}

TEST(MleCorrectTest, HelpNamesFlagsWithTheirDefaults) {
  const report::ProcessResult run = RunTested({"--help=all"});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* const flag :
       {"--model []", "--data []", "--out [correction]",
        "--estimator [combined]", "--dry_run [false]", "--threads [0]",
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

TEST(MleCorrectTest, ARunIsComparedWithTheLast) {
  const HeaterExample example(WithHalvedGain());
  example.Run();
  const std::string now = example.scratch / "now";
  const auto page_of = [&](const std::string& data) {
    Correct(CorrectionFlags(example.model, data, now,
                            {"--previous=" + example.out}),
            now);
    return Content(now + "/report.html");
  };
  EXPECT_THAT(page_of(example.data),
              HasSubstr("said “corrected”. No estimate differs"));
  // The gain that had halved is back, the other has not changed.
  const std::string back =
      SimulateHeater(example.scratch, "back.csv", example.model, example.model);
  const std::string page = page_of(back);
  const std::size_t table = page.find("Estimates that differ");
  ASSERT_NE(table, std::string::npos);
  EXPECT_LT(page.find("y1 ← u1", table), page.find("</table>", table));
  const report::ProcessResult none =
      RunTested(CorrectionFlags(example.model, example.data, now,
                                {"--previous=" + example.scratch / "none"}));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("--previous"));
}

TEST(MleCorrectTest, JsonOnStandardOutputIsTheFileAndNothingElse) {
  const HeaterExample example(WithHalvedGain());
  const report::ProcessResult run = RunTested(CorrectionFlags(
      example.model, example.data, example.out, {"--json", "--verbose"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, Content(example.out + "/result.json"));
}

}  // namespace
}  // namespace mle
