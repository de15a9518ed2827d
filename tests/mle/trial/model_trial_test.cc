#include "mle/trial/model_trial.h"

#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/model/transforms.h"
#include "tests/mle/trial/tried_loop.h"

namespace mle {
namespace {

ModelTrial MakeTrial(double in_use, double proposed) {
  absl::StatusOr<ModelTrial> trial =
      ModelTrial::Create(Tank(in_use), Tank(proposed), 1.0, {});
  EXPECT_TRUE(trial.ok()) << trial.status();
  // How the loop answers: four changes, and 600 minutes of rest.
  EXPECT_TRUE(
      trial->Learn(RecordOf({.plant_gain = 1.6, .changes = 4}, 1)).ok());
  return *std::move(trial);
}

TrialVerdict VerdictAfter(ModelTrial& trial, const Record& record) {
  EXPECT_TRUE(trial.Look(record).ok());
  return trial.verdict();
}

TEST(ModelTrialTest, RightCorrectionIsAdoptedAfterAFewChanges) {
  ModelTrial trial = MakeTrial(2.0, 1.6);
  const TrialVerdict verdict =
      VerdictAfter(trial, RecordOf({.plant_gain = 1.6, .changes = 3}, 2));
  EXPECT_EQ(verdict.advice, TrialAdvice::kAdopt);
  EXPECT_LT(verdict.left_share, 0.05);
  ASSERT_EQ(verdict.evidence.size(), 3u);
  // Two are needed, and enough.
  EXPECT_LT(verdict.evidence[0].log_for, std::log(100.0));
  EXPECT_GT(verdict.evidence[1].log_for, std::log(100.0));
}

TEST(ModelTrialTest, WrongCorrectionsAreDropped) {
  for (const double proposed : {2.4, 1.6}) {
    ModelTrial trial = MakeTrial(2.0, proposed);
    // The plant has not changed, or the other way.
    const double plant = proposed > 2.0 ? 1.7 : 2.0;
    const TrialVerdict verdict =
        VerdictAfter(trial, RecordOf({.plant_gain = plant, .changes = 6}, 3));
    EXPECT_EQ(verdict.advice, TrialAdvice::kDrop) << proposed;
  }
}

// Nobody is told that a bent model is no better than a linear one.
TEST(ModelTrialTest, ModelsWithTransformsAreNotTried) {
  ProcessModel bent = Tank(1.6);
  bent.set_output_transform(0, Root(4.0));
  const auto trial = ModelTrial::Create(Tank(2.0), bent, 1.0, {});
  EXPECT_THAT(std::string(trial.status().message()),
              ::testing::HasSubstr("one of these has a transform"));
}

// Half of the true change predicts better, and leaves a quarter of what set
// points drive: it is not adopted, and the evidence for it grows.
TEST(ModelTrialTest, ModelThatLeavesMuchIsNotAdopted) {
  ModelTrial trial = MakeTrial(2.0, 1.8);
  const TrialVerdict verdict =
      VerdictAfter(trial, RecordOf({.plant_gain = 1.6, .changes = 8}, 4));
  EXPECT_EQ(verdict.advice, TrialAdvice::kWait);
  EXPECT_GT(verdict.evidence.back().log_for, std::log(100.0));
  // Gain errors 0.4 and 0.2, squared: 1/4; noise makes some percent of it.
  EXPECT_NEAR(verdict.left_share, 0.25, 0.08);
}

// Half-way between the models neither is better: X has mean 0 and a variance of
// at most 1, in white noise and in drift that the controller answers.
TEST(ModelTrialTest, DifferencesHaveMeanZeroHalfWay) {
  for (const double drift : {0.0, 1e-4}) {
    std::vector<double> differences;
    for (std::uint64_t seed = 10; seed < 20; ++seed) {
      ModelTrial trial = MakeTrial(2.0, 1.8);
      ASSERT_TRUE(trial
                      .Look(RecordOf({.plant_gain = 1.9,
                                      .drift_variance = drift,
                                      .changes = 20,
                                      .quiet = 3000.0},
                                     seed))
                      .ok());
      for (const TrialResponse& response : trial.state().responses) {
        differences.push_back(response.difference());
      }
    }
    const auto n = static_cast<double>(differences.size());
    ASSERT_GE(n, 190.0);
    double mean = 0.0;
    double square = 0.0;
    double fourth = 0.0;
    for (const double x : differences) {
      mean += x / n;
      square += x * x / n;
      fourth += x * x * x * x / n;
    }
    // Four standard errors of a mean of variance 1; of a variance of 1, whose
    // own is 2/n for normal values; of a fourth moment of 3, whose own is 96/n.
    EXPECT_LT(std::abs(mean), 4.0 / std::sqrt(n)) << drift;
    EXPECT_LT(square, 1.0 + 4.0 * std::sqrt(2.0 / n)) << drift;
    EXPECT_LT(fourth, 4.0 + 4.0 * std::sqrt(96.0 / n)) << drift;
  }
}

// In drift that a controller answers a model with too small a gain has the
// smaller errors several steps ahead, since what the inputs do looks like less
// of it. Set points are not deceived.
TEST(ModelTrialTest, FeedbackDeceivesLossesButNotSetPoints) {
  ModelTrial trial = MakeTrial(2.0, 1.4);
  const TrialVerdict verdict = VerdictAfter(
      trial,
      RecordOf({.drift_variance = 3e-3, .changes = 12, .period = 600.0}, 5));
  EXPECT_LT(LossRatio(trial.state().losses), 1.0);
  EXPECT_NE(verdict.advice, TrialAdvice::kAdopt);
  ASSERT_FALSE(verdict.evidence.empty());
  EXPECT_LT(verdict.evidence.back().log_for, std::log(100.0));
}

TEST(ModelTrialTest, RollsBackWhereThePlantReturnsAndKeepsWhereItStays) {
  for (const bool returns : {false, true}) {
    ModelTrial trial = MakeTrial(2.0, 1.6);
    ASSERT_EQ(
        VerdictAfter(trial, RecordOf({.plant_gain = 1.6, .changes = 3}, 2))
            .advice,
        TrialAdvice::kAdopt);
    trial.Adopt();
    EXPECT_EQ(trial.verdict().advice, TrialAdvice::kKeep);
    EXPECT_EQ(trial.state().before.size(), 3u);
    const TrialVerdict verdict =
        VerdictAfter(trial, RecordOf({.model_gain = 1.6,
                                      .plant_gain = returns ? 2.0 : 1.6,
                                      .changes = 4},
                                     6));
    EXPECT_EQ(verdict.advice,
              returns ? TrialAdvice::kRollBack : TrialAdvice::kKeep);
  }
}

// Units do not matter: outputs in tenths and inputs in thousands.
TEST(ModelTrialTest, VerdictDoesNotDependOnUnits) {
  const Record learned = RecordOf({.plant_gain = 1.6, .changes = 4}, 1);
  const Record seen = RecordOf({.plant_gain = 1.6, .changes = 3}, 2);
  ModelTrial plain = MakeTrial(2.0, 1.6);
  const TrialVerdict expected = VerdictAfter(plain, seen);
  const auto scaled = [](Record record) {
    record.outputs *= 10.0;
    record.set_points *= 10.0;
    record.inputs *= 1000.0;
    return record;
  };
  absl::StatusOr<ModelTrial> trial =
      ModelTrial::Create(Tank(0.02), Tank(0.016), 1.0, {});
  ASSERT_TRUE(trial.ok()) << trial.status();
  ASSERT_TRUE(trial->Learn(scaled(learned)).ok());
  const TrialVerdict verdict = VerdictAfter(*trial, scaled(seen));
  ASSERT_EQ(verdict.evidence.size(), expected.evidence.size());
  for (std::size_t i = 0; i < verdict.evidence.size(); ++i) {
    EXPECT_NEAR(verdict.evidence[i].log_for, expected.evidence[i].log_for,
                1e-6);
  }
}

TEST(ModelTrialTest, GoesOnFromItsStateToTheBit) {
  const Record first = RecordOf({.plant_gain = 1.6, .changes = 3}, 2);
  Record second = RecordOf({.plant_gain = 1.6, .changes = 3}, 3);
  second.start_time = first.time(first.samples());
  ModelTrial whole = MakeTrial(2.0, 1.6);
  ASSERT_TRUE(whole.Look(first).ok());
  absl::StatusOr<ModelTrial> resumed =
      ModelTrial::Resume(Tank(2.0), Tank(1.6), 1.0, {}, whole.state());
  ASSERT_TRUE(resumed.ok()) << resumed.status();
  ASSERT_TRUE(whole.Look(second).ok());
  ASSERT_TRUE(resumed->Look(second).ok());
  EXPECT_EQ(whole.state().responses, resumed->state().responses);
  EXPECT_EQ(whole.state().normal, resumed->state().normal);
  TrialState other = whole.state();
  other.responses.front().gains.push_back(1.0);
  EXPECT_EQ(
      ModelTrial::Resume(Tank(2.0), Tank(1.6), 1.0, {}, other).status().code(),
      absl::StatusCode::kDataLoss);
}

// A day that ends in the middle of a response: the rest comes with the next
// one, which has the settling time before it.
TEST(ModelTrialTest, ResponsesGoOnFromOneRecordToTheNext) {
  const Record whole = RecordOf({.plant_gain = 1.6, .changes = 3}, 2);
  ModelTrial at_once = MakeTrial(2.0, 1.6);
  const TrialVerdict expected = VerdictAfter(at_once, whole);
  ModelTrial in_parts = MakeTrial(2.0, 1.6);
  const int cut = 600 + 240 + 20;  // 20 minutes after the second change
  ASSERT_TRUE(in_parts.Look(PartOf(whole, 0, cut)).ok());
  const int lead = in_parts.Lead();
  const TrialVerdict verdict = [&] {
    EXPECT_TRUE(
        in_parts
            .Look(PartOf(whole, cut - lead, whole.samples() - cut + lead), lead)
            .ok());
    return in_parts.verdict();
  }();
  ASSERT_EQ(verdict.evidence.size(), expected.evidence.size());
  // A settling time leaves e⁻⁵ of what inputs did before.
  EXPECT_NEAR(verdict.evidence.back().log_for, expected.evidence.back().log_for,
              0.3);
}

TEST(ModelTrialTest, LostSamplesAreBridged) {
  ModelTrial trial = MakeTrial(2.0, 1.6);
  Record record = RecordOf({.plant_gain = 1.6, .changes = 4}, 2);
  for (int k = 3; k < record.samples(); k += 10) record.outputs(0, k) = kNaN;
  record.inputs.col(610).setConstant(kNaN);  // one response is not judged
  const TrialVerdict verdict = VerdictAfter(trial, record);
  EXPECT_EQ(verdict.advice, TrialAdvice::kAdopt);
  EXPECT_GE(verdict.not_judged, 1);
}

// Values at the ends of what a record may hold, and signals that stand still.
TEST(ModelTrialTest, ExtremeRecordsSayNothing) {
  const Record record = RecordOf({.plant_gain = 1.6, .changes = 4}, 2);
  for (const double size : {0.0, 1e-300, 1e60}) {
    ModelTrial trial = MakeTrial(2.0, 1.6);
    Record extreme = record;
    extreme.outputs = (extreme.outputs * size).cwiseMin(1e60).cwiseMax(-1e60);
    const TrialVerdict verdict = VerdictAfter(trial, extreme);
    EXPECT_NE(verdict.advice, TrialAdvice::kAdopt) << size;
    EXPECT_TRUE(std::isfinite(verdict.left_share));
    EXPECT_TRUE(std::isfinite(LossRatio(trial.state().losses)));
    for (const TrialEvidencePoint& point : verdict.evidence) {
      EXPECT_TRUE(std::isfinite(point.log_for));
      EXPECT_TRUE(std::isfinite(point.log_against));
    }
  }
}

// Set points that never rest for a settling time: the noise is that of all
// rows, errors of the models included, so that it takes longer.
TEST(ModelTrialTest, SetPointsThatNeverRestTakeLonger) {
  absl::StatusOr<ModelTrial> trial =
      ModelTrial::Create(Tank(2.0), Tank(1.6), 1.0, {});
  ASSERT_TRUE(trial.ok()) << trial.status();
  const TrialVerdict verdict = VerdictAfter(
      *trial,
      RecordOf(
          {.plant_gain = 1.6, .changes = 120, .period = 45.0, .quiet = 80.0},
          2));
  EXPECT_EQ(verdict.advice, TrialAdvice::kAdopt);
  EXPECT_GT(verdict.not_judged, 5);
}

// Without set points moves of inputs by hand stand for them.
TEST(ModelTrialTest, MovesByHandStandForSetPoints) {
  absl::StatusOr<ModelTrial> trial =
      ModelTrial::Create(Tank(2.0), Tank(1.6), 1.0, {});
  ASSERT_TRUE(trial.ok()) << trial.status();
  Record record = RecordOf({.plant_gain = 1.6, .changes = 8}, 2);
  // The set point as the input of an open loop.
  record.inputs = record.set_points;
  record.set_points.resize(0, 0);
  const absl::StatusOr<Eigen::MatrixXd> response =
      SimulateResponse(Tank(1.6), 1.0, record.inputs);
  ASSERT_TRUE(response.ok());
  record.outputs =
      *response + 0.03 * Eigen::MatrixXd::Random(1, record.outputs.cols());
  const TrialVerdict verdict = VerdictAfter(*trial, record);
  EXPECT_EQ(verdict.advice, TrialAdvice::kAdopt);
}

TEST(ModelTrialTest, SaysWhatIsWrong) {
  using ::testing::HasSubstr;
  const auto error = [](const absl::StatusOr<ModelTrial>& trial) {
    return std::string(trial.status().message());
  };
  EXPECT_THAT(error(ModelTrial::Create(Tank(2.0), Tank(2.0), 1.0, {})),
              HasSubstr("the proposed model is the model in use"));
  EXPECT_THAT(error(ModelTrial::Create(Tank(2.0), Tank(1.6), 0.0, {})),
              HasSubstr("sample time is 0"));
  EXPECT_THAT(
      error(ModelTrial::Create(Tank(2.0), Tank(1.6), 1.0, {.level = 1.0})),
      HasSubstr("level is 1; it must be in (0, 1)"));
  ProcessModel level = Tank(2.0);
  level.element(0, 0) = TransferFunction::Integrator(0.1, 1.0, 1.0);
  EXPECT_THAT(error(ModelTrial::Create(Tank(2.0), level, 1.0, {})),
              HasSubstr("integrat"));
  ProcessModel other("other", "min", {{.name = "steam"}}, {{.name = "heat"}});
  other.element(0, 0) = TransferFunction::FirstOrder(1.0, 1.0, 0.0);
  EXPECT_FALSE(ModelTrial::Create(Tank(2.0), other, 1.0, {}).ok());
  ModelTrial trial = MakeTrial(2.0, 1.6);
  Record record = RecordOf({.changes = 1}, 2);
  record.sample_time = 0.5;
  EXPECT_THAT(std::string(trial.Look(record).message()),
              HasSubstr("sample time of the record is 0.5"));
  record.sample_time = 1.0;
  record.set_points.resize(0, 0);
  EXPECT_THAT(std::string(trial.Look(record).message()),
              HasSubstr("have set points"));
}

}  // namespace
}  // namespace mle
