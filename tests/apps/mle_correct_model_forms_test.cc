// mle_correct with models in the forms that plants have them.

#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/exchange/mat_file.h"
#include "mle/exchange/model_file.h"
#include "mle/model/balanced_reduction.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kInterval = 1.0;
constexpr int kLength = 40;

ProcessModel ModelOf(const Heater& heater) {
  return *ParseProcessModel(HeaterJson(heater), "heater");
}

// The coefficients of the model, the pair (0, 0) last.
StepResponseModel StepResponses(const ProcessModel& model) {
  StepResponseModel sampled;
  sampled.channels = ProcessModel(model.name(), model.time_unit(),
                                  model.inputs(), model.outputs());
  sampled.interval = kInterval;
  for (const auto& [i, j] :
       std::vector<std::pair<int, int>>{{1, 1}, {1, 0}, {0, 1}, {0, 0}}) {
    sampled.pairs.push_back(
        {i, j,
         model.element(i, j).StepResponse(kInterval, kLength + 1).tail(kLength),
         false});
  }
  return sampled;
}

StepResponseModel ReadSteps(const std::string& path) {
  const absl::StatusOr<StepResponseModel> model = ReadStepResponseModel(path);
  EXPECT_TRUE(model.ok()) << model.status();
  return model.ok() ? *model : StepResponseModel();
}

// A record of a plant whose first gain has halved, and the model that its
// controller has, in another form.
class MleCorrectModelForms : public ::testing::Test {
 protected:
  MleCorrectModelForms() : example_(WithHalvedGain()) {}

  nlohmann::json Run(const std::string& model, int exit_code = 0) const {
    return Correct(CorrectionFlags(model, example_.data, example_.out,
                                   {"--truth=" + example_.plant}),
                   example_.out, exit_code);
  }
  void ExpectRefused(const std::string& model,
                     const std::vector<std::string>& named) const {
    const report::ProcessResult result =
        RunTested(CorrectionFlags(model, example_.data, example_.out));
    EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
    for (const std::string& name : named) {
      EXPECT_THAT(result.err, HasSubstr(name));
    }
  }

  const HeaterExample example_;
};

TEST_F(MleCorrectModelForms, StepResponsesAreCorrected) {
  const StepResponseModel given = StepResponses(ModelOf(Heater()));
  const std::string model =
      example_.scratch.Write("heater.csv", FormatStepResponseCsv(given));
  const nlohmann::json result = Run(model);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["given_model"]["form"], "step_responses");
  EXPECT_EQ(result["given_model"]["corrected"], "model_corrected.csv");
  ASSERT_EQ(result["given_model"]["descriptions"].size(), 4U);
  for (const auto& pair : result["given_model"]["descriptions"]) {
    EXPECT_LT(pair["largest_difference"], 1e-3);
  }
  const StepResponseModel truth = StepResponses(ModelOf(WithHalvedGain()));
  const StepResponseModel corrected =
      ReadSteps(example_.out + "/model_corrected.csv");
  EXPECT_EQ(corrected.interval, given.interval);
  ASSERT_EQ(corrected.pairs.size(), 4U);
  for (int p = 0; p < 4; ++p) {
    EXPECT_EQ(corrected.pairs[p].output, given.pairs[p].output);
    EXPECT_EQ(corrected.pairs[p].input, given.pairs[p].input);
    ASSERT_EQ(corrected.length(), given.length());
    if (p == 3) {
      // Its gain of 1 has a standard error below 0.02 in this record.
      EXPECT_LT((corrected.pairs[p].coefficients - truth.pairs[p].coefficients)
                    .cwiseAbs()
                    .maxCoeff(),
                0.1);
    } else {
      EXPECT_EQ(corrected.pairs[p].coefficients, given.pairs[p].coefficients);
    }
  }
  // It is the next model; with transfer functions none is left behind.
  EXPECT_EQ(Run(example_.out + "/model_corrected.csv")["decision"],
            "no_change");
  Run(example_.model);
  EXPECT_FALSE(
      ReadStepResponseModel(example_.out + "/model_corrected.csv").ok());
}

TEST_F(MleCorrectModelForms, StepResponsesOfJsonComeBackAsJson) {
  const StepResponseModel given = StepResponses(ModelOf(WithHalvedGain()));
  const std::string model =
      example_.scratch.Write("heater.json", FormatStepResponseJson(given));
  EXPECT_EQ(Run(model)["decision"], "no_change");
  EXPECT_EQ(Content(example_.out + "/model_corrected.json"), Content(model));
}

TEST_F(MleCorrectModelForms, NamesWhatIsWrongWithStepResponses) {
  const std::string text =
      FormatStepResponseCsv(StepResponses(ModelOf(Heater())));
  const std::string ragged = example_.scratch.Write(
      "ragged.csv", absl::StrReplaceAll(text, {{"\n7,", "\n7,1,"}}));
  ExpectRefused(ragged, {"--model", ragged, "line 16", "fields"});
  StepResponseModel bent = StepResponses(ModelOf(Heater()));
  for (int k = 0; k < kLength; ++k) {
    bent.pairs[1].coefficients(k) *= k % 7 < 3 ? 1.0 : -0.5;
  }
  const std::string poor =
      example_.scratch.Write("poor.csv", FormatStepResponseCsv(bent));
  ExpectRefused(poor, {"--model", poor, "y2 ← u1", "% of its range at"});
  StepResponseModel flat = StepResponses(ModelOf(Heater()));
  flat.pairs[1].coefficients.setOnes();
  flat.pairs[1].is_ramp = true;
  const std::string ramp =
      example_.scratch.Write("ramp.csv", FormatStepResponseCsv(flat));
  ExpectRefused(ramp, {"--model", "y2 ← u1", "ramp without a slope"});
}

TEST_F(MleCorrectModelForms, TablesOfElementsAreCorrected) {
  const std::string head =
      "name,heater\ntime unit,min\ninput,u1,%\ninput,u2,%\noutput,y1,K\n"
      "output,y2,K\noutput,input,gain,time constant,dead time\n";
  const std::string unchanged =
      "y2,u2,1.5,5,2.5\ny2,u1,0.7,4,1.5\ny1,u2,-0.8,6,2\n";
  const std::string model =
      example_.scratch.Write("table.csv", head + unchanged + "y1,u1,2,5,1\n");
  const nlohmann::json result = Run(model);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["given_model"]["form"], "element_table");
  const std::string path = example_.out + "/model_corrected.csv";
  const std::string text = Content(path);
  EXPECT_THAT(text, HasSubstr(head + unchanged + "y1,u1,"));
  const absl::StatusOr<ElementTable> corrected = ParseElementTable(text, path);
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  // The gain of 1 has a standard error below 0.02 in this record.
  EXPECT_NEAR(corrected->rows[3].gain, 1.0, 0.1);
  const absl::StatusOr<ProcessModel> other =
      ReadProcessModel(example_.out + "/model.json");
  ASSERT_TRUE(other.ok()) << other.status();
  // With five digits, as it is typed.
  EXPECT_NEAR(corrected->rows[3].gain, other->element(0, 0).StaticGain(), 5e-5);
  const std::string kept = example_.scratch.Write("kept.csv", text);
  EXPECT_EQ(Run(kept)["decision"], "no_change");
  const std::string twice =
      example_.scratch.Write("twice.csv", head + unchanged + "y1,u2,2,5,1\n");
  ExpectRefused(twice, {"--model", twice, "line 11", "y1 ← u2"});
}

// Discrete forms: the pairs that have not changed keep their numbers, or, of a
// state space, their responses.
TEST_F(MleCorrectModelForms, DiscreteTransferFunctionsAreCorrected) {
  const ProcessModel heater = ModelOf(Heater());
  DiscreteModel given;
  given.channels = ProcessModel(heater.name(), heater.time_unit(),
                                heater.inputs(), heater.outputs());
  given.sample_time = 0.5;
  given.variable = DiscreteVariable::kInverseZ;
  for (const auto& [i, j] :
       std::vector<std::pair<int, int>>{{1, 1}, {1, 0}, {0, 1}, {0, 0}}) {
    given.elements.push_back(
        *Discretized(heater.element(i, j), 0.5, given.variable));
    given.elements.back().output = i;
    given.elements.back().input = j;
  }
  const nlohmann::json result =
      Run(example_.scratch.Write("z.json", FormatDiscreteModel(given)));
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["given_model"]["form"], "discrete_transfer_functions");
  EXPECT_EQ(result["given_model"]["corrected"], "model_corrected.json");
  for (const auto& pair : result["given_model"]["descriptions"]) {
    EXPECT_LT(pair["largest_difference"], 1e-6);
  }
  const std::string path = example_.out + "/model_corrected.json";
  const auto corrected = ParseDiscreteModel(Content(path), path);
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  ASSERT_EQ(corrected->elements.size(), 4U);
  for (int e = 0; e < 3; ++e) {
    EXPECT_EQ(corrected->elements[e].numerator, given.elements[e].numerator);
    EXPECT_EQ(corrected->elements[e].denominator,
              given.elements[e].denominator);
  }
  const auto steps = StepResponsesOf(*corrected);
  ASSERT_TRUE(steps.ok()) << steps.status();
  // The gain of 1 has a standard error below 0.02 in this record.
  EXPECT_NEAR(steps->pairs.front().coefficients.tail(1)(0), 1.0, 0.1);
  const std::string kept = example_.scratch.Write("kept.json", Content(path));
  EXPECT_EQ(Run(kept)["decision"], "no_change");
}

TEST_F(MleCorrectModelForms, StateSpacesAreCorrected) {
  const ProcessModel heater = ModelOf(Heater());
  NamedStateSpace given;
  given.SetChannels(heater);
  given.system = ReduceModel(heater, 0.5, {})->system;
  const nlohmann::json result =
      Run(example_.scratch.Write("ss.json", FormatStateSpace(given)));
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["given_model"]["form"], "state_space");
  const std::string path = example_.out + "/model_corrected.json";
  const auto corrected = ReadStateSpace(path);
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  const StepResponse before = given.system.ComputeStepResponse(200);
  const StepResponse after = corrected->system.ComputeStepResponse(200);
  for (const auto& [i, j] :
       std::vector<std::pair<int, int>>{{1, 1}, {1, 0}, {0, 1}}) {
    EXPECT_LT((after.element(i, j) - before.element(i, j)).norm(), 1e-9);
  }
  EXPECT_NEAR(after.element(0, 0)(199), 1.0, 0.1);
  const std::string kept = example_.scratch.Write("kept.json", Content(path));
  EXPECT_EQ(Run(kept)["decision"], "no_change");
}

// model.mat is model.json, and the next model.
TEST_F(MleCorrectModelForms, MatFilesGoInAndOut) {
  EXPECT_EQ(Run(example_.model)["decision"], "corrected");
  const absl::StatusOr<ModelFile> mat =
      ReadModelFile(example_.out + "/model.mat");
  const absl::StatusOr<ProcessModel> written =
      ReadProcessModel(example_.out + "/model.json");
  ASSERT_TRUE(mat.ok()) << mat.status();
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_TRUE(CheckSameChannels(mat->process, "mat", *written, "json").ok());
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      EXPECT_EQ(mat->process.element(i, j).numerator(),
                written->element(i, j).numerator());
      EXPECT_EQ(mat->process.element(i, j).delay(),
                written->element(i, j).delay());
    }
  }
  const std::string kept =
      example_.scratch.Write("kept.mat", Content(example_.out + "/model.mat"));
  EXPECT_EQ(Run(kept)["decision"], "no_change");
  const std::string steps = example_.scratch.Write(
      "steps.mat", *FormatMat(StepResponses(ModelOf(WithHalvedGain()))));
  EXPECT_EQ(Run(steps)["given_model"]["corrected"], "model_corrected.mat");
  EXPECT_EQ(Content(example_.out + "/model_corrected.mat"), Content(steps));
}

// Noise of the coefficients is told, on standard error and in the result.
TEST_F(MleCorrectModelForms, TellsPoorDescriptions) {
  StepResponseModel noisy = StepResponses(ModelOf(Heater()));
  for (int k = 0; k < kLength; ++k) {
    noisy.pairs[3].coefficients(k) += k % 2 == 0 ? 0.04 : -0.04;
  }
  const std::string model =
      example_.scratch.Write("noisy.csv", FormatStepResponseCsv(noisy));
  const report::ProcessResult result = RunTested(
      CorrectionFlags(model, example_.data, example_.out, {"--dry_run"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("y1 ← u1: "));
}

}  // namespace
}  // namespace mle
