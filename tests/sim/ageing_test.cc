#include "sim/ageing.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using ::mle::testing::SingleLoop;
using ::testing::HasSubstr;

AgeingSchedule SomeAgeing() {
  ElementAgeing element;
  element.gain = *Schedule::Create({{0.0, 1.0}, {10.0, 0.5}, {10.0, 0.25}});
  element.time_constant = *Schedule::Create({{0.0, 1.0}, {10.0, 1.44}});
  element.delay = *Schedule::Create({{0.0, 0.0}, {10.0, 3.0}});
  return {.elements = {element}};
}

TEST(ScaleAgeingTest, FactorsArePowersAndDeadTimesProducts) {
  const absl::StatusOr<AgeingSchedule> scaled = ScaleAgeing(SomeAgeing(), 0.5);
  ASSERT_TRUE(scaled.ok()) << scaled.status();
  const ElementAgeing& element = scaled->elements.front();
  EXPECT_DOUBLE_EQ(element.gain.At(10.0), 0.5);
  EXPECT_DOUBLE_EQ(element.gain.points()[1].value, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(element.time_constant.At(20.0), 1.2);
  EXPECT_DOUBLE_EQ(element.delay.At(5.0), 0.75);
}

TEST(ScaleAgeingTest, RatesMultiply) {
  const AgeingSchedule ageing = SomeAgeing();
  const AgeingSchedule twice = *ScaleAgeing(*ScaleAgeing(ageing, 2.0), 1.5);
  const AgeingSchedule once = *ScaleAgeing(ageing, 3.0);
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(2.0, 5.0, 1.0));
  for (const double time : {0.0, 4.0, 10.0, 30.0}) {
    const ProcessModel a = AgedModel(model, once, time);
    const ProcessModel b = AgedModel(model, twice, time);
    EXPECT_NEAR(a.element(0, 0).StaticGain(), b.element(0, 0).StaticGain(),
                1e-12);
    EXPECT_NEAR(a.element(0, 0).TimeConstant(), b.element(0, 0).TimeConstant(),
                1e-12);
    EXPECT_NEAR(a.element(0, 0).delay(), b.element(0, 0).delay(), 1e-12);
  }
}

TEST(ScaleAgeingTest, AtRateZeroNothingAgesAndAtOneAllStays) {
  const AgeingSchedule none = *ScaleAgeing(SomeAgeing(), 0.0);
  const AgeingSchedule same = *ScaleAgeing(SomeAgeing(), 1.0);
  for (const double time : {0.0, 7.0, 10.0, 30.0}) {
    EXPECT_EQ(none.elements[0].gain.At(time), 1.0);
    EXPECT_EQ(none.elements[0].time_constant.At(time), 1.0);
    EXPECT_EQ(none.elements[0].delay.At(time), 0.0);
    EXPECT_EQ(same.elements[0].gain.At(time),
              SomeAgeing().elements[0].gain.At(time));
  }
}

TEST(ScaleAgeingTest, MistakesAreNamed) {
  const auto message = [](const AgeingSchedule& ageing, double rate) {
    return std::string(ScaleAgeing(ageing, rate).status().message());
  };
  EXPECT_THAT(message(SomeAgeing(), -1.0), HasSubstr("ageing rate = -1"));
  EXPECT_THAT(message(SomeAgeing(), std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("ageing rate"));
  AgeingSchedule reversed = SomeAgeing();
  reversed.elements[0].gain = Schedule(-1.0);
  EXPECT_THAT(message(reversed, 2.0), HasSubstr("factor falls to -1"));
  AgeingSchedule huge = SomeAgeing();
  huge.elements[0].gain = Schedule(1e200);
  EXPECT_FALSE(ScaleAgeing(huge, 5.0).ok());
}

}  // namespace
}  // namespace mle::sim
