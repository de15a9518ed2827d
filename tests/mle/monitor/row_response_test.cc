#include "mle/monitor/row_response.h"

#include <algorithm>
#include <cmath>
#include <vector>

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
