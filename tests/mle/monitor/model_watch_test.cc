#include "mle/monitor/model_watch.h"

#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/QR"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/mle/monitor/watched_tank.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ModelWatch WatchOf(const ProcessModel& model,
                   const WatchOptions& options = {}) {
  absl::StatusOr<ModelWatch> watch =
      ModelWatch::Create(model, kTankSampleTime, options);
  EXPECT_TRUE(watch.ok()) << watch.status();
  return *std::move(watch);
}

class ModelWatchTest : public ::testing::Test {
 protected:
  explicit ModelWatchTest(const ProcessModel& model = TankModel())
      : model_(model), watch_(WatchOf(model_)) {
    std::vector<WatchBatch> days;
    for (std::uint64_t seed = 101; seed <= 110; ++seed) {
      days.push_back(Day(model_, {.moves = seed % 2 == 0, .seed = seed}));
    }
    absl::StatusOr<WatchReference> reference = watch_.MakeReference(days);
    EXPECT_TRUE(reference.ok()) << reference.status();
    reference_ = *std::move(reference);
  }

  WatchBatch Day(const ProcessModel& truth, const TankDay& day) const {
    return SimulateTankDay(truth, day, watch_.lead());
  }
  BatchScores Score(WatchBatch batch) const {
    absl::StatusOr<BatchScores> scores =
        watch_.Score(reference_, std::move(batch));
    EXPECT_TRUE(scores.ok()) << scores.status();
    return *std::move(scores);
  }

  const ProcessModel model_;
  const ModelWatch watch_;
  WatchReference reference_;
};

TEST_F(ModelWatchTest, TheReferenceHasTheNoise) {
  for (const OutputReference& output : reference_.outputs) {
    // 5 % is three standard deviations of a variance from 2,900 samples.
    EXPECT_NEAR(output.noise.variance, kTankNoise * kTankNoise,
                0.1 * kTankNoise * kTankNoise);
    EXPECT_NEAR(output.deviation, 1.0, 0.1);
    EXPECT_NEAR(output.covariances.front(), 1.0, 0.15);
  }
  EXPECT_EQ(watch_.inputs(0), (std::vector<int>{0, 1}));
  EXPECT_EQ(watch_.inputs(1), (std::vector<int>{1}));
}

// Two changes a day, one up and one down, errors of noise between them.
TEST_F(ModelWatchTest, TheReferenceHasHowThePlantRan) {
  EXPECT_THAT(reference_.operation, ::testing::IsEmpty());
  std::vector<WatchBatch> days;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) {
    WatchBatch day = Day(model_, {.moves = false, .seed = seed});
    day.record.set_points.setZero(2, day.record.samples());
    auto moved = day.record.set_points.row(1);
    moved.segment(watch_.lead() + 30, 100).setConstant(0.5);
    // Before the day: another's.
    moved(3) = 1.0;
    day.record.outputs.row(1) += moved;
    days.push_back(std::move(day));
  }
  const absl::StatusOr<WatchReference> reference = watch_.MakeReference(days);
  ASSERT_TRUE(reference.ok()) << reference.status();
  ASSERT_EQ(reference->operation.size(), 2U);
  const OutputOperation& still = reference->operation[0];
  const OutputOperation& moved = reference->operation[1];
  EXPECT_EQ(still.changes, 0.0);
  EXPECT_EQ(moved.changes, 2.0);
  EXPECT_DOUBLE_EQ(moved.change_size, 0.5);
  for (const OutputOperation& output : reference->operation) {
    ASSERT_TRUE(output.squared_error.has_value());
    EXPECT_NEAR(*output.squared_error, kTankNoise * kTankNoise,
                0.1 * kTankNoise * kTankNoise);
  }
}

TEST_F(ModelWatchTest, ADayWithoutChangesSaysNothing) {
  const BatchScores scores = Score(Day(model_, {.moves = false, .seed = 5}));
  EXPECT_EQ(scores.state, BatchState::kNothingMoved);
  EXPECT_TRUE(scores.Reasons().empty());
}

// S is N(0, V) where nothing has changed, N(Vδ, V) after a change δ: over the
// seeds 1 to 60, of what `score` makes of each.
template <typename Score>
void ExpectNormalAbout(double relative_gain, const Score& score) {
  Eigen::VectorXd change = Eigen::VectorXd::Zero(6);
  change(0) = relative_gain;
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const BatchOutput output = score(seed);
    ASSERT_EQ(output.state, BatchState::kUsed) << output.reason;
    const Eigen::VectorXd off = output.score - output.information * change;
    squares += off.dot(output.information.ldlt().solve(off));
    count += 6;
  }
  // χ²/ν of ν = 360 is within 0.22 of 1 by three standard deviations; scores
  // are allowed for more variance than they have.
  EXPECT_GT(squares / count, 0.6) << relative_gain;
  EXPECT_LT(squares / count, 1.22) << relative_gain;
}

TEST_F(ModelWatchTest, ScoresAreNormalAboutTheChange) {
  for (const double gain : {0.0, 0.05}) {
    ProcessModel plant = model_;
    plant.element(0, 0) =
        TransferFunction::FirstOrder(2.0 * (1.0 + gain), 20.0, 10.0);
    ExpectNormalAbout(gain, [&](std::uint64_t seed) {
      return Score(Day(plant, {.seed = seed})).outputs[0];
    });
  }
}

// The first output is a level that steam fills, by a flow whose balance drifts
// from day to day.
class LevelWatchTest : public ModelWatchTest {
 protected:
  static ProcessModel Filled(double gain) {
    ProcessModel model = TankModel();
    model.element(0, 0) = TransferFunction::Integrator(gain, 10.0, 5.0);
    return model;
  }
  LevelWatchTest() : ModelWatchTest(Filled(0.02)) {}

  BatchOutput ScoreLevel(double gain, std::uint64_t seed) const {
    // Even: into the range of the reference.
    WatchBatch day = Day(Filled(gain), {.seed = 2 * seed});
    const double balance = 0.003 * (static_cast<double>(seed % 7) - 3.0);
    for (int k = 0; k < day.record.samples(); ++k) {
      day.record.outputs(0, k) += balance * k;
    }
    return Score(std::move(day)).outputs[0];
  }
};

TEST_F(LevelWatchTest, ScoresAreNormalAboutTheChange) {
  for (const double gain : {0.0, 0.05}) {
    ExpectNormalAbout(gain, [&](std::uint64_t seed) {
      return ScoreLevel(0.02 * (1.0 + gain), seed);
    });
  }
}

double SizeOf(const Eigen::VectorXd& score,
              const Eigen::MatrixXd& information) {
  return score.dot(information.completeOrthogonalDecomposition().solve(score));
}

// Two changes a day between which the plant settles: what one of them says is
// known beside both.
TEST_F(ModelWatchTest, TheLargestChangeOfADayIsKept) {
  ProcessModel aged = model_;
  aged.element(0, 0) = TransferFunction::FirstOrder(1.0, 20.0, 10.0);
  const BatchOutput output = Score(Day(aged, {.seed = 3})).outputs[0];
  ASSERT_TRUE(output.largest.has_value());
  const Eigen::VectorXd rest = output.score - output.largest->score;
  const Eigen::MatrixXd known =
      output.information - output.largest->information;
  // The other has its own evidence: χ² of six degrees would be 38 once in 10⁶.
  const double others = SizeOf(rest, known);
  EXPECT_GT(others, 38.0);
  EXPECT_LT(others, SizeOf(output.largest->score, output.largest->information));
  EXPECT_FALSE(Score(Day(model_, {.seed = 3})).outputs[0].largest.has_value());
}

// A level that creeps beside one change, which no few steps describe, says
// nothing about the other: they do not confirm each other.
TEST_F(ModelWatchTest, ChangesThatDisagreeAreNotToldApart) {
  WatchBatch day = Day(model_, {.seed = 3});
  for (int k = 0; k < 60; ++k) {
    day.record.outputs.row(0).tail(288 - 20 - k).array() += 1.5 / 60.0;
  }
  const BatchOutput output = Score(std::move(day)).outputs[0];
  ASSERT_EQ(output.state, BatchState::kUsed) << output.reason;
  // It is large: χ² of six degrees would be 38 once in 10⁶.
  EXPECT_GT(SizeOf(output.score, output.information), 38.0);
  EXPECT_FALSE(output.largest.has_value());
}

TEST_F(ModelWatchTest, WhatIsDisturbedCannotBeTold) {
  WatchBatch day = Day(model_, {.seed = 3});
  for (int k = 0; k < day.record.samples(); ++k) {
    day.record.outputs(1, k) += 0.2 * std::sin(0.7 * k);
  }
  const BatchScores scores = Score(std::move(day));
  EXPECT_EQ(scores.outputs[0].state, BatchState::kUsed);
  EXPECT_EQ(scores.outputs[1].state, BatchState::kCannotTell);
  EXPECT_THAT(scores.outputs[1].reason, HasSubstr("heat is disturbed"));
  EXPECT_EQ(scores.state, BatchState::kUsed);
}

TEST_F(ModelWatchTest, AnotherOperatingPointCannotBeTold) {
  const BatchScores scores = Score(Day(model_, {.level = 20.0, .seed = 3}));
  EXPECT_EQ(scores.state, BatchState::kCannotTell);
  EXPECT_THAT(scores.Reasons().front(), HasSubstr("operating point"));
}

// Two records that were joined: elements have not aged by that.
TEST_F(ModelWatchTest, ARecordThatHasChangedCannotBeTold) {
  WatchBatch day = Day(model_, {.seed = 3});
  day.record.outputs.leftCols(day.first + 100).array() += 0.8;
  day.record.inputs.leftCols(day.first + 100).array() += 0.5;
  const BatchScores scores = Score(day);
  EXPECT_EQ(scores.state, BatchState::kCannotTell);
  EXPECT_THAT(scores.Reasons().front(), HasSubstr("The records have changed"));
}

TEST_F(ModelWatchTest, SingleOutliersSayLittle) {
  WatchBatch day = Day(model_, {.seed = 3});
  const BatchScores clean = Score(day);
  day.record.outputs(1, day.first + 200) += 1.0;
  const BatchScores spoilt = Score(day);
  ASSERT_EQ(spoilt.outputs[1].state, BatchState::kUsed);
  const Eigen::VectorXd moved =
      spoilt.outputs[1].score - clean.outputs[1].score;
  // Less than two standard deviations of the score.
  EXPECT_LT(moved.dot(clean.outputs[1].information.ldlt().solve(moved)), 4.0);
}

TEST_F(ModelWatchTest, WrongArgumentsAreNamed) {
  EXPECT_THAT(ModelWatch::Create(model_, 0.0, {}).status().message(),
              HasSubstr("sample time"));
  EXPECT_THAT(
      ModelWatch::Create(model_, 1.0, {.level = 0.0}).status().message(),
      HasSubstr("level = 0"));
  ProcessModel slow = TankModel();
  slow.element(1, 1) = TransferFunction::FirstOrder(0.5, 5e9, 5.0);
  EXPECT_THAT(std::string(ModelWatch::Create(slow, 1.0, {}).status().message()),
              HasSubstr("more than 1e+06 samples of 1;"));
  EXPECT_THAT(watch_.MakeReference({}).status().message(), HasSubstr("none"));
  EXPECT_EQ(NameOf(BatchState::kCannotTell), "cannot_tell");
}

}  // namespace
}  // namespace mle
