#include "mle/explain/curves.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/explain/competition.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

constexpr CurveShape kShapes[] = {
    CurveShape::kExponential, CurveShape::kSinh, CurveShape::kLogarithm,
    CurveShape::kQuadratic,   CurveShape::kRoot, CurveShape::kTanh};

double Bend(CurveShape shape, double c, double x) {
  return CurveTransform(shape, c, 1.0).Linear(x);
}

// To second order four shapes are alike, to third two.
TEST(CurvesTest, EveryShapeIsItsFunction) {
  constexpr double kC = 0.4;
  constexpr double kX = 0.7;
  constexpr double kCx = kC * kX;
  EXPECT_NEAR(Bend(CurveShape::kExponential, kC, kX), std::expm1(kCx) / kC,
              1e-12);
  EXPECT_NEAR(Bend(CurveShape::kLogarithm, kC, kX), std::log1p(kCx) / kC,
              1e-12);
  EXPECT_NEAR(Bend(CurveShape::kQuadratic, kC, kX), kX + 0.5 * kC * kX * kX,
              1e-12);
  EXPECT_NEAR(Bend(CurveShape::kRoot, kC, kX),
              (std::sqrt(1.0 + 2.0 * kCx) - 1.0) / kC, 1e-12);
  EXPECT_NEAR(Bend(CurveShape::kSinh, kC, kX), std::sinh(kCx) / kC, 1e-12);
  EXPECT_NEAR(Bend(CurveShape::kTanh, -kC, kX), std::tanh(kCx) / kC, 1e-12);
  for (const CurveShape shape : kShapes) {
    EXPECT_EQ(Bend(shape, 0.0, kX), kX);
    EXPECT_NEAR(Bend(shape, 1e-9, kX), kX, 1e-8);
  }
}

// Of slope 1 up to the kink, on its side.
TEST(CurvesTest, AKinkHasAnotherSlopeBeyond) {
  const double c = 0.5 * std::log(3.0);
  const auto kink = [&](int number, double x) {
    return CurveTransform(
               static_cast<CurveShape>(
                   static_cast<int>(CurveShape::kFirstKink) + number),
               c, 2.0)
        .Linear(x);
  };
  for (const double x : {-1.9, -0.2, 0.0, 0.3, 0.9}) {
    EXPECT_NEAR(kink(2, x), x, 1e-12) << x;
    EXPECT_NEAR(kink(2 + kKinks / 2, -x), -x, 1e-12) << x;
  }
  EXPECT_NEAR(kink(2, 1.5), 2.5, 1e-12);
  EXPECT_NEAR(kink(2, 4.0), 10.0, 1e-12);
  EXPECT_NEAR(kink(2 + kKinks / 2, -1.5), -2.5, 1e-12);
}

TEST(CurvesTest, WhereThereIsNoCurveThereIsNone) {
  EXPECT_TRUE(std::isnan(Bend(CurveShape::kLogarithm, 1.0, -1.5)));
  EXPECT_TRUE(std::isnan(Bend(CurveShape::kQuadratic, 1.0, -1.5)));
  EXPECT_TRUE(std::isnan(Bend(CurveShape::kRoot, 1.0, -1.5)));
  EXPECT_TRUE(std::isnan(Bend(CurveShape::kTanh, 1.0, 1.5)));
  EXPECT_TRUE(std::isnan(
      CurveTransform(CurveShape::kExponential, 1.0, 1.0).Engineering(-1.5)));
}

// Shapes of a family are alike where little is visited.
TEST(CurvesTest, OtherShapesBendAsFarFromTheStart) {
  for (const int part : ShapesOf(ExplanationKind::kCurvedInput)) {
    const Explanation curve = {ExplanationKind::kCurvedInput, 0, 0.3, 0};
    const std::vector<Explanation> others = InShape(curve, part);
    // A kink bends nothing here, either way.
    if (part >= static_cast<int>(CurveShape::kFirstKink)) {
      EXPECT_EQ(others.size(), 2U);
      continue;
    }
    ASSERT_EQ(others.size(), 1U);
    EXPECT_NEAR(Bend(ShapeOf(others[0]), others[0].value, 0.2),
                Bend(ShapeOf(curve), curve.value, 0.2), 5e-4);
  }
  EXPECT_EQ(InShape({ExplanationKind::kCurvedOutput, 0, 0.3, 0},
                    static_cast<int>(CurveShape::kTanh))
                .size(),
            2U);
}

// The transform of a channel is the curve of an input, and straightens that of
// an output; gains are its slopes.
TEST(CurvesTest, AFoundCurveIsATransform) {
  for (const bool is_output : {false, true}) {
    for (const CurveShape shape : kShapes) {
      FoundCurve curve;
      curve.is_output = is_output;
      curve.shape = shape;
      curve.curvature = -0.3;
      curve.at = 2.0;
      curve.low = 1.0;
      curve.high = 3.0;
      const Transform transform = curve.AsTransform();
      ASSERT_TRUE(transform.Validate().ok()) << transform.Validate();
      SCOPED_TRACE(transform.Description());
      for (const double x : {1.2, 2.0, 2.7}) {
        const Transform h = CurveTransform(shape, -0.3, 1.0);
        const double z =
            2.0 + (is_output ? h.Engineering(x - 2.0) : h.Linear(x - 2.0));
        EXPECT_NEAR(transform.Linear(x), z, 1e-12);
        const double slope = transform.Slope(x);
        EXPECT_NEAR(curve.GainAt(x).value, is_output ? 1.0 / slope : slope,
                    1e-12);
      }
    }
  }
}

TEST(CurvesTest, ABandHasTheErrorsOfAllShapesInIt) {
  FoundCurve curve;
  curve.curvature = 0.5;
  curve.standard_error = 0.05;
  curve.low = -1.0;
  curve.high = 1.0;
  const FoundCurve::Gain alone = curve.GainAt(1.0);
  EXPECT_NEAR(alone.upper, std::exp(0.5 + 1.96 * 0.05), 1e-3);
  EXPECT_NEAR(alone.lower, std::exp(0.5 - 1.96 * 0.05), 1e-3);
  curve.alternatives.push_back({CurveShape::kQuadratic, 0.4});
  EXPECT_NEAR(curve.GainAt(1.0).lower, 1.4 - 1.96 * 0.04, 1e-3);
  // One upon the other: gains are multiplied.
  FoundCurve upon = curve;
  upon.alternatives.clear();
  upon.curvature = -0.2;
  curve.upon = {upon};
  const double linear = std::expm1(0.5) / 0.5;
  EXPECT_NEAR(curve.GainAt(1.0).value, std::exp(0.5) * std::exp(-0.2 * linear),
              1e-9);
}

// Two valves in split range, the second twice as large.
TEST(CurvesTest, AKinkIsFoundWhereItIs) {
  Happening happening;
  happening.input = [](int input, double asked) {
    return input == 0 && asked > 0.25 ? 0.25 + 2.0 * (asked - 0.25) : asked;
  };
  happening.samples = 2400;
  happening.drift = 0.002;
  const auto competition = Competition::Run(
      TwoLoops(), {CloseLoops(TwoLoops(), 3, happening)}, ExplainOptions());
  ASSERT_TRUE(competition.ok()) << competition.status();
  const std::vector<FoundCurve> curves = competition->Curves();
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_EQ(curves[0].channel, 0);
  EXPECT_GE(curves[0].shape, CurveShape::kFirstKink);
  EXPECT_NEAR(curves[0].GainAt(0.1).value, 1.0, 0.1);
  EXPECT_NEAR(curves[0].GainAt(curves[0].high).value, 2.0, 0.25);
}

// A valve of equal percentage is an exponential, for all its outputs.
TEST(CurvesTest, TheShapeThatLeavesLeastIsTaken) {
  Happening happening;
  happening.input = [](int input, double asked) {
    return input == 0 ? std::expm1(2.0 * asked) / 2.0 : asked;
  };
  happening.samples = 2400;
  happening.drift = 0.002;
  const auto competition = Competition::Run(
      TwoLoops(), {CloseLoops(TwoLoops(), 3, happening)}, ExplainOptions());
  ASSERT_TRUE(competition.ok()) << competition.status();
  const std::vector<FoundCurve> curves = competition->Curves();
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_FALSE(curves[0].is_output);
  EXPECT_EQ(curves[0].channel, 0);
  for (const double u : {-0.2, 0.3}) {
    const FoundCurve::Gain gain = curves[0].GainAt(curves[0].at + u);
    EXPECT_NEAR(gain.value, std::exp(2.0 * u), 0.1 * std::exp(2.0 * u));
  }
}

}  // namespace
}  // namespace mle
