// mle_convert as its users call it.

#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/substitute.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/exchange/model_file.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

const std::string kConfigs = MLE_SOURCE_FOLDER "/configs/";

TEST(MleConvertTest, WritesEveryFormAndItsError) {
  const ScratchFolder scratch;
  for (const auto& [form, ending] :
       std::vector<std::pair<std::string, std::string>>{
           {"transfer_functions", "json"},
           {"transfer_functions", "mat"},
           {"element_table", "csv"},
           {"step_responses", "csv"},
           {"step_responses", "json"},
           {"step_responses", "mat"},
           {"discrete_transfer_functions", "json"},
           {"state_space", "json"}}) {
    const std::string out = scratch / ("model." + ending);
    const report::ProcessResult run =
        RunTested({"--model=" + kConfigs + "shapes.json", "--form=" + form,
                   "--out=" + out, "--interval=0.5"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr(out + ": " + form));
    EXPECT_THAT(run.out,
                HasSubstr(form == "element_table" ? "pressure ← steam: 20 %"
                                                  : "step responses"));
    const absl::StatusOr<ModelFile> file = ReadModelFile(out);
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(NameOf(file->form), form);
  }
  // The form stays where none is named.
  const report::ProcessResult run =
      RunTested({"--model=" + kConfigs + "wood_berry.csv",
                 "--out=" + (scratch / "steps.mat")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("those of the model given"));
}

TEST(MleConvertTest, SaysTheIntervalWithItsUnit) {
  const ScratchFolder scratch;
  for (const auto& [unit, said] :
       std::vector<std::pair<std::string, std::string>>{
           {"min", "step_responses, every 0.5 min;"},
           {"", "step_responses, every 0.5;"}}) {
    const std::string model =
        scratch.Write("unit.json", absl::Substitute(R"({
        "name": "tank", "time_unit": "$0", "inputs": [{"name": "u", "unit": ""}],
        "outputs": [{"name": "y", "unit": ""}], "elements": [{"output": "y", "input": "u",
        "gain": 2, "time_constant": 8, "delay": 3}]})",
                                                    unit));
    const report::ProcessResult run = RunTested(
        {"--model=" + model, "--interval=0.5", "--form=step_responses",
         "--out=" + (scratch / "steps.mat")});
    EXPECT_THAT(run.out, HasSubstr(said)) << run.err;
  }
}

TEST(MleConvertTest, RefusesWhatItCannotWrite) {
  const ScratchFolder scratch;
  const std::string model = "--model=" + kConfigs + "shapes.json";
  const std::string out = scratch / "model.json";
  for (const auto& [flags, named] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{model}, "--out=FILE"},
           {{model, "--form=fir", "--out=" + out}, "--form=fir"},
           {{model, "--out=model.xls"}, "--out=model.xls: must end with"},
           {{model, "--form=element_table", "--out=" + out},
            "--form=element_table: a file of this type"},
           {{model, "--form=step_responses", "--coefficients=3",
             "--out=" + out},
            "--coefficients=3"},
           {{"--model=/no/such.json", "--out=" + out}, "/no/such.json"},
           {{model, "--out=/no/such/model.json"}, "--out: "}}) {
    const report::ProcessResult run = RunTested(flags);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_THAT(run.err, HasSubstr(named));
    EXPECT_FALSE(std::filesystem::exists(out));
  }
  // Rounding is larger than this.
  const report::ProcessResult run = RunTested(
      {model, "--form=state_space", "--tolerance=1e-17", "--out=" + out});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace mle
