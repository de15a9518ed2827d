// mle_convert as its users call it.

#include <cmath>
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

using ::testing::AllOf;
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

// Gains at a point are those times the slope of the valve there; forms that
// have transforms keep them, others are linear at its operating point.
TEST(MleConvertTest, AModelWithTransformsIsLinearAtAPoint) {
  const ScratchFolder scratch;
  const std::string model = "--model=" + kConfigs + "bent_column.json";
  const std::string out = scratch / "model.json";
  const report::ProcessResult open =
      RunTested({model, "--at=reflux:95", "--out=" + out});
  EXPECT_EQ(open.exit_code, 0) << open.err;
  EXPECT_THAT(open.out, HasSubstr("relative to reflux = 45 its gains are × "
                                  "0.172 at 0 and × 8.6 at 100"));
  const absl::StatusOr<ModelFile> linear = ReadModelFile(out);
  ASSERT_TRUE(linear.ok()) << linear.status();
  EXPECT_FALSE(HasTransforms(linear->process));
  EXPECT_NEAR(linear->process.element(0, 0).StaticGain(),
              0.64 * std::sqrt(50.0), 1e-9);
  EXPECT_EQ(linear->process.element(0, 1).StaticGain(), -18.9);
  const std::string table = scratch / "model.csv";
  EXPECT_EQ(
      RunTested({model, "--form=element_table", "--out=" + table}).exit_code,
      0);
  const absl::StatusOr<ModelFile> kept = ReadModelFile(table);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->process.inputs()[0].transform.rangeability, 50.0);
  const report::ProcessResult mat =
      RunTested({model, "--out=" + (scratch / "model.mat")});
  EXPECT_EQ(mat.exit_code, 0) << mat.err;
  EXPECT_THAT(mat.out, HasSubstr("a linear model at one point"));
  // A closed valve of this kind has no finite gain; a curve may end nearby.
  const std::string bent = scratch.Write("bent.json", R"({
      "name": "tank", "time_unit": "min",
      "inputs": [{"name": "u", "unit": "%", "transform":
          {"kind": "quick_opening", "closed": 0, "open": 100, "at": 25}}],
      "outputs": [{"name": "y", "unit": "", "transform":
          {"kind": "log", "zero": 9, "at": 10}}],
      "elements": [{"output": "y", "input": "u", "gain": 2, "time_constant": 8,
                    "delay": 3}]})");
  EXPECT_THAT(RunTested({"--model=" + bent, "--at=u:25", "--out=" + out}).out,
              AllOf(HasSubstr("u = 25 its gains are × 0.5 at 100\n"),
                    HasSubstr("y = 10 its gains are × 0.5 at 9.5 and × 1.5 at "
                              "10.5\n")));
  EXPECT_THAT(
      RunTested({model, "--at=reflex:95", "--out=" + out}).err,
      HasSubstr("there is no channel 'reflex'; did you mean 'reflux'?"));
  EXPECT_THAT(RunTested({"--model=" + kConfigs + "wood_berry.json",
                         "--at=reflux:1", "--out=" + out})
                  .err,
              HasSubstr("the model has no transforms"));
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
