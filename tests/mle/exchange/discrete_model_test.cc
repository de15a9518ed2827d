#include "mle/exchange/discrete_model.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/exchange/model_file.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr char kTank[] = R"({
  "name": "tank",
  "time_unit": "min",
  "inputs": [
    {"name": "steam", "unit": "t/h"},
    {"name": "feed", "unit": "t/h", "role": "disturbance"}
  ],
  "outputs": [
    {"name": "temperature", "unit": "degC"},
    {"name": "level", "unit": "%"}
  ],
  "sample_time": 0.5,
  "elements": [
    {"output": "temperature", "input": "steam", "numerator": [0.4], "denominator": [1, -0.9], "delay": 3},
    {"output": "level", "input": "feed", "numerator": [0.2, 0.1], "denominator": [2, -3, 1], "delay": 0}
  ]
}
)";

DiscreteModel Parsed(const std::string& text) {
  const absl::StatusOr<DiscreteModel> model =
      ParseDiscreteModel(text, "tank.json");
  EXPECT_TRUE(model.ok()) << model.status();
  return model.ok() ? *model : DiscreteModel();
}

TEST(DiscreteModel, ComesBackAsItWas) {
  EXPECT_EQ(FormatDiscreteModel(Parsed(kTank)), kTank);
}

// 0.4 z⁻⁴ / (1 − 0.9 z⁻¹), and 0.1 z⁻¹ (1 + 0.5 z⁻¹) / ((1 − z⁻¹)(1 − 0.5
// z⁻¹)), whose ramp has the slope 0.1 · 1.5 / 0.5 a sample.
TEST(DiscreteModel, HasTheStepResponsesOfItsDifferenceEquations) {
  const absl::StatusOr<StepResponseModel> steps =
      StepResponsesOf(Parsed(kTank));
  ASSERT_TRUE(steps.ok()) << steps.status();
  ASSERT_EQ(steps->pairs.size(), 2U);
  EXPECT_EQ(steps->interval, 0.5);
  EXPECT_FALSE(steps->pairs[0].is_ramp);
  EXPECT_TRUE(steps->pairs[1].is_ramp);
  for (int k = 1; k <= 60; ++k) {
    const double lag = k < 4 ? 0.0 : 4.0 * (1.0 - std::pow(0.9, k - 3));
    EXPECT_NEAR(steps->pairs[0].coefficients(k - 1), lag, 1e-12) << k;
    // Of partial fractions: 0.3 k − 0.4 (1 − 0.5^k).
    EXPECT_NEAR(steps->pairs[1].coefficients(k - 1),
                0.3 * k - 0.4 * (1.0 - std::pow(0.5, k)), 1e-11)
        << k;
  }
}

TEST(DiscreteModel, WithoutAnyGainHasNoStepResponses) {
  const DiscreteModel still = Parsed(absl::StrReplaceAll(
      kTank,
      {{"[0.4]", "[0]"}, {"[0.2, 0.1]", "[0, 0]"}, {"[2, -3, 1]", "[2, -1]"}}));
  EXPECT_THAT(std::string(StepResponsesOf(still).status().message()),
              HasSubstr("no input moves an output"));
}

TEST(DiscreteModel, TakesPowersOfInverseZ) {
  const std::string inverse = absl::StrReplaceAll(
      kTank, {{"0.5,\n", "0.5,\n  \"variable\": \"z^-1\",\n"},
              {"[0.4]", "[0, 0.4]"},
              {"[0.2, 0.1]", "[0, 0.2, 0.1]"}});
  const DiscreteModel model = Parsed(inverse);
  EXPECT_EQ(FormatDiscreteModel(model), inverse);
  const absl::StatusOr<StepResponseModel> steps = StepResponsesOf(model);
  const absl::StatusOr<StepResponseModel> others =
      StepResponsesOf(Parsed(kTank));
  ASSERT_TRUE(steps.ok()) << steps.status();
  for (int pair = 0; pair < 2; ++pair) {
    EXPECT_TRUE(steps->pairs[pair].coefficients.isApprox(
        others->pairs[pair].coefficients.head(steps->length()), 1e-13));
  }
}

// Held inputs: exact at the samples, with dead times between them, lags,
// feedthrough and integrators.
TEST(DiscreteModel, DiscretizationIsExact) {
  constexpr double kSampleTime = 0.7;
  constexpr int kSamples = 80;
  for (const TransferFunction& g :
       {TransferFunction::FirstOrder(2.0, 5.0, 1.4),
        TransferFunction::FirstOrder(-3.0, 5.0, 1.0),
        TransferFunction({2.0}, {1.0}, 0.9),
        TransferFunction({1.0, 2.0}, {3.0, 1.0}, 0.3),
        TransferFunction({-2.0, 1.0}, {12.0, 7.0, 1.0}, 2.0),
        TransferFunction({1.0}, {4.0, 1.0, 1.0}, 0.1),
        TransferFunction::Integrator(0.3, 0.0, 1.0),
        TransferFunction::Integrator(0.3, 2.0, 1.4)}) {
    for (const DiscreteVariable variable :
         {DiscreteVariable::kZ, DiscreteVariable::kInverseZ}) {
      const absl::StatusOr<DiscreteElement> element =
          Discretized(g, kSampleTime, variable);
      ASSERT_TRUE(element.ok()) << element.status();
      DiscreteModel model;
      model.channels = ProcessModel("one", "min", {{"u", ""}}, {{"y", ""}});
      model.sample_time = kSampleTime;
      model.variable = variable;
      model.elements = {*element};
      const absl::StatusOr<StepResponseModel> steps = StepResponsesOf(model);
      ASSERT_TRUE(steps.ok()) << steps.status();
      EXPECT_EQ(steps->pairs[0].is_ramp, g.IsIntegrating());
      ASSERT_EQ(steps->interval, kSampleTime);
      const int length = std::min(kSamples, steps->length());
      const Eigen::VectorXd wanted =
          g.StepResponse(kSampleTime, length + 1).tail(length);
      EXPECT_LT((steps->pairs[0].coefficients.head(length) - wanted)
                    .cwiseAbs()
                    .maxCoeff(),
                1e-11)
          << g.denominator().size() << " " << g.delay();
    }
  }
}

TEST(DiscreteModel, KeepsTheNumbersOfElementsThatStay) {
  const absl::StatusOr<ModelFile> file = ParseModelFile(kTank, "tank.json");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->form, ModelForm::kDiscreteTransferFunctions);
  EXPECT_EQ(file->process.inputs()[1].role, InputRole::kDisturbance);
  for (const PairDescription& pair : file->descriptions) {
    EXPECT_LT(pair.largest_difference, 2e-3);
  }
  EXPECT_EQ(FormatCorrected(*file, file->process)->text, kTank);
  // The gain of 4 halves.
  ProcessModel corrected = file->process;
  const TransferFunction& g = corrected.element(0, 0);
  corrected.element(0, 0) =
      TransferFunction({0.5 * g.numerator()[0]}, g.denominator(), g.delay());
  const absl::StatusOr<FormattedModel> text = FormatCorrected(*file, corrected);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(text->name, "model_corrected.json");
  const DiscreteModel changed = Parsed(text->text);
  EXPECT_EQ(changed.elements[1].numerator,
            file->discrete.elements[1].numerator);
  EXPECT_EQ(changed.elements[1].denominator,
            file->discrete.elements[1].denominator);
  const absl::StatusOr<StepResponseModel> steps = StepResponsesOf(changed);
  EXPECT_NEAR(steps->pairs[0].coefficients(40),
              0.5 * file->step_responses.pairs[0].coefficients(40), 1e-5);
}

TEST(DiscreteModel, SaysWhatIsWrong) {
  const std::vector<
      std::pair<std::pair<std::string, std::string>, std::vector<std::string>>>
      mistakes = {
          {{"[1, -0.9]", "[1, -1.1]"},
           {"temperature ← steam", "magnitude 1.1"}},
          {{"[1, -0.9]", "[0, -0.9]"}, {"begins with 0"}},
          {{"[1, -0.9], \"delay\": 3", "[-0.9], \"delay\": 0"},
           {"temperature ← steam", "within the same sample", "delay"}},
          {{"[0.4]", "[0.4, 1, 2]"}, {"elements[0]", "3 coefficients", "z^-1"}},
          {{"\"delay\": 3", "\"delay\": 1.5"}, {"elements[0].delay", "whole"}},
          {{"[2, -3, 1]", "[1, -2, 1]"}, {"level ← feed", "magnitude 1"}},
          {{"[0.2, 0.1]", "[0.2, -0.2]"}, {"level ← feed", "common factor"}},
          {{"0.5,\n", "0.5,\n  \"variable\": \"q\",\n"}, {"variable", "\"q\""}},
          {{"\"level\", \"input\": \"feed\"",
            "\"temperature\", \"input\": \"steam\""},
           {"is duplicated"}},
          {{"0.5,\n", "-0.5,\n"}, {"sample_time"}},
          {{"[1, -0.9]", "[1, -0.999999]"}, {"slowest mode", "sample time"}},
      };
  for (const auto& [change, named] : mistakes) {
    const std::string text =
        absl::StrReplaceAll(kTank, {{change.first, change.second}});
    ASSERT_NE(text, kTank) << change.first;
    const absl::StatusOr<ModelFile> file = ParseModelFile(text, "tank.json");
    ASSERT_FALSE(file.ok()) << change.second;
    const std::string message(file.status().message());
    EXPECT_THAT(message, HasSubstr("tank.json"));
    for (const std::string& name : named) {
      EXPECT_THAT(message, HasSubstr(name));
    }
  }
}

}  // namespace
}  // namespace mle
