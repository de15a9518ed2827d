#include "mle/exchange/state_space_correction.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/exchange/model_file.h"
#include "mle/model/balanced_reduction.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kSampleTime = 0.5;
constexpr int kSamples = 200;

ProcessModel StateSpaceTank() {
  ProcessModel tank("tank", "min", {{"a", "t/h"}, {"b", "%"}},
                    {{"c", "K"}, {"d", "bar"}});
  tank.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 3.0);
  tank.element(0, 1) = TransferFunction({-1.0}, {12.0, 7.0, 1.0}, 4.25);
  tank.element(1, 0) = TransferFunction::FirstOrder(0.5, 8.0, 3.5);
  tank.element(1, 1) = TransferFunction::FirstOrder(4.0, 3.0, 5.0);
  return tank;
}

DiscreteStateSpace Reduced(const ProcessModel& model) {
  ReductionOptions options;
  options.tolerance = 1e-6;
  const absl::StatusOr<ReducedModel> reduced =
      ReduceModel(model, kSampleTime, options);
  EXPECT_TRUE(reduced.ok()) << reduced.status();
  return reduced->system;
}

double LargestDifference(const DiscreteStateSpace& system,
                         const ProcessModel& model) {
  const StepResponse found = system.ComputeStepResponse(kSamples);
  const StepResponse wanted = model.ComputeStepResponse(kSampleTime, kSamples);
  double largest = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      largest = std::max(
          largest,
          (found.element(i, j) - wanted.element(i, j)).cwiseAbs().maxCoeff());
    }
  }
  return largest;
}

// Gains, lags and dead times that are longer, shorter than what the model
// takes out of its inputs and outputs, and not a whole number of samples.
TEST(StateSpaceCorrection, HasTheStepResponsesOfTheCorrectedModel) {
  const ProcessModel before = StateSpaceTank();
  const DiscreteStateSpace given = Reduced(before);
  EXPECT_LT(LargestDifference(given, before), 1e-4);
  ASSERT_GT(given.input_delays[1] + given.output_delays[0], 2);
  ProcessModel after = before;
  after.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 3.0);
  for (const auto& [i, j, g] :
       {std::tuple(0, 0, TransferFunction::FirstOrder(1.0, 5.0, 3.0)),
        std::tuple(1, 1, TransferFunction::FirstOrder(4.0, 3.0, 9.3)),
        std::tuple(0, 1, TransferFunction::FirstOrder(-1.0, 6.0, 0.2)),
        std::tuple(0, 0, TransferFunction::FirstOrder(2.0, 9.0, 0.0)),
        std::tuple(1, 0, TransferFunction()),
        std::tuple(1, 1, TransferFunction({4.0}, {1.0}, 1.0))}) {
    after.element(i, j) = g;
    const absl::StatusOr<DiscreteStateSpace> changed =
        WithChange(given, before, after);
    ASSERT_TRUE(changed.ok()) << changed.status();
    EXPECT_TRUE(changed->Validate().ok()) << changed->Validate();
    EXPECT_LT(LargestDifference(*changed, after), 1e-4) << i << j;
    EXPECT_EQ(changed->A.topLeftCorner(given.order(), given.order()), given.A);
  }
}

TEST(StateSpaceCorrection, AChangedGainTakesTheStatesOfItsElement) {
  const ProcessModel before = StateSpaceTank();
  ProcessModel after = before;
  after.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 3.0);
  const DiscreteStateSpace given = Reduced(before);
  const int left = 6 - given.input_delays[0] - given.output_delays[0];
  const absl::StatusOr<DiscreteStateSpace> changed =
      WithChange(given, before, after);
  ASSERT_TRUE(changed.ok()) << changed.status();
  EXPECT_EQ(changed->order(), given.order() + 1 + std::max(left, 0));
  // Nothing changed is the same model.
  EXPECT_EQ(WithChange(given, before, before)->A, given.A);
}

// From file to file: names, units and roles stay.
TEST(StateSpaceCorrection, OfAFile) {
  NamedStateSpace named;
  ProcessModel tank = StateSpaceTank();
  named.SetChannels(tank);
  named.disturbances = {"b"};
  named.system = Reduced(tank);
  named.accuracy = StateSpaceAccuracy{{0.1, 0.1}, {0.1, 0.1}};
  const std::string text = FormatStateSpace(named);
  const absl::StatusOr<ModelFile> file = ParseModelFile(text, "tank.json");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->form, ModelForm::kStateSpace);
  EXPECT_EQ(file->process.inputs()[1].role, InputRole::kDisturbance);
  EXPECT_EQ(file->process.inputs()[1].unit, "%");
  EXPECT_EQ(FormatCorrected(*file, file->process)->text, text);
  ProcessModel corrected = file->process;
  corrected.element(1, 1) = TransferFunction::FirstOrder(2.0, 3.0, 5.0);
  const absl::StatusOr<FormattedModel> formatted =
      FormatCorrected(*file, corrected);
  ASSERT_TRUE(formatted.ok()) << formatted.status();
  const absl::StatusOr<NamedStateSpace> changed =
      ParseStateSpace(formatted->text, "tank.json");
  ASSERT_TRUE(changed.ok()) << changed.status();
  EXPECT_FALSE(changed->accuracy.has_value());
  tank.element(1, 1) = corrected.element(1, 1);
  EXPECT_LT(LargestDifference(changed->system, tank), 5e-3);
}

TEST(StateSpaceCorrection, ArxModelsAreNamed) {
  EXPECT_THAT(std::string(ParseModelFile(R"({"R": [[1]], "sample_time": 1})",
                                         "arx.json")
                              .status()
                              .message()),
              HasSubstr("model.json"));
}

}  // namespace
}  // namespace mle
