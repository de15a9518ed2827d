#include "mle/exchange/description.h"

#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// The coefficients of `elements`, one for each input, on one output.
StepResponseModel ModelOf(const std::vector<TransferFunction>& elements,
                          double interval, int length) {
  std::vector<InputChannel> inputs;
  for (std::size_t j = 0; j < elements.size(); ++j) {
    inputs.push_back({"u" + std::to_string(j + 1), ""});
  }
  StepResponseModel model;
  model.channels = ProcessModel("test", "min", inputs, {{"y", ""}});
  model.interval = interval;
  for (std::size_t j = 0; j < elements.size(); ++j) {
    model.pairs.push_back(
        {0, static_cast<int>(j),
         elements[j].StepResponse(interval, length + 1).tail(length), false});
  }
  return model;
}

// The shapes that elements of low order have are found again. First-order
// elements with a dead time between samples keep their parameters.
TEST(Describe, FindsElementsAgain) {
  const StepResponseModel model = ModelOf(
      {TransferFunction::FirstOrder(12.8, 16.7, 1.3),
       TransferFunction({2.0}, {36.0, 4.8, 1.0}, 2.5),         // damping 0.4
       TransferFunction({-6.0, 1.0}, {50.0, 15.0, 1.0}, 3.0),  // inverse
       TransferFunction({0.5}, {1.0}, 4.0),                    // a jump
       TransferFunction({8.0}, {24.0, 50.0, 35.0, 10.0, 1.0}, 0.7)},
      1.0, 90);
  const absl::StatusOr<Description> description = Describe(model);
  ASSERT_TRUE(description.ok()) << description.status();
  const TransferFunction& first = description->process.element(0, 0);
  ASSERT_TRUE(first.IsFirstOrder());
  EXPECT_NEAR(first.StaticGain(), 12.8, 1e-6);
  EXPECT_NEAR(first.TimeConstant(), 16.7, 1e-5);
  EXPECT_NEAR(first.delay(), 1.3, 1e-5);
  EXPECT_EQ(description->process.element(0, 3).denominator().size(), 1U);
  ASSERT_EQ(description->pairs.size(), 5U);
  for (const PairDescription& pair : description->pairs) {
    // The stated difference is that of the element, and is unremarkable.
    const Eigen::VectorXd& wanted = model.pairs[pair.input].coefficients;
    const Eigen::VectorXd found =
        description->process.element(0, pair.input).StepResponse(1.0, 91);
    const double range =
        std::max(wanted.maxCoeff(), 0.0) - std::min(wanted.minCoeff(), 0.0);
    EXPECT_NEAR(pair.largest_difference,
                (found.tail(90) - wanted).cwiseAbs().maxCoeff() / range, 1e-12);
    // Lags of second order and five real lags come this near to four.
    EXPECT_LT(pair.largest_difference, pair.input < 4 ? 2e-3 : 5e-3);
    EXPECT_LE(pair.relative_rms, pair.largest_difference);
  }
}

// Coefficients of an identification have noise; the elements then are as near
// as the noise lets them.
TEST(Describe, StatesTheDifferenceOfNoisyCoefficients) {
  StepResponseModel model =
      ModelOf({TransferFunction::FirstOrder(4.0, 10.0, 2.0)}, 1.0, 60);
  for (int k = 0; k < 60; ++k) {
    model.pairs[0].coefficients(k) += 0.08 * std::sin(2.4 * k * k);
  }
  const absl::StatusOr<Description> description = Describe(model);
  ASSERT_TRUE(description.ok()) << description.status();
  EXPECT_GT(description->pairs[0].largest_difference, kUnremarkableDifference);
  EXPECT_LT(description->pairs[0].largest_difference, 0.03);
  EXPECT_NEAR(description->process.element(0, 0).StaticGain(), 4.0, 0.1);
}

TEST(Describe, RefusesWhatNoElementDescribes) {
  StepResponseModel model =
      ModelOf({TransferFunction::FirstOrder(4.0, 10.0, 2.0),
               TransferFunction::FirstOrder(2.0, 10.0, 2.0)},
              1.0, 60);
  for (int k = 0; k < 60; ++k) {
    model.pairs[1].coefficients(k) += 0.6 * std::sin(0.9 * k);
  }
  const std::string message(Describe(model).status().message());
  EXPECT_THAT(message, AllOf(HasSubstr("y ← u2: "), HasSubstr("5 %"),
                             HasSubstr(" min"), Not(HasSubstr("u1"))));
}

// In any unit, of outputs that hardly move and of those of any size.
TEST(Describe, DoesNotDependOnUnits) {
  const TransferFunction lag = TransferFunction::FirstOrder(4.0, 10.0, 2.0);
  const StepResponseModel model = ModelOf({lag}, 1.0, 60);
  for (const int exponent : {-1000, -300, 0, 300}) {
    StepResponseModel scaled = model;
    for (double& c : scaled.pairs[0].coefficients) c = std::ldexp(c, exponent);
    const absl::StatusOr<Description> description = Describe(scaled);
    ASSERT_TRUE(description.ok()) << description.status();
    const TransferFunction& found = description->process.element(0, 0);
    EXPECT_NEAR(std::ldexp(found.StaticGain(), -exponent), 4.0, 1e-6);
    EXPECT_NEAR(found.TimeConstant(), 10.0, 1e-5);
  }
}

// Pairs that end in a ramp, in any unit, beside one that settles.
TEST(Describe, RampsAreIntegrators) {
  for (const double scale : {1.0, 1e-9}) {
    StepResponseModel model = ModelOf(
        {TransferFunction::Integrator(-0.4 * scale, 0.0, 0.6),
         TransferFunction::Integrator(0.3 * scale, 4.0, 1.3),
         // Two lags, and a lag that settles beside an integrator.
         TransferFunction({0.2 * scale}, {12.0, 7.0, 1.0, 0.0}, 2.0),
         TransferFunction({3.2 * scale, 0.2 * scale}, {4.0, 1.0, 0.0}, 1.0),
         TransferFunction::FirstOrder(4.0 * scale, 10.0, 2.0)},
        1.0, 60);
    for (int j = 0; j < 4; ++j) model.pairs[j].is_ramp = true;
    const absl::StatusOr<Description> description = Describe(model);
    ASSERT_TRUE(description.ok()) << description.status();
    const ProcessModel& found = description->process;
    EXPECT_TRUE(found.element(0, 0).IsIntegratorWithLag());
    EXPECT_EQ(found.element(0, 0).TimeConstant(), 0.0);
    EXPECT_NEAR(found.element(0, 0).StaticGain() / scale, -0.4, 1e-4);
    EXPECT_NEAR(found.element(0, 0).delay(), 0.6, 1e-2);
    EXPECT_NEAR(found.element(0, 1).StaticGain() / scale, 0.3, 1e-6);
    EXPECT_NEAR(found.element(0, 1).TimeConstant(), 4.0, 1e-4);
    EXPECT_NEAR(found.element(0, 1).delay(), 1.3, 1e-4);
    for (int j = 0; j < 4; ++j) {
      EXPECT_TRUE(found.element(0, j).IsIntegrating());
      EXPECT_LT(description->pairs[j].largest_difference, 2e-3) << j;
    }
    EXPECT_NEAR(found.element(0, 2).StaticGain() / scale, 0.2, 2e-3);
    EXPECT_NEAR(found.element(0, 3).StaticGain() / scale, 0.2, 2e-3);
    EXPECT_FALSE(found.element(0, 4).IsIntegrating());
  }
}

TEST(Describe, RefusesARampWithoutASlope) {
  StepResponseModel model =
      ModelOf({TransferFunction::FirstOrder(4.0, 10.0, 2.0),
               TransferFunction({0.5}, {1.0}, 4.0)},
              1.0, 60);
  model.pairs[1].is_ramp = true;
  const std::string message(Describe(model).status().message());
  EXPECT_THAT(message, AllOf(HasSubstr("y ← u2"), HasSubstr("without a slope"),
                             Not(HasSubstr("u1"))));
}

TEST(Describe, SaysWhatMovesOnAfterTheLastCoefficient) {
  const auto of = [](double share) {
    return Describe(ModelOf({TransferFunction::FirstOrder(2.0, 10.0, 0.0)}, 0.5,
                            static_cast<int>(-20.0 * std::log(1.0 - share))));
  };
  const absl::StatusOr<Description> settled = of(0.999);
  ASSERT_TRUE(settled.ok()) << settled.status();
  EXPECT_LT(settled->pairs[0].moves_on, 0.0012);
  const absl::StatusOr<Description> cut = of(0.8);
  ASSERT_TRUE(cut.ok()) << cut.status();
  EXPECT_NEAR(cut->pairs[0].moves_on, 0.25, 0.02);
  // A level whose ramp nobody has named.
  const absl::Status ramp =
      Describe(ModelOf({TransferFunction::Integrator(1.0, 0.0, 0.0)}, 1.0, 30))
          .status();
  EXPECT_THAT(std::string(ramp.message()),
              AllOf(HasSubstr("y ← u1: its step response has not settled"),
                    HasSubstr("ends in a ramp")));
}

// The line of the last interval meets zero long after the record.
TEST(Describe, ARampThatTurnsAwayFromZeroIsNoDeadTime) {
  for (const double turn : {1e-3, 1e-9, 1e-12}) {
    StepResponseModel model =
        ModelOf({TransferFunction::Integrator(0.3, 4.0, 1.3)}, 1.0, 60);
    model.pairs[0].is_ramp = true;
    Eigen::VectorXd& coefficients = model.pairs[0].coefficients;
    coefficients(59) = coefficients(58) * (1.0 - turn);
    const absl::StatusOr<Description> description = Describe(model);
    ASSERT_TRUE(description.ok()) << description.status();
    const TransferFunction& found = description->process.element(0, 0);
    EXPECT_TRUE(found.Validate().ok()) << found.Validate();
    EXPECT_LE(found.delay(), 60.0) << turn;
  }
}

}  // namespace
}  // namespace mle
