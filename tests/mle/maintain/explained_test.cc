#include "mle/maintain/explained.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/mle.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// The level shows that the valve has backlash, the warmth another gain: what
// happens to a valve happens to both.
TEST(ExplainedTest, OutputsThatContradictEachOtherCannotTell) {
  const ProcessModel model = TwoLoops();
  ProcessModel plant = model;
  plant.element(1, 0) = TransferFunction::FirstOrder(-1.4, 12.0, 4.0);
  Record record = CloseLoops(plant, 7);
  constexpr double kPlay = 0.15;
  double position = 0.0;
  double missing = 0.0;
  const TransferFunction& element = model.element(0, 0);
  const double kept = std::exp(-1.0 / element.TimeConstant());
  const int delay = static_cast<int>(element.delay());
  for (int k = delay; k < record.outputs.cols(); ++k) {
    record.outputs(0, k) += missing;
    const double asked = record.inputs(0, k - delay);
    position = std::clamp(position, asked - kPlay, asked + kPlay);
    missing = kept * missing +
              (1.0 - kept) * element.StaticGain() * (position - asked);
  }
  CorrectOptions options;
  options.make_arx = false;
  options.threads = 1;
  const auto result = CorrectFromRecords(model, {record}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCannotTell);
  const Message& reason = result->reasons.back();
  EXPECT_EQ(reason.place, "warmth");
  EXPECT_NE(reason.text.find("gain of warmth ← valve has changed, or valve "
                             "sticks or has backlash"),
            std::string::npos)
      << reason.text;
  EXPECT_NE(reason.text.find("as level shows"), std::string::npos);
  EXPECT_EQ(result->model.element(1, 0).StaticGain(), -0.9);
}

CorrectionResult Correct(const std::vector<Record>& records,
                         std::vector<double> leave_out = {}) {
  CorrectOptions options;
  options.records.leave_out = std::move(leave_out);
  options.make_arx = false;
  options.threads = 1;
  auto result = CorrectFromRecords(TwoLoops(), records, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

TEST(ExplainedTest, AGainThatChangedDuringTheRecordIsHandedOverAsItIsNow) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 10.0, 2.0);
  const Record before = CloseLoops(TwoLoops(), 5, {.samples = 1000});
  Record record = CloseLoops(plant, 5, {.samples = 2000});
  record.outputs.leftCols(1000) = before.outputs;
  record.inputs.leftCols(1000) = before.inputs;
  const CorrectionResult result = Correct({record});
  EXPECT_EQ(result.decision, Decision::kCorrected);
  EXPECT_EQ(result.accepted_outputs[0], Acceptance::kExplained);
  EXPECT_NEAR(result.model.element(0, 0).StaticGain(), 1.2, 0.12);
  EXPECT_EQ(result.model.element(1, 1).StaticGain(), 1.5);
  // Scores are of what is taken: here of another estimate, and of the model.
  EXPECT_TRUE(result.validation.held_out);
  const std::vector<OutputScores>& scores = result.validation.outputs;
  EXPECT_TRUE(std::isnan(scores[0].simulated.corrected));
  EXPECT_EQ(scores[1].simulated.corrected, scores[1].simulated.initial);
  const std::string& reason = result.reasons.back().text;
  EXPECT_NE(reason.find("gain of level ← valve changed during the record and "
                        "is × 0."),
            std::string::npos)
      << reason;
}

// What comes with set points is not the plant's alone: nothing is corrected.
TEST(ExplainedTest, ALoadThatComesWithSetPointsCannotTell) {
  Happening feed;
  feed.load = [](int input, const Eigen::Vector2d& set_points) {
    return input == 0 ? 0.4 * set_points[1] : 0.0;
  };
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 10.0, 2.0);
  const CorrectionResult result = Correct({CloseLoops(plant, 3, feed)});
  EXPECT_EQ(result.decision, Decision::kCannotTell);
  EXPECT_EQ(result.model.element(0, 0).StaticGain(), 2.0);
  EXPECT_NE(result.reasons.back().text.find("acts as valve does"),
            std::string::npos)
      << result.reasons.back().text;
}

TEST(ExplainedTest, WhatIsLeftOutExplainsNothing) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 10.0, 2.0);
  const Record right = CloseLoops(TwoLoops(), 5, {.samples = 1000});
  Record aged = CloseLoops(plant, 6, {.samples = 1000});
  aged.start_time = 5000.0;
  std::vector<double> times;
  for (int k = 65; k < 1000; k += 120) times.push_back(5000.0 + k);
  EXPECT_FALSE(Correct({right, aged}).explanations[0].taken.empty());
  const CorrectionResult result = Correct({right, aged}, times);
  EXPECT_TRUE(result.explanations[0].taken.empty());
  EXPECT_EQ(result.decision, Decision::kNoChange);
}

// A lag that the model has in its dead time is a shape to the likelihood; the
// gain is what has aged.
TEST(ExplainedTest, AShapeIsNotTakenWhereAParameterExplainsAsMuch) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 10.0, 0.0);
  double valve = 0.0;
  Happening lag;
  lag.input = [&](int j, double asked) {
    if (j == 0) valve += 0.4 * (asked - valve);
    return j == 0 ? valve : asked;
  };
  lag.noise = 0.01;
  const CorrectionResult result = Correct({CloseLoops(plant, 5, lag)});
  EXPECT_EQ(result.decision, Decision::kCorrected);
  const TransferFunction& element = result.model.element(0, 0);
  EXPECT_EQ(element.denominator().size(), 2u);
  EXPECT_NEAR(element.StaticGain(), 1.2, 0.06);
}

// Inputs that answer the output are hardly instruments.
TEST(ExplainedTest, WithoutSetPointsLittleEvidenceIsNoneWhereInputsAnswer) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.4, 10.0, 2.0);
  Record record = CloseLoops(plant, 4, {.noise = 0.03, .drift = 0.06});
  record.set_points.setZero();
  const CorrectionResult result = Correct({record});
  EXPECT_TRUE(result.explanations[0].answered());
  EXPECT_EQ(result.accepted_outputs[0], Acceptance::kNothing);
  EXPECT_EQ(result.decision, Decision::kCannotTell);
  EXPECT_EQ(result.reasons.back().code, MessageCode::kNotConfirmed);
}

TEST(ExplainedTest, ADeadSensorLeavesTheOtherOutputs) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 10.0, 2.0);
  Record record = CloseLoops(plant, 5);
  record.outputs.row(1).setConstant(0.5);
  const CorrectionResult result = Correct({record});
  EXPECT_EQ(result.decision, Decision::kCorrected)
      << result.reasons.front().text;
  EXPECT_NEAR(result.model.element(0, 0).StaticGain(), 1.2, 0.06);
  EXPECT_EQ(result.accepted_outputs[1], Acceptance::kNothing);
  EXPECT_EQ(result.reasons.front().code, MessageCode::kStuckOutput);
  EXPECT_EQ(result.reasons.front().place, "warmth");
}

}  // namespace
}  // namespace mle
