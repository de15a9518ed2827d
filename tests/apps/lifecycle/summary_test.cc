#include "apps/lifecycle/summary.h"

#include <cmath>

#include "gtest/gtest.h"

namespace mle::lifecycle {
namespace {

using Eigen::VectorXd;

control::Prices SomePrices() {
  control::Prices prices;
  prices.squared_error = VectorXd::Constant(1, 60.0);
  prices.absolute_error = VectorXd::Constant(1, 6.0);
  prices.violation = VectorXd::Constant(1, 600.0);
  prices.movement = VectorXd::Constant(1, 0.5);
  prices.test_hour = 10.0;
  prices.engineer_hour = 100.0;
  prices.hours_per_update = 0.5;
  prices.hours_per_test = 8.0;
  return prices;
}

ChangeRow Row(double squared_error, Outcome outcome, double test_time) {
  ChangeRow row;
  row.event = {100.0, 0, VectorXd::Zero(1), VectorXd::Ones(1)};
  row.quiet = control::OperationSums::Zero(1, 1);
  row.transient = control::OperationSums::Zero(1, 1);
  row.test = control::OperationSums::Zero(1, 1);
  row.watch = control::OperationSums::Zero(1, 1);
  row.transient.squared_error[0] = squared_error;
  row.test.time = test_time;
  row.outcome = outcome;
  return row;
}

// One life of one change.
Life LifeOf(double squared_error, Outcome outcome = Outcome::kNone,
            double test_time = 0.0) {
  return {.rows = {Row(squared_error, outcome, test_time)}, .ended = ""};
}

TEST(PricesTest, EveryPartHasItsPrice) {
  ChangeRow row = Row(10.0, Outcome::kUpdated, 0.0);
  row.quiet.absolute_error[0] = 20.0;
  row.quiet.violation[0] = 3.0;
  row.transient.movement[0] = 4.0;
  const control::Cost cost = CostOf(row, SomePrices(), 1.0 / 60.0);
  EXPECT_DOUBLE_EQ(cost.product, 10.0 + 2.0);
  EXPECT_DOUBLE_EQ(cost.violation, 30.0);
  EXPECT_DOUBLE_EQ(cost.movement, 2.0);
  EXPECT_DOUBLE_EQ(cost.engineering, 50.0);
  EXPECT_DOUBLE_EQ(cost.test_hours, 0.0);
  row.test.time = 120.0;
  const control::Cost tested = CostOf(row, SomePrices(), 1.0 / 60.0);
  EXPECT_DOUBLE_EQ(tested.test_hours, 20.0);
  EXPECT_DOUBLE_EQ(tested.engineering, 800.0);
  row.test.time = 0.0;
  row.outcome = Outcome::kNoChange;
  EXPECT_EQ(CostOf(row, SomePrices(), 1.0).engineering, 0.0);
}

TEST(SummaryTest, IntervalsAreStudents) {
  // Of 1, 2, 3: deviation 1, t₂(0.975) = 4.3027.
  const MeanOfSeeds mean = MeanWithInterval({1.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(mean.mean, 2.0);
  EXPECT_NEAR(mean.half_width, 4.302653 / std::sqrt(3.0), 1e-5);
  EXPECT_TRUE(std::isnan(MeanWithInterval({5.0}).half_width));
}

class SummaryOfThreeTest : public ::testing::Test {
 protected:
  SummaryOfThreeTest() {
    campaign_.policies = *ParsePolicies("never,output_error:1,test:12,perfect");
    campaign_.rates = {1.0};
    campaign_.seeds = {1, 2, 3};
    // The seeds differ by far more than the policies.
    for (const double base : {0.0, 500.0, 1000.0}) {
      lives_.front().push_back({LifeOf(base + 400.0),
                                LifeOf(base + 250.0, Outcome::kUpdated),
                                LifeOf(base + 210.0, Outcome::kUpdated, 120.0),
                                LifeOf(base + 200.0)});
    }
  }

  std::vector<RateSummary> Summaries(double test_hour) const {
    Valuation valuation = {SomePrices(), 1.0 / 60.0, 2.0};
    valuation.prices.test_hour = test_hour;
    return Summarise(campaign_, lives_, valuation);
  }

  Campaign campaign_;
  Lives lives_ = Lives(1);
};

TEST_F(SummaryOfThreeTest, SavingsAreComparedSeedBySeed) {
  const RateSummary rate = Summaries(10.0).front();
  const PolicySummary& output_error = rate.policies[1];
  // 150 of squared error at 60 an hour, less 50 for an engineer, in two years.
  EXPECT_NEAR(output_error.saving.mean, 0.5 * (150.0 - 50.0), 1e-9);
  EXPECT_NEAR(output_error.saving.half_width, 0.0, 1e-9);
  EXPECT_GT(output_error.cost.half_width, 100.0);
  EXPECT_NEAR(output_error.share_saved, 100.0 / 200.0, 1e-12);
  EXPECT_NEAR(rate.policies[3].share_saved, 1.0, 1e-12);
  EXPECT_EQ(output_error.updates, 1.0);
  EXPECT_EQ(rate.policies[2].tests, 1.0);
  EXPECT_EQ(rate.Cheapest()->policy.name, "output_error:1");
}

// The differences have intervals of their own, although the seeds differ by far
// more than the policies.
TEST_F(SummaryOfThreeTest, PoliciesAreToldApartFromTheCheapestByPairs) {
  // Seed by seed never costs 50, 54 and 46 a year more.
  lives_[0][1][0] = LifeOf(500.0 + 408.0);
  lives_[0][2][0] = LifeOf(1000.0 + 392.0);
  RateSummary rate = Summaries(10.0).front();
  ASSERT_EQ(rate.Cheapest()->policy.name, "output_error:1");
  EXPECT_NEAR(rate.policies[0].over_cheapest.mean, 50.0, 1e-9);
  // Deviation 4, t₂(0.975) = 4.3027.
  EXPECT_NEAR(rate.policies[0].over_cheapest.half_width,
              4.302653 * 4.0 / std::sqrt(3.0), 1e-4);
  EXPECT_TRUE(ToldApart(rate.policies[0].over_cheapest));
  EXPECT_GT(rate.policies[0].cost.half_width, 100.0);
  EXPECT_EQ(rate.policies[1].over_cheapest.mean, 0.0);
  EXPECT_EQ(rate.policies[1].over_cheapest.half_width, 0.0);
  EXPECT_LT(rate.policies[3].over_cheapest.mean, 0.0);
  // The same mean, of 50, 100 and 0.
  lives_[0][1][0] = LifeOf(500.0 + 500.0);
  lives_[0][2][0] = LifeOf(1000.0 + 300.0);
  rate = Summaries(10.0).front();
  EXPECT_NEAR(rate.policies[0].over_cheapest.mean, 50.0, 1e-9);
  EXPECT_FALSE(ToldApart(rate.policies[0].over_cheapest));
}

TEST(SummaryTest, DifferencesWithoutIntervalAreNotToldApart) {
  EXPECT_TRUE(ToldApart({3.0, 2.9}));
  EXPECT_TRUE(ToldApart({-3.0, 2.9}));
  EXPECT_FALSE(ToldApart({3.0, 3.0}));
  EXPECT_FALSE(ToldApart({0.0, 0.0}));
  EXPECT_FALSE(ToldApart({3.0, std::nan("")}));
  EXPECT_FALSE(ToldApart({std::nan(""), std::nan("")}));
}

TEST_F(SummaryOfThreeTest, AtTheBreakEvenPriceBothWaysCostTheSame) {
  const BreakEven found = Summaries(10.0).front().break_even;
  EXPECT_EQ(found.test, "test:12");
  EXPECT_EQ(found.correction, "output_error:1");
  // It does not depend on the price that was assumed.
  EXPECT_NEAR(Summaries(77.0).front().break_even.price, found.price, 1e-9);
  const RateSummary there = Summaries(found.price).front();
  EXPECT_NEAR(there.policies[1].cost.mean, there.policies[2].cost.mean, 1e-9);
}

TEST_F(SummaryOfThreeTest, ALoopThatRanAwayHasNoCost) {
  lives_[0][1][0].ended = "ran away";
  const RateSummary rate = Summaries(10.0).front();
  EXPECT_TRUE(std::isnan(rate.policies[0].cost.mean));
  EXPECT_EQ(rate.policies[0].ran_away, 1);
  EXPECT_TRUE(std::isnan(rate.policies[1].saving.mean));
  EXPECT_EQ(rate.Cheapest()->policy.name, "output_error:1");
}

}  // namespace
}  // namespace mle::lifecycle
