#include "mle/maintain/curves_held.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/data/linearise.h"
#include "mle/mle.h"
#include "tests/mle/explain/closed_loop_records.h"
#include "tests/mle/model/transforms.h"

namespace mle {
namespace {

CorrectionResult CorrectModel(const ProcessModel& model, const Record& record) {
  CorrectOptions options;
  options.make_arx = false;
  options.threads = 1;
  auto result = CorrectFromRecords(model, {record}, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

// Of the valve, an equal percentage: its gain is e^{c u}.
constexpr double kCurvature = 1.2;

Happening BentValve() {
  Happening happening;
  happening.input = [](int input, double asked) {
    return input == 0 ? std::expm1(kCurvature * asked) / kCurvature : asked;
  };
  happening.samples = 2400;
  return happening;
}

// Nothing has aged: the model is right where the records began, and what is
// handed over is its curve.
TEST(CurvesHeldTest, ACurveOfAnInputIsPutIntoTheModel) {
  const CorrectionResult result =
      CorrectModel(TwoLoops(), CloseLoops(TwoLoops(), 3, BentValve()));
  ASSERT_EQ(result.decision, Decision::kCorrected)
      << result.reasons.front().text;
  ASSERT_EQ(result.curves.size(), 1U);
  const FoundCurve& curve = result.curves.front();
  EXPECT_FALSE(curve.is_output);
  EXPECT_EQ(curve.channel, 0);
  EXPECT_NEAR(curve.curvature, kCurvature, 0.12);
  EXPECT_NEAR(curve.curvature, kCurvature, 3.0 * curve.standard_error);
  const FoundCurve::Gain gain = curve.GainAt(0.5);
  EXPECT_LT(gain.lower, gain.value);
  EXPECT_GT(gain.upper, gain.value);
  EXPECT_EQ(result.reasons.front().code, MessageCode::kCurved);
  EXPECT_NE(result.reasons.front().text.find(
                "The gain of valve follows its position: × "),
            std::string::npos)
      << result.reasons.front().text;
  // The model written has it, and is else as it was.
  const Transform& transform = result.model.inputs()[0].transform;
  EXPECT_EQ(transform.kind, TransformKind::kExponential);
  EXPECT_NEAR(transform.Slope(0.5) / transform.Slope(0.0),
              std::exp(0.5 * kCurvature), 0.1);
  for (const auto& [i, j] : Pairs(TwoLoops())) {
    EXPECT_NEAR(result.model.element(i, j).StaticGain(),
                TwoLoops().element(i, j).StaticGain(),
                0.12 * std::abs(TwoLoops().element(i, j).StaticGain()));
    // None is said to have changed that is kept.
    EXPECT_EQ(result.estimate.fit.output_error.aged(i, j),
              result.change.elements(i, j) > 0.0);
  }
}

// An element aged beside the curve: both are in the model.
TEST(CurvesHeldTest, AgeingBesideACurveIsCorrectedBetweenTransforms) {
  ProcessModel plant = TwoLoops();
  plant.element(1, 1) = TransferFunction::FirstOrder(0.9, 8.0, 1.0);
  const CorrectionResult result =
      CorrectModel(TwoLoops(), CloseLoops(plant, 4, BentValve()));
  ASSERT_EQ(result.decision, Decision::kCorrected);
  ASSERT_FALSE(result.curves.empty());
  EXPECT_EQ(result.curves.front().channel, 0);
  EXPECT_NEAR(result.model.element(1, 1).StaticGain(), 0.9, 0.06);
  EXPECT_NEAR(result.model.element(0, 0).StaticGain(), 2.0, 0.25);
}

// The curve wins by what it explains of both outputs that the valve drives.
TEST(CurvesHeldTest, ACurveIsJudgedOverAllOutputsOfItsInput) {
  const CorrectionResult result =
      CorrectModel(TwoLoops(), CloseLoops(TwoLoops(), 2, BentValve()));
  ASSERT_EQ(result.decision, Decision::kCorrected)
      << result.reasons.front().text;
  ASSERT_EQ(result.curves.size(), 1U);
  EXPECT_NEAR(result.curves.front().curvature, kCurvature, 0.3);
}

// y = ln(1 + a z)/a: the transform is an exponential.
TEST(CurvesHeldTest, ALogarithmicOutputIsStraightened) {
  constexpr double kBend = 0.5;
  Happening happening;
  happening.output = [](int output, double z) {
    return output == 0 ? std::log1p(kBend * std::max(z, -1.9)) / kBend : z;
  };
  happening.samples = 2400;
  const CorrectionResult result =
      CorrectModel(TwoLoops(), CloseLoops(TwoLoops(), 6, happening));
  ASSERT_EQ(result.decision, Decision::kCorrected)
      << result.reasons.front().text;
  ASSERT_FALSE(result.curves.empty());
  const Transform& transform = result.model.outputs()[0].transform;
  for (const double y : {0.5, 1.0}) {
    const double truth = std::exp(kBend * y);
    EXPECT_NEAR(transform.Slope(y) / transform.Slope(0.0), truth, 0.2 * truth);
    const FoundCurve::Gain gain = result.curves.front().GainAt(y);
    EXPECT_LT(gain.lower, 1.03 / truth);
    EXPECT_GT(gain.upper, 0.97 / truth);
  }
}

// A model that has the curve already agrees with its plant; one that lacks an
// aged gain is corrected within it.
TEST(CurvesHeldTest, AModelWithItsCurveIsCorrectedAsAnyOther) {
  ProcessModel model = TwoLoops();
  const Transform valve = Exponential(kCurvature);
  model.set_input_transform(0, valve);
  const CorrectionResult same =
      CorrectModel(model, CloseLoops(TwoLoops(), 3, BentValve()));
  EXPECT_EQ(same.decision, Decision::kNoChange) << same.reasons.front().text;
  EXPECT_TRUE(same.curves.empty());
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.3, 10.0, 2.0);
  const CorrectionResult aged =
      CorrectModel(model, CloseLoops(plant, 3, BentValve()));
  ASSERT_EQ(aged.decision, Decision::kCorrected);
  EXPECT_NEAR(aged.model.element(0, 0).StaticGain(), 1.3, 0.08);
  EXPECT_EQ(aged.model.inputs()[0].transform, valve);
}

// A curve beside a transform: the points of both, and the elements are the
// model at its operating point.
TEST(CurvesHeldTest, ACurveUponATransformIsBoth) {
  ProcessModel model("m", "min", {{"valve", "%"}}, {{"level", "m"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 1.0);
  const Transform given = Exponential(0.02, 50.0);
  model.set_input_transform(0, given);
  FoundCurve curve;
  curve.channel = 0;
  curve.curvature = 0.01;
  curve.at = given.Linear(40.0);
  curve.low = given.Linear(20.0);
  curve.high = given.Linear(80.0);
  RecordData data;
  Record record;
  record.sample_time = 1.0;
  record.inputs = Eigen::RowVectorXd::LinSpaced(61, 20.0, 80.0);
  record.outputs = Eigen::RowVectorXd::Zero(61);
  const Record engineering = record;
  ASSERT_TRUE(Linearise(model, record).ok());
  data.records = {record};
  const auto bent = WithCurves(model, data, {curve});
  ASSERT_TRUE(bent.ok()) << bent.status();
  const Transform& both = bent->model.inputs()[0].transform;
  const auto slope = [&](double u) {
    return given.Slope(u) *
           std::exp(curve.curvature * (given.Linear(u) - curve.at));
  };
  for (const double u : {25.0, 40.0, 70.0}) {
    EXPECT_NEAR(bent->model.element(0, 0).StaticGain() * both.Slope(u),
                2.0 * slope(u), 0.03 * slope(u))
        << u;
  }
  EXPECT_NEAR(bent->data.records[0].inputs(0, 20), both.Linear(40.0), 1e-9);
  Record back = bent->data.records[0];
  Delinearise(bent->model, back);
  EXPECT_TRUE(back.inputs.isApprox(engineering.inputs, 1e-9));
}

TEST(CurvesHeldTest, ARecordWithoutALogarithmIsRefused) {
  ProcessModel model = TwoLoops();
  model.set_output_transform(1, Logarithm(1.0));
  const auto result =
      CorrectFromRecords(model, {CloseLoops(TwoLoops(), 1)}, CorrectOptions());
  ASSERT_FALSE(result.ok());
  const std::string message(result.status().message());
  EXPECT_NE(message.find("warmth is "), std::string::npos) << message;
  EXPECT_NE(message.find("min, where its transform (logarithm) has no value"),
            std::string::npos)
      << message;
}

}  // namespace
}  // namespace mle
