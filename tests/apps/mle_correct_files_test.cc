// The files that mle_correct writes: they agree with each other, hold what they
// say and nothing else.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/folder_lock.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"
#include "mle/model/step_response.h"
#include "tests/apps/correct_runs.h"
#include "tests/apps/started_command.h"

namespace mle {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(MleCorrectFiles, TheFilesAgreeWithEachOther) {
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

TEST(MleCorrectFiles, TheStateSpaceModelHasTheStepResponsesOfTheProcessModel) {
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

TEST(MleCorrectFiles, TheArxModelHasTheStepResponsesOfTheProcessModel) {
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

TEST(MleCorrectFiles, TheDryRunWritesNothing) {
  const HeaterExample example(WithHalvedGain());
  const report::ProcessResult run = RunTested(
      CorrectionFlags(example.model, example.data, example.out, {"--dry_run"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Windows around set-point changes"));
  EXPECT_THAT(run.out, HasSubstr("y2 0 → 1"));
  // Each element with what may be expected of it.
  EXPECT_THAT(run.out, ContainsRegex("y2 ← u1 .* informed"));
  EXPECT_THAT(run.out, HasSubstr("Inputs answer to y1, y2"));
  EXPECT_THAT(run.err, ContainsRegex("at most [0-9]+ MiB of memory were used"));
  EXPECT_FALSE(std::filesystem::exists(example.out));
}

TEST(MleCorrectFiles, AnInterruptedRunLeavesNoFolder) {
  const HeaterExample example(WithHalvedGain());
  const auto stop = [&](const std::string& out) {
    const std::string log = out + ".log";
    StartedCommand command(
        MLE_TESTED_COMMAND,
        CorrectionFlags(example.model, example.data, out,
                        {"--estimator=arx", "--conversion_samples=1000000"}),
        log);
    command.Await([&] {
      return std::filesystem::exists(out) && !FolderLock::Take(out).ok();
    });
    command.Send(SIGINT);
    EXPECT_EQ(command.ExitCode(), 1);
    return Content(log);
  };
  const std::string fresh = example.scratch / "fresh";
  EXPECT_THAT(stop(fresh), HasSubstr("stopped: nothing was written\n"));
  EXPECT_FALSE(std::filesystem::exists(fresh));
  // What was there before stays.
  const std::string old = example.scratch / "old";
  std::filesystem::create_directory(old);
  EXPECT_THAT(stop(old), HasSubstr("are as they were"));
  EXPECT_TRUE(std::filesystem::exists(old));
}

TEST(MleCorrectFiles, NamesAreTextWhateverTheyHold) {
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

TEST(MleCorrectFiles, ChecksumsAndFlagsTieTheResultToItsInputs) {
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

TEST(MleCorrectFiles, NothingThatIsWrittenIsNotANumber) {
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

TEST(MleCorrectFiles, ARunIsComparedWithTheLast) {
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

TEST(MleCorrectFiles, JsonOnStandardOutputIsTheFileAndNothingElse) {
  const HeaterExample example(WithHalvedGain());
  const report::ProcessResult run = RunTested(CorrectionFlags(
      example.model, example.data, example.out, {"--json", "--verbose"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, Content(example.out + "/result.json"));
}

}  // namespace
}  // namespace mle
