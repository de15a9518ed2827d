#include "mle/monitor/next_change.h"

#include <cmath>

#include "gtest/gtest.h"
#include "tests/mle/monitor/watched_tank.h"

namespace mle {
namespace {

using NextState = NextChange::State;

constexpr double kShare = 0.0125;

// The tank's watch with a reference of ten days.
class NextChangeTest : public ::testing::Test {
 protected:
  NextChangeTest() : watch_(MakeWatch()) {
    std::vector<WatchBatch> batches;
    for (std::uint64_t day = 0; day < 10; ++day) {
      batches.push_back(
          SimulateTankDay(TankModel(), {.seed = 100 + day}, watch_.lead()));
    }
    const absl::StatusOr<WatchReference> reference =
        watch_.MakeReference(batches);
    EXPECT_TRUE(reference.ok()) << reference.status();
    reference_ = *reference;
  }

  static ModelWatch MakeWatch() {
    absl::StatusOr<ModelWatch> watch =
        ModelWatch::Create(TankModel(), kTankSampleTime, WatchOptions());
    EXPECT_TRUE(watch.ok()) << watch.status();
    return *std::move(watch);
  }

  NextChange Find(const std::vector<ScoredOutput>& outputs, int last) const {
    const absl::StatusOr<NextChange> next = FindNextChange(
        watch_, reference_, outputs,
        {.last = last, .share_of_output = kShare, .share_of_element = kShare});
    EXPECT_TRUE(next.ok()) << next.status();
    return *next;
  }

  // Days of the information that moves of both inputs have.
  std::vector<ScoredOutput> Days(int days, double change) const {
    const auto informations =
        watch_.ExpectedInformation(reference_, Eigen::Vector2d(0.0, 1.0));
    EXPECT_TRUE(informations.ok()) << informations.status();
    const auto of_steam =
        watch_.ExpectedInformation(reference_, Eigen::Vector2d(1.0, 0.0));
    std::vector<ScoredOutput> outputs(2);
    for (std::size_t i = 0; i < 2; ++i) {
      for (int day = 0; day < days; ++day) {
        Eigen::MatrixXd information = (*informations)[i];
        if ((*of_steam)[i].size() > 0) information += (*of_steam)[i];
        const double size = i == 0 && 2 * day >= days ? change : 0.0;
        outputs[i].batches.push_back({.number = day,
                                      .length = 1,
                                      .score = size * information.col(0),
                                      .information = information});
      }
      outputs[i].evidence = ConfirmedEvidenceOf(
          outputs[i].batches, watch_.LeastChanges(static_cast<int>(i)),
          watch_.options());
    }
    return outputs;
  }

  ModelWatch watch_;
  WatchReference reference_;
};

TEST_F(NextChangeTest, ExpectedInformationIsThatOfRecords) {
  // A day in which the steam goes up and comes back is scored with as much.
  WatchBatch day =
      SimulateTankDay(TankModel(), {.moves = false, .seed = 5}, watch_.lead());
  const double step = 0.8;
  const int samples = day.record.samples();
  day.record.inputs.row(0).segment(watch_.lead() + 80, 100).setConstant(step);
  ASSERT_GT(samples, watch_.lead() + 250);
  const auto scores = watch_.Score(reference_, day);
  ASSERT_TRUE(scores.ok()) << scores.status();
  ASSERT_EQ(scores->outputs[0].state, BatchState::kUsed);
  const auto expected =
      watch_.ExpectedInformation(reference_, Eigen::Vector2d(step, 0.0));
  ASSERT_TRUE(expected.ok()) << expected.status();
  // The day's own noise may weigh less, by f of model_watch.h.
  const double ratio =
      scores->outputs[0].information(0, 0) / (*expected)[0](0, 0);
  EXPECT_GT(ratio, 0.6);
  EXPECT_LT(ratio, 1.2);
  EXPECT_EQ((*expected)[1].size(), 0);  // the heat does not depend on it
}

TEST_F(NextChangeTest, InformationGrowsWithTheSquareOfTheStep) {
  const auto one =
      watch_.ExpectedInformation(reference_, Eigen::Vector2d(0.5, 0.2));
  const auto two =
      watch_.ExpectedInformation(reference_, Eigen::Vector2d(1.0, 0.4));
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_TRUE((*two)[0].isApprox(4.0 * (*one)[0], 1e-6));
}

TEST_F(NextChangeTest, WithoutEvidenceAChangeIsProposed) {
  const NextChange next = Find(std::vector<ScoredOutput>(2), 9);
  ASSERT_EQ(next.state, NextState::kPropose);
  // Nothing is known of before either.
  EXPECT_EQ(next.question, NextChange::Question::kBaseline);
  EXPECT_EQ(next.parameter, 0);
  EXPECT_GT(next.size, 0.0);
  EXPECT_LE(next.size, reference_.high(next.set_point) -
                           reference_.low(next.set_point) + 1e-12);
  EXPECT_GE(next.changes, 2);  // one alone is no evidence
  EXPECT_EQ(next.log_evidence, 0.0);
  EXPECT_DOUBLE_EQ(next.log_alarm, -std::log(kShare));
  EXPECT_GE(next.log_expected, next.log_alarm);
}

TEST_F(NextChangeTest, WhereTenPercentWouldBeSeenNothingIsProposed) {
  EXPECT_EQ(Find(Days(40, 0.0), 39).state, NextState::kEnough);
  // The same days, of half a year ago.
  const NextChange next = Find(Days(40, 0.0), 220);
  ASSERT_EQ(next.state, NextState::kPropose);
  EXPECT_EQ(next.question, NextChange::Question::kUnseen);
}

TEST_F(NextChangeTest, OfALikelyChangeTheElementIsAskedFor) {
  std::vector<ScoredOutput> outputs = Days(12, -0.2);
  // Since the change both elements have been moved together.
  for (ScoredBatch& batch : outputs[0].batches) {
    if (batch.number < 6) continue;
    const Eigen::VectorXd along =
        Eigen::VectorXd::Unit(6, 0) + Eigen::VectorXd::Unit(6, 3);
    batch.information = 3000.0 * along * along.transpose();
    batch.score = -0.2 * batch.information.col(0);
  }
  outputs[0].evidence = ConfirmedEvidenceOf(
      outputs[0].batches, watch_.LeastChanges(0), watch_.options());
  ASSERT_GT(outputs[0].evidence.log_output, -std::log(kShare));
  ASSERT_LT(outputs[0].evidence.log_elements[0], -std::log(kShare));
  const NextChange next = Find(outputs, 11);
  ASSERT_EQ(next.state, NextState::kPropose);
  EXPECT_EQ(next.question, NextChange::Question::kLikely);
  EXPECT_EQ(next.output, 0);
  EXPECT_NEAR(next.log_evidence, outputs[0].evidence.log_elements[next.element],
              1e-9);
  EXPECT_GE(next.log_expected, next.log_alarm);
}

TEST_F(NextChangeTest, ANamedElementNeedsNoMore) {
  std::vector<ScoredOutput> outputs = Days(40, -0.3);
  ASSERT_GT(outputs[0].evidence.log_elements[0], -std::log(kShare));
  EXPECT_EQ(Find(outputs, 39).state, NextState::kNamed);
}

TEST_F(NextChangeTest, WhereNoSetPointCanMoveNothingIsProposed) {
  reference_.low = reference_.high;
  EXPECT_EQ(Find(std::vector<ScoredOutput>(2), 9).state, NextState::kNoneTells);
}

TEST_F(NextChangeTest, AReferenceOfAnotherModelIsRefused) {
  reference_.outputs.pop_back();
  EXPECT_FALSE(FindNextChange(watch_, reference_, std::vector<ScoredOutput>(2),
                              NextChangeOptions())
                   .ok());
}

}  // namespace
}  // namespace mle
