#include "mle/correction/pair_information.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<NoiseEstimate> Noise(double variance, double ratio = 0.0) {
  NoiseEstimate noise;
  noise.variance = variance;
  noise.ratio = ratio;
  return {noise};
}

PairInformation Assess(const std::vector<Record>& windows, double variance,
                       double ratio = 0.0) {
  const auto information =
      AssessInformation(TwoElements(), windows, Noise(variance, ratio), {});
  EXPECT_TRUE(information.ok()) << information.status();
  return information.ok() ? *information : PairInformation();
}

std::vector<Record> InformedWindows() {
  return MakeRecords(TwoElements(), 600, 1, {.variance = 0.01});
}

TEST(PairInformationTest, InputsThatMoveInform) {
  const PairInformation information = Assess(InformedWindows(), 0.01);
  for (int j = 0; j < 2; ++j) {
    EXPECT_EQ(information.pair(0, j).state, PairState::kInformed);
    EXPECT_LT(information.pair(0, j).gain, 0.05);
    EXPECT_GT(information.pair(0, j).gain, 1e-4);
    EXPECT_GE(information.pair(0, j).inflation, 1.0);
    EXPECT_LT(information.pair(0, j).inflation, 2.0);
    EXPECT_GT(information.inputs[j].moves, 5);
  }
  EXPECT_LT(std::abs(information.input_correlation(0, 1)), 0.5);
  EXPECT_THAT(information.inputs_to_test(), IsEmpty());
}

// The limit of the errors is what a fit reaches.
TEST(PairInformationTest, ErrorsAreThoseOfTheFit) {
  const auto correction = CorrectByOutputError(
      TwoElements(), InformedWindows(), {.offsets = WindowOffsets::kAlways});
  ASSERT_TRUE(correction.ok());
  const PairInformation information =
      Assess(InformedWindows(), correction->full.noise[0].variance,
             correction->full.noise[0].ratio);
  for (int j = 0; j < 2; ++j) {
    const ElementEstimate& element = correction->full.element(0, j);
    EXPECT_NEAR(information.pair(0, j).gain * std::abs(element.gain.initial),
                element.gain.standard_error, 0.1 * element.gain.standard_error);
    EXPECT_NEAR(information.pair(0, j).delay, element.delay.standard_error,
                0.3 * element.delay.standard_error);
  }
}

TEST(PairInformationTest, ErrorsGoWithTheNoise) {
  const PairInformation one = Assess(InformedWindows(), 0.01);
  const PairInformation four = Assess(InformedWindows(), 0.04);
  const PairInformation drift = Assess(InformedWindows(), 0.01, 0.1);
  for (int j = 0; j < 2; ++j) {
    EXPECT_NEAR(four.pair(0, j).gain / one.pair(0, j).gain, 2.0, 1e-6);
    EXPECT_NEAR(four.pair(0, j).inflation, one.pair(0, j).inflation, 1e-6);
    EXPECT_GT(drift.pair(0, j).gain, one.pair(0, j).gain);
  }
  EXPECT_EQ(Assess(InformedWindows(), 1000.0).pair(0, 0).state,
            PairState::kNotInformed);
}

TEST(PairInformationTest, AnInputThatDoesNotMoveInformsOfNothing) {
  std::vector<Record> windows = InformedWindows();
  for (Record& window : windows) window.inputs.row(1).setConstant(3.0);
  const PairInformation information = Assess(windows, 0.01);
  EXPECT_EQ(information.pair(0, 0).state, PairState::kInformed);
  EXPECT_EQ(information.pair(0, 1).state, PairState::kNotInformed);
  EXPECT_TRUE(std::isinf(information.pair(0, 1).gain));
  EXPECT_EQ(information.inputs[1].moves, 0);
  EXPECT_EQ(information.input_correlation(0, 1), 0.0);
  EXPECT_THAT(information.inputs_to_test(), ElementsAre(1));
}

// A second input that repeats the first one, nearly, blurs both.
TEST(PairInformationTest, InputsThatMoveTogetherInflateTheErrors) {
  std::vector<Record> windows = InformedWindows();
  const double apart = Assess(windows, 0.01).pair(0, 0).gain;
  for (Record& window : windows) {
    window.inputs.row(1) =
        0.5 * window.inputs.row(0) + 0.01 * window.inputs.row(1);
  }
  const PairInformation information = Assess(windows, 0.01);
  EXPECT_GT(information.pair(0, 0).gain, 3.0 * apart);
  EXPECT_GT(information.pair(0, 0).inflation, 3.0);
  EXPECT_GT(information.input_correlation(0, 1), 0.99);
}

// Units of inputs and outputs cancel.
TEST(PairInformationTest, DoesNotDependOnUnits) {
  const PairInformation one = Assess(InformedWindows(), 0.01);
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(200.0, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3000.0, 6.0, 2.3);
  std::vector<Record> windows = InformedWindows();
  for (Record& window : windows) {
    window.outputs *= 100.0;
    window.inputs.row(1) *= 0.1;
  }
  const auto other = AssessInformation(model, windows, Noise(100.0), {});
  ASSERT_TRUE(other.ok()) << other.status();
  for (int j = 0; j < 2; ++j) {
    EXPECT_NEAR(other->pair(0, j).gain, one.pair(0, j).gain, 1e-9);
    EXPECT_NEAR(other->pair(0, j).delay, one.pair(0, j).delay, 1e-9);
  }
}

TEST(PairInformationTest, OptionsAreChecked) {
  const auto status =
      AssessInformation(TwoElements(), InformedWindows(), Noise(0.01),
                        {.informed = 0.5, .weak = 0.1})
          .status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("informed is 0.5"));
  EXPECT_FALSE(
      AssessInformation(TwoElements(), InformedWindows(), {}, {}).ok());
}

}  // namespace
}  // namespace mle
