#include "mle/model/transform.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/mle/model/transforms.h"

namespace mle {
namespace {

std::vector<Transform> AllTransforms() {
  Transform logarithm = Logarithm(30.0);
  logarithm.zero = -5.0;
  Transform reflected = logarithm;  // values below x₀
  reflected.zero = 200.0;
  Transform reciprocal = Root(25.0);
  reciprocal.exponent = -1.0;
  Transform quick;
  quick.kind = TransformKind::kQuickOpening;
  quick.low = -1.0;
  quick.high = 100.0;
  quick.at = 50.0;
  Transform sinh = Exponential(0.03, 40.0);
  sinh.kind = TransformKind::kSinh;
  Transform arsinh = Exponential(-0.05, 40.0);
  arsinh.kind = TransformKind::kSinh;
  Transform artanh = Exponential(0.01, 40.0);
  artanh.kind = TransformKind::kTanh;
  Transform tanh = Exponential(-0.02, 40.0);
  tanh.kind = TransformKind::kTanh;
  Transform pieces;
  pieces.kind = TransformKind::kPiecewiseLinear;
  pieces.points = {{0.0, 0.0}, {20.0, 5.0}, {60.0, 45.0}, {100.0, 65.0}};
  pieces.at = 30.0;
  return {{},
          Exponential(-0.02, 10.0),
          EqualPercentage(50.0, 40.0),
          logarithm,
          reflected,
          Root(25.0),
          reciprocal,
          quick,
          sinh,
          arsinh,
          artanh,
          tanh,
          pieces};
}

TEST(TransformTest, AtTheOperatingPointNothingIsTransformed) {
  for (const Transform& transform : AllTransforms()) {
    SCOPED_TRACE(transform.Description());
    ASSERT_TRUE(transform.Validate().ok()) << transform.Validate();
    EXPECT_NEAR(transform.Linear(transform.at), transform.at, 1e-12);
    EXPECT_NEAR(transform.Slope(transform.at), 1.0, 1e-12);
  }
}

// There and back, rising, and the slope is that of differences.
TEST(TransformTest, EachHasItsInverseAndItsSlope) {
  for (const Transform& transform : AllTransforms()) {
    SCOPED_TRACE(transform.Description());
    double before = -1e300;
    for (double x = 1.5; x < 99.0; x += 7.0) {
      const double z = transform.Linear(x);
      EXPECT_NEAR(transform.Engineering(z), x, 1e-10 * std::abs(x));
      EXPECT_GT(z, before);
      before = z;
      constexpr double kStep = 1e-5;
      const double slope = (transform.Linear(x + kStep) - z) / kStep;
      EXPECT_NEAR(transform.Slope(x), slope, 1e-4 * slope);
    }
  }
}

TEST(TransformTest, AnEqualPercentageValveMultipliesItsGainByItsRangeability) {
  const Transform valve = EqualPercentage(50.0, 40.0);
  EXPECT_NEAR(valve.Slope(100.0) / valve.Slope(0.0), 50.0, 1e-10);
}

TEST(TransformTest, BeyondItsPointsACurveGoesStraightOn) {
  const Transform pieces = AllTransforms().back();
  EXPECT_NEAR(pieces.Slope(-50.0), pieces.Slope(1.0), 1e-12);
  EXPECT_NEAR(pieces.Slope(500.0), pieces.Slope(99.0), 1e-12);
  EXPECT_NEAR(pieces.Engineering(pieces.Linear(500.0)), 500.0, 1e-9);
}

TEST(TransformTest, ValuesWithoutALogarithmHaveNone) {
  const Transform logarithm = Logarithm(2.0);
  EXPECT_TRUE(logarithm.Holds(1e-9));
  for (const double x : {0.0, -1.0}) {
    EXPECT_FALSE(logarithm.Holds(x));
    EXPECT_TRUE(std::isnan(logarithm.Linear(x)));
    EXPECT_TRUE(std::isnan(logarithm.Slope(x)));
  }
  // What no value gives.
  EXPECT_TRUE(std::isnan(EqualPercentage(50.0, 40.0).Engineering(-1e6)));
}

TEST(TransformTest, WhatIsWrongIsNamed) {
  const auto fault = [](const Transform& transform) {
    return std::string(transform.Validate().message());
  };
  Transform pieces = AllTransforms().back();
  pieces.points[2].second = 5.0;
  EXPECT_NE(fault(pieces).find("points[2] = [60, 5] after [20, 5]: both "
                               "numbers must rise"),
            std::string::npos)
      << fault(pieces);
  EXPECT_NE(fault(Logarithm(0.0)).find("at = 0"), std::string::npos);
  Transform valve = EqualPercentage(50.0, 40.0);
  valve.rangeability = 1.0;
  EXPECT_NE(fault(valve).find("rangeability = 1"), std::string::npos);
  valve = EqualPercentage(50.0, 40.0);
  valve.high = -1.0;
  EXPECT_NE(fault(valve).find("open must be above closed"), std::string::npos);
  Transform power;
  power.kind = TransformKind::kPower;
  power.at = 1.0;
  EXPECT_NE(fault(power).find("exponent = 0"), std::string::npos);
}

// Whatever is taken has no NaN at its operating point, nor far from it.
TEST(TransformTest, WhatCannotBeComputedWithIsRefused) {
  const std::vector<double> numbers = {
      0.0,  5e-324, 1e-150, 1e-60,  1e-9, 1.0,    1e9,
      1e60, 1e150,  1e308,  -1e-60, -1.0, -1e308, 1.0 + 3e-16};
  int taken = 0;
  const auto check = [&](const Transform& transform) {
    if (!transform.Validate().ok()) return;
    ++taken;
    SCOPED_TRACE(transform.Description());
    EXPECT_EQ(transform.Linear(transform.at), transform.at);
    EXPECT_EQ(transform.Slope(transform.at), 1.0);
    for (const double x : {-1e60, -3.0, 0.0, 2.0, 1e60}) {
      EXPECT_EQ(std::isnan(transform.Linear(x)), !transform.Holds(x)) << x;
      EXPECT_EQ(std::isnan(transform.Slope(x)), !transform.Holds(x)) << x;
    }
  };
  for (Transform transform : AllTransforms()) {
    for (double Transform::*const field :
         {&Transform::at, &Transform::curvature, &Transform::rangeability,
          &Transform::low, &Transform::high, &Transform::zero,
          &Transform::exponent}) {
      for (const double number : numbers) {
        for (const double at : {transform.at, number}) {
          Transform changed = transform;
          changed.*field = number;
          changed.at = at;
          check(changed);
        }
      }
    }
    for (const double number : numbers) {
      for (auto& [x, f] : transform.points) {
        for (double* const coordinate : {&x, &f}) {
          const double before = std::exchange(*coordinate, number);
          check(transform);
          *coordinate = before;
        }
      }
    }
  }
  EXPECT_GT(taken, 500);
}

// Wood and Berry's column with a valve in the reflux and a logarithm of the
// distillate: at another point gains are times the slopes.
TEST(TransformTest, AtAPointTheModelIsLinear) {
  ProcessModel model("m", "min", {{"reflux", "%"}, {"steam", "%"}},
                     {{"top", "%"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0, 5.0, 2.0);
  model.set_input_transform(0, EqualPercentage(50.0, 40.0));
  model.set_output_transform(0, Logarithm(4.0));
  ASSERT_TRUE(HasTransforms(model));
  const auto linear =
      LinearAt(model, {{"reflux", 60.0}, {"steam", 7.0}, {"top", 2.0}});
  ASSERT_TRUE(linear.ok()) << linear.status();
  EXPECT_FALSE(HasTransforms(*linear));
  const double valve = std::pow(50.0, (60.0 - 40.0) / 100.0);
  EXPECT_NEAR(linear->element(0, 0).StaticGain(), 2.0 * valve / 2.0, 1e-12);
  EXPECT_NEAR(linear->element(0, 1).StaticGain(), -3.0 / 2.0, 1e-12);
  EXPECT_EQ(linear->element(0, 1).delay(), 2.0);
  // Channels that are not named are at the operating point.
  EXPECT_EQ(LinearAt(model, {})->element(0, 0).StaticGain(), 2.0);
  EXPECT_EQ(LinearAt(model, {{"flap", 1.0}}).status().message(),
            "the model has no channel 'flap'");
  const auto outside = LinearAt(model, {{"top", -2.0}});
  EXPECT_NE(outside.status().message().find("top = -2: its transform"),
            std::string::npos)
      << outside.status();
}

TEST(TransformTest, TheJsonFormComesBackWhole) {
  const std::vector<Transform> all = AllTransforms();
  for (const Transform& transform : all) {
    SCOPED_TRACE(transform.Description());
    ProcessModel model("m", "min", {{"valve", "%"}}, {{"level", "m"}});
    model.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 1.0);
    model.set_input_transform(0, transform);
    model.set_output_transform(0, transform);
    const auto read = ParseProcessModel(FormatProcessModel(model), "m.json");
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->inputs()[0].transform, transform);
    EXPECT_EQ(read->outputs()[0].transform, transform);
  }
}

TEST(TransformTest, AFileThatIsWrongSaysWhere) {
  const auto fault = [](const std::string& transform) {
    const std::string text =
        R"({"name": "m", "time_unit": "min", "inputs": [{"name": "valve",
        "unit": "%", "transform": )" +
        transform + R"(}], "outputs": [{"name": "level", "unit": "m"}],
        "elements": []})";
    return std::string(ParseProcessModel(text, "m.json").status().message());
  };
  EXPECT_NE(fault(R"({"kind": "cubic", "at": 1})")
                .find("inputs[0].transform.kind: is \"cubic\", must be one of "
                      "exponential, equal_percentage"),
            std::string::npos)
      << fault(R"({"kind": "cubic", "at": 1})");
  EXPECT_NE(fault(R"({"kind": "log"})").find("at"), std::string::npos);
  EXPECT_NE(fault(R"({"kind": "log", "at": 0})").find("at = 0"),
            std::string::npos);
  EXPECT_NE(fault(R"("log")").find("must be an object with kind"),
            std::string::npos);
  EXPECT_NE(fault(R"({"kind": "piecewise_linear", "at": 1, "points": [[1]]})")
                .find("a point has two"),
            std::string::npos);
}

}  // namespace
}  // namespace mle
