// mle_correct as its users call it.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Heater WithHalvedGain() {
  Heater aged;
  aged.first.gain = 1.0;
  return aged;
}

// A model, an aged plant, and a record of it.
struct Example {
  explicit Example(const Heater& aged,
                   const std::vector<std::string>& more = {})
      : model(scratch.Write("model.json", HeaterJson(Heater()))),
        plant(scratch.Write("plant.json", HeaterJson(aged))),
        data(SimulateHeater(scratch, "run.csv", model, plant, more)),
        out(scratch / "out") {}

  nlohmann::json Run(std::vector<std::string> more = {},
                     int exit_code = 0) const {
    more.push_back("--truth=" + plant);
    return Correct(CorrectionFlags(model, data, out, more), out, exit_code);
  }

  const ScratchFolder scratch;
  std::string model, plant, data, out;
};

TEST(MleCorrectTest, AChangedGainIsFoundAndCorrected) {
  const Example example(WithHalvedGain());
  const nlohmann::json result = example.Run();
  EXPECT_EQ(result["version"], 1);
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
  EXPECT_GT(result["validation"]["windows"]["log_likelihood_gain"], 0.0);
  EXPECT_GT(result["validation"]["blocks"]["log_likelihood_gain"], 0.0);
}

TEST(MleCorrectTest, SeveralChangesOfAllKindsAreCorrected) {
  Heater aged;
  aged.first.delay = 3.0;
  aged.fourth.time_constant = 8.0;
  const Example example(aged);
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
    const Example example(
        Heater(), {"--drift_variance=" + std::string(drift), "--seed=4"});
    const nlohmann::json result = example.Run();
    EXPECT_EQ(result["decision"], "no_change");
    EXPECT_EQ(result["truth"]["E_corrected"], 0.0);
    EXPECT_EQ(Content(example.out + "/fopdt.json"),
              FormatProcessModel(*ReadProcessModel(example.model)));
    EXPECT_THAT(result["verdict"][0], HasSubstr("left alone"));
    EXPECT_THAT(result["verdict"][0],
                HasSubstr(absl::StrFormat(
                    "(p = %#.2g for no change)",
                    result["test_of_no_change"]["p_value"].get<double>())));
  }
}

TEST(MleCorrectTest, TheFilesAgreeWithEachOther) {
  const Example example(WithHalvedGain());
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

TEST(MleCorrectTest, TheArxModelHasTheStepResponsesOfTheProcessModel) {
  const Example example(WithHalvedGain());
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
  // The conversion is itself an estimate under noise.
  EXPECT_LT(std::sqrt(SquaredDistance(response, wanted) /
                      wanted.values.squaredNorm()),
            0.02);
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

TEST(MleCorrectTest, OneWindowIsEnoughAndItsLimitsAreSaid) {
  const Example example(WithHalvedGain(),
                        {"--setpoints=y1:60:1", "--duration=140"});
  const nlohmann::json result = example.Run();
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["windows"].size(), 1u);
  EXPECT_FALSE(result["validation"].contains("windows"));
  EXPECT_GT(result["validation"]["blocks"]["log_likelihood_gain"], 0.0);
  EXPECT_FALSE(result["warnings"].empty());
}

TEST(MleCorrectTest, GapsOutliersAndRoundingAreSaidAndSurvived) {
  const Example clean(WithHalvedGain());
  const Example faulty(
      WithHalvedGain(),
      {"--lost_probability=0.05", "--lost_input_probability=0.02",
       "--outlier_probability=0.01", "--outlier_size=1", "--quantum=0.003",
       "--faults_only_in_record"});
  const nlohmann::json before = clean.Run();
  const nlohmann::json result = faulty.Run();
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_GT(result["channels"][0]["bad"], 20);
  EXPECT_GT(result["channels"][0]["outliers"], 1);
  // In units of the initial distance: the same noise, fewer samples.
  EXPECT_LT(result["truth"]["E_corrected"],
            3.0 * before["truth"]["E_corrected"].get<double>() +
                1e-3 * before["truth"]["E_initial"].get<double>());
}

// Columns of other names and units, of a scale with an exponent and of one that
// turns the sign, are the model's channels.
TEST(MleCorrectTest, TagsAreMappedWithTheirUnits) {
  const Example example(WithHalvedGain());
  std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(example.data), '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  for (std::string& line : lines) {
    std::vector<std::string> fields = absl::StrSplit(line, ',');
    for (std::size_t c = 0; c < names.size(); ++c) {
      double value = 0.0;
      const bool header = !absl::SimpleAtod(fields[c], &value);
      if (names[c] == "y1") {
        fields[c] =
            header ? "TI 101" : absl::StrFormat("%.17g", (value - 5) / 0.2);
      } else if (names[c] == "u1") {
        fields[c] = header ? "FC-7.OP" : absl::StrFormat("%.17g", -value);
      }
    }
    line = absl::StrJoin(fields, ",");
  }
  const std::string data = example.scratch.Write(
      "tags.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
  const auto correct = [&](const std::string& tags) {
    return RunTested(
        CorrectionFlags(example.model, data, example.out,
                        {"--tags=" + tags, "--truth=" + example.plant}));
  };
  const nlohmann::json before = example.Run();
  ASSERT_EQ(correct("TI 101=y1*2e-1+5,FC-7.OP=u1*-1").exit_code, 0);
  const nlohmann::json after = ParsedJson(example.out + "/result.json");
  EXPECT_EQ(after["decision"], "corrected");
  EXPECT_NEAR(ElementOf(after, "y1", "u1")["gain_ratio"],
              ElementOf(before, "y1", "u1")["gain_ratio"].get<double>(), 1e-6);
  EXPECT_NEAR(after["truth"]["E_corrected"],
              before["truth"]["E_corrected"].get<double>(),
              1e-6 * before["truth"]["E_initial"].get<double>());

  for (const auto& [tags, message] :
       {std::pair("y1", "not of the form TAG=CHANNEL"),
        {"TI 101=y7*2", "'y7' is no input, output"},
        {"TI 101=y1*two", "*SCALE+OFFSET is expected"},
        {"TI 101=y1*2+", "*SCALE+OFFSET is expected"}}) {
    const report::ProcessResult run = correct(tags);
    EXPECT_EQ(run.exit_code, 2) << tags;
    EXPECT_THAT(run.err, AllOf(HasSubstr("--tags"), HasSubstr(message)));
  }
}

// A window whose inputs are missing for a while is cut where its set-point
// change is left, and left out where it is not.
TEST(MleCorrectTest, WindowsWithoutInputsAreCutOrLeftOut) {
  const Example example(WithHalvedGain());
  const std::string text = *ReadFile(example.data);
  const auto run = [&](double from, double to) {
    std::vector<std::string> lines =
        absl::StrSplit(text, '\n', absl::SkipEmpty());
    const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
    for (std::size_t k = 1; k < lines.size(); ++k) {
      std::vector<std::string> fields = absl::StrSplit(lines[k], ',');
      double time = 0.0;
      EXPECT_TRUE(absl::SimpleAtod(fields[0], &time));
      if (time < from || time > to) continue;
      for (std::size_t c = 0; c < names.size(); ++c) {
        if (names[c] == "u1") fields[c].clear();
      }
      lines[k] = absl::StrJoin(fields, ",");
    }
    const std::string data = example.scratch.Write(
        "missing.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
    return Correct(CorrectionFlags(example.model, data, example.out,
                                   {"--max_gap=1", "--truth=" + example.plant}),
                   example.out);
  };
  const nlohmann::json whole = example.Run();
  ASSERT_EQ(whole["windows"].size(), 2U);
  const double end = whole["windows"][0]["to"];

  const nlohmann::json cut = run(end - 10.0, end - 7.0);
  EXPECT_THAT(cut["warnings"].dump(), HasSubstr("is cut to its longest part"));
  ASSERT_EQ(cut["windows"].size(), 2U);
  EXPECT_NEAR(cut["windows"][0]["to"].get<double>(), end - 10.0, 0.5);
  EXPECT_LT(cut["truth"]["E_corrected"],
            0.05 * cut["truth"]["E_initial"].get<double>());

  const nlohmann::json left_out = run(59.0, 62.0);
  EXPECT_THAT(left_out["warnings"].dump(),
              HasSubstr("inputs are missing around its set-point change"));
  EXPECT_EQ(left_out["windows"].size(), 1U);
}

// Now and then eight samples in a row of both outputs off by 15 to 45
// deviations, to one side: the model finds what neighbours do not.
TEST(MleCorrectTest, BurstsOfOutliersAreFoundByTheModel) {
  const Example example(WithHalvedGain());
  std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(example.data), '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  int spoilt = 0;
  for (std::size_t k = 20; k + 60 < lines.size(); k += 97) {
    const double side = k % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t i = k; i < k + 8; ++i) {
      std::vector<std::string> fields = absl::StrSplit(lines[i], ',');
      for (std::size_t c = 0; c < names.size(); ++c) {
        if (names[c] != "y1" && names[c] != "y2") continue;
        double value = 0.0;
        ASSERT_TRUE(absl::SimpleAtod(fields[c], &value));
        const double size = 0.5 + 0.125 * static_cast<double>((i * 7 + c) % 8);
        fields[c] = absl::StrCat(value + side * size);
      }
      lines[i] = absl::StrJoin(fields, ",");
      ++spoilt;
    }
  }
  for (const char* const estimator :
       {"--estimator=structured", "--estimator=arx"}) {
    SCOPED_TRACE(estimator);
    const std::vector<std::string> flags = {estimator,
                                            "--conversion_samples=20000"};
    const nlohmann::json clean = Example(WithHalvedGain()).Run(flags);
    EXPECT_FALSE(clean["channels"][0].contains("outliers_by_model"));
    const std::string data = example.scratch.Write(
        "spoilt.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
    std::vector<std::string> all = flags;
    all.push_back("--truth=" + example.plant);
    const nlohmann::json result = Correct(
        CorrectionFlags(example.model, data, example.out, all), example.out);
    EXPECT_EQ(result["decision"], "corrected");
    for (int i = 0; i < 2; ++i) {
      const int found = result["channels"][i]["outliers"].get<int>() +
                        result["channels"][i]["outliers_by_model"].get<int>();
      EXPECT_GT(result["channels"][i]["outliers_by_model"], 0);
      // Some lie outside the windows.
      EXPECT_GT(found, spoilt / 2);
      EXPECT_LE(found, spoilt + 2);
    }
    EXPECT_LT(result["truth"]["E_corrected"],
              3.0 * clean["truth"]["E_corrected"].get<double>() +
                  1e-3 * clean["truth"]["E_initial"].get<double>());
  }
}

TEST(MleCorrectTest, ADisturbanceNeverMakesTheModelWorse) {
  // Steps of outputs that nobody measures, half as large as the set points'.
  for (const char* const seed : {"1", "2", "3", "4"}) {
    SCOPED_TRACE(seed);
    const Example example(Heater(), {"--disturbance_step_rate=0.02",
                                     "--disturbance_step_deviation=0.5",
                                     "--seed=" + std::string(seed)});
    const report::ProcessResult run =
        RunTested(CorrectionFlags(example.model, example.data, example.out,
                                  {"--truth=" + example.plant}));
    const nlohmann::json result = ParsedJson(example.out + "/result.json");
    EXPECT_NE(result["decision"], "corrected");
    EXPECT_EQ(result["truth"]["E_corrected"], 0.0);
    EXPECT_EQ(run.exit_code, result["decision"] == "refused" ? 1 : 0);
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
  const Example example(WithHalvedGain());
  const nlohmann::json result =
      example.Run({"--estimator=arx", "--conversion_samples=20000"});
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_GT(result["lambda_star"], 0.0);
  EXPECT_LE(result["certificate"]["max_relative_duality_gap"], 1e-6);
  EXPECT_LT(result["truth"]["E_corrected"],
            0.1 * result["truth"]["E_initial"].get<double>());
  const Example right{Heater()};
  const nlohmann::json kept =
      right.Run({"--estimator=arx", "--conversion_samples=20000"});
  EXPECT_EQ(kept["decision"], "no_change");
}

// Ceres solves what the path solves; a robust loss is another problem, near by
// where nothing is wrong with the records.
TEST(MleCorrectTest, SolversAgreeAndLossesAreTaken) {
  const Example example(WithHalvedGain());
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
TEST(MleCorrectTest, AnElementOfAnotherShapeIsCorrectedOrRefused) {
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
    EXPECT_LE(result["truth"]["E_corrected"].get<double>(),
              result["truth"]["E_initial"].get<double>());
  }
}

TEST(MleCorrectTest, TheResultDoesNotDependOnTheThreads) {
  const Example example(WithHalvedGain());
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
  const Example example(WithHalvedGain());
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
  const Example example(WithHalvedGain());
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
  const Example example(WithHalvedGain(), {"--lost_probability=0.3"});
  example.Run();
  for (const char* const file :
       {"result.json", "arx.json", "fopdt.json", "step_response.csv"}) {
    const std::string content = Content(example.out + "/" + file);
    EXPECT_THAT(content, Not(HasSubstr("nan"))) << file;
    EXPECT_THAT(content, Not(HasSubstr("inf,"))) << file;
  }
}

TEST(MleCorrectTest, HelpNamesEveryFlagWithItsDefault) {
  const report::ProcessResult run = RunTested({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* const flag :
       {"--model []", "--data []", "--out [correction]",
        "--estimator [combined]", "--dry_run [false]", "--threads [0]",
        "--window_before [0]", "--false_alarm_probability", "--max_gap"}) {
    EXPECT_THAT(run.out, HasSubstr(flag));
  }
}

}  // namespace
}  // namespace mle
