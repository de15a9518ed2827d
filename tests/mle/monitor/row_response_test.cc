#include "mle/monitor/row_response.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/mle/monitor/watched_tank.h"

namespace mle {
namespace {

constexpr int kSkip = 45;  // samples until the slowest element has settled

// White noise of deviation 1 about a free offset.
NoiseEstimate PlainNoise() {
  NoiseEstimate noise;
  noise.variance = 1.0;
  return noise;
}

std::vector<WhitenedRun> Whiten(const ProcessModel& model,
                                const Record& record) {
  const absl::StatusOr<RowResponse> row =
      RowResponse::Create(model, 0, kTankSampleTime, kSkip);
  EXPECT_TRUE(row.ok()) << row.status();
  return row->Whiten(record, PlainNoise());
}

// The innovations move by the sensitivities times the change of a parameter.
TEST(RowResponseTest, SensitivitiesAreDerivatives) {
  const ProcessModel model = TankModel();
  const Record record = SimulateTankDay(model, {.seed = 1}, 100).record;
  const WhitenedRun right = Whiten(model, record).front();
  ASSERT_EQ(right.sensitivities.cols(), 6);
  const auto innovations = [&](double gain, double time, double delay) {
    ProcessModel wrong = model;
    wrong.element(0, 0) = TransferFunction::FirstOrder(gain, time, delay);
    return Whiten(wrong, record).front().innovations;
  };
  constexpr double kStep = 1e-4;
  // A gain is linear; the error of the derivative by ln T is of the order of
  // the step squared; by dead times it is the secant over ± half a sample.
  const Eigen::VectorXd by_gain =
      (innovations(2.0, 20.0, 10.0) - innovations(2.2, 20.0, 10.0)) / 0.1;
  const Eigen::VectorXd by_time =
      (innovations(2.0, 20.0 * std::exp(-kStep), 10.0) -
       innovations(2.0, 20.0 * std::exp(kStep), 10.0)) /
      (2.0 * kStep);
  const Eigen::VectorXd by_delay =
      (innovations(2.0, 20.0, 7.5) - innovations(2.0, 20.0, 12.5)) /
      (5.0 / 15.0);
  EXPECT_LT((by_gain - right.sensitivities.col(0)).norm(), 1e-9);
  EXPECT_LT((by_time - right.sensitivities.col(1)).norm(), 1e-5);
  EXPECT_LT((by_delay - right.sensitivities.col(2)).norm(), 1e-9);
}

TEST(RowResponseTest, NothingIsLeftOfTheModelsOwnResponse) {
  const ProcessModel model = TankModel();
  Record record = SimulateTankDay(model, {.seed = 2}, 100).record;
  const Record again = SimulateTankDay(model, {.seed = 4}, 100).record;
  // The inputs are the same for even seeds, the noise is not.
  record.outputs -= again.outputs;
  record.inputs.setZero();
  EXPECT_NEAR(
      Whiten(model, record).front().innovations.norm() / std::sqrt(343.0 * 2.0),
      kTankNoise, 0.2 * kTankNoise);
}

TEST(RowResponseTest, EachGroupHasAnOffsetOfItsOwn) {
  const ProcessModel model = TankModel();
  Record record = SimulateTankDay(model, {.seed = 2}, 100).record;
  std::vector<int> groups(record.samples(), 0);
  std::fill(groups.begin() + 200, groups.end(), 1);
  const absl::StatusOr<RowResponse> row =
      RowResponse::Create(model, 0, kTankSampleTime, kSkip);
  ASSERT_TRUE(row.ok()) << row.status();
  const std::vector<WhitenedRun> before =
      row->Whiten(record, PlainNoise(), groups);
  ASSERT_EQ(before.size(), 2);
  EXPECT_EQ(before[0].group, 0);
  EXPECT_EQ(before[1].group, 1);
  record.outputs.rightCols(record.samples() - 200).array() += 3.0;
  const std::vector<WhitenedRun> after =
      row->Whiten(record, PlainNoise(), groups);
  for (int g = 0; g < 2; ++g) {
    EXPECT_LT((after[g].innovations - before[g].innovations).norm(), 1e-9);
  }
  // Where they are one, the jump is seen.
  EXPECT_GT((row->Whiten(record, PlainNoise()).front().innovations).norm(),
            5.0);
}

// With steps looked for, in units of the noise.
std::vector<WhitenedRun> WhitenWithSteps(const ProcessModel& model,
                                         const Record& record) {
  const absl::StatusOr<RowResponse> row =
      RowResponse::Create(model, 0, kTankSampleTime, kSkip);
  EXPECT_TRUE(row.ok()) << row.status();
  return row->Whiten(record, PlainNoise(), {}, kTankNoise);
}

TEST(RowResponseTest, StepsOfTheLevelAreFree) {
  const ProcessModel model = TankModel();
  for (const double lag : {0.0, 4.0}) {
    Record record = SimulateTankDay(model, {.seed = 5}, 100).record;
    const WhitenedRun without = WhitenWithSteps(model, record).front();
    // Nothing is found where there is nothing.
    ASSERT_EQ(without.innovations.size(), record.samples() - kSkip - 1);
    const int from = 260;
    for (int k = from; k < record.samples(); ++k) {
      record.outputs(0, k) +=
          lag > 0.0 ? -0.2 * std::expm1(-(k - from + 1) / lag) : 0.2;
    }
    const WhitenedRun with = WhitenWithSteps(model, record).front();
    EXPECT_EQ(with.innovations.size(), without.innovations.size() - 1);
    const auto score = [](const WhitenedRun& run) -> Eigen::VectorXd {
      return run.sensitivities.transpose() * run.innovations /
             (kTankNoise * run.sensitivities.colwise().norm().maxCoeff());
    };
    const double moved = (score(with) - score(without)).norm();
    EXPECT_LT(moved, 3.0) << lag;
    const WhitenedRun taken = Whiten(model, record).front();
    EXPECT_GT((score(taken) - score(without)).norm(), 5.0 * moved) << lag;
  }
}

// An element that has aged, by a third of its gain, and what the linear change
// does not explain of a time constant, are no steps.
TEST(RowResponseTest, AgeingIsNotTakenForSteps) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    for (const TransferFunction& element :
         {TransferFunction::FirstOrder(1.4, 20.0, 10.0),
          TransferFunction::FirstOrder(2.0, 26.0, 10.0)}) {
      ProcessModel aged = TankModel();
      aged.element(0, 0) = element;
      const Record record = SimulateTankDay(aged, {.seed = seed}, 100).record;
      const WhitenedRun all = Whiten(TankModel(), record).front();
      const WhitenedRun run = WhitenWithSteps(TankModel(), record).front();
      const auto size = [](const WhitenedRun& of) {
        const Eigen::VectorXd score =
            of.sensitivities.transpose() * of.innovations;
        return score.dot((of.sensitivities.transpose() * of.sensitivities)
                             .ldlt()
                             .solve(score));
      };
      EXPECT_GT(size(run), 0.6 * size(all)) << seed;
    }
  }
}

// A level: steam fills it, with a lag; feed heats as before.
ProcessModel LevelModel(double gain = 0.02, double time = 20.0,
                        double delay = 10.0) {
  ProcessModel model = TankModel();
  model.element(0, 0) = TransferFunction::Integrator(gain, time, delay);
  return model;
}

TEST(RowResponseTest, OfALevelTheBalanceIsFree) {
  Record record = SimulateTankDay(LevelModel(), {.seed = 3}, 100).record;
  const WhitenedRun before = Whiten(LevelModel(), record).front();
  // Another balance, and another level.
  for (int k = 0; k < record.samples(); ++k) {
    record.outputs(0, k) += 4.0 - 0.7 * k;
  }
  record.inputs.row(0).array() += 2.0;
  const WhitenedRun after = Whiten(LevelModel(), record).front();
  ASSERT_EQ(after.innovations.size(), before.innovations.size());
  EXPECT_EQ(before.innovations.size(), record.samples() - kSkip - 2);
  EXPECT_LT((after.innovations - before.innovations).norm(), 1e-8);
  EXPECT_LT((after.sensitivities - before.sensitivities).norm(),
            1e-8 * before.sensitivities.norm());
  // What is left is the noise alone.
  EXPECT_NEAR(before.innovations.norm() /
                  std::sqrt(static_cast<double>(before.innovations.size())),
              kTankNoise, 0.2 * kTankNoise);
}

TEST(RowResponseTest, SensitivitiesOfALevelAreDerivatives) {
  const Record record = SimulateTankDay(LevelModel(), {.seed = 1}, 100).record;
  const WhitenedRun right = Whiten(LevelModel(), record).front();
  const auto innovations = [&](double gain, double time, double delay) {
    return Whiten(LevelModel(gain, time, delay), record).front().innovations;
  };
  constexpr double kStep = 1e-4;
  const Eigen::VectorXd by_gain =
      (innovations(0.02, 20.0, 10.0) - innovations(0.022, 20.0, 10.0)) / 0.1;
  const Eigen::VectorXd by_time =
      (innovations(0.02, 20.0 * std::exp(-kStep), 10.0) -
       innovations(0.02, 20.0 * std::exp(kStep), 10.0)) /
      (2.0 * kStep);
  const Eigen::VectorXd by_delay =
      (innovations(0.02, 20.0, 7.5) - innovations(0.02, 20.0, 12.5)) /
      (5.0 / 15.0);
  EXPECT_GT(by_gain.norm(), 1.0);
  EXPECT_LT((by_gain - right.sensitivities.col(0)).norm(), 1e-9);
  EXPECT_LT((by_time - right.sensitivities.col(1)).norm(), 1e-5);
  EXPECT_LT((by_delay - right.sensitivities.col(2)).norm(), 1e-9);
}

// What an anytime-valid test rests on: nothing depends on samples to come.
TEST(RowResponseTest, InnovationsOfALevelAreOfThePast) {
  Record record = SimulateTankDay(LevelModel(), {.seed = 3}, 100).record;
  const WhitenedRun before = Whiten(LevelModel(), record).front();
  const int from = 250;
  record.outputs.rightCols(record.samples() - from).array() += 9.0;
  const WhitenedRun after = Whiten(LevelModel(), record).front();
  const int kept = from - kSkip - 2;
  EXPECT_EQ(after.innovations.head(kept), before.innovations.head(kept));
  EXPECT_GT(std::abs(after.innovations(kept) - before.innovations(kept)), 1.0);
}

TEST(RowResponseTest, UnitsOfDeadTimes) {
  const absl::StatusOr<RowResponse> row =
      RowResponse::Create(TankModel(), 1, kTankSampleTime, kSkip);
  ASSERT_TRUE(row.ok());
  EXPECT_EQ(row->inputs(), std::vector<int>{1});
  // max(5, 40/5, 3 · 5).
  EXPECT_EQ(row->units()(2), 15.0);
  EXPECT_EQ(row->units()(0), 1.0);
}

}  // namespace
}  // namespace mle
