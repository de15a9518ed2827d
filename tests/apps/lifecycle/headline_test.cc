// What the page of lives says first.

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_join.h"
#include "apps/lifecycle/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::lifecycle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// A policy with its cost, and with what it costs more than the cheapest.
PolicySummary CostingMore(const std::string& policy, double cost,
                          MeanOfSeeds over_cheapest) {
  PolicySummary summary;
  summary.policy = ParsePolicies(policy)->front();
  summary.cost = {cost, 100.0};
  summary.over_cheapest = over_cheapest;
  summary.saving = {1000.0 - cost, over_cheapest.half_width};
  summary.excess = {cost - 100.0, 1.0};
  summary.share_saved = (1000.0 - cost) / 900.0;
  return summary;
}

RateSummary RateOf(std::vector<PolicySummary> policies, double rate = 1.0) {
  RateSummary summary;
  summary.rate = rate;
  summary.policies = std::move(policies);
  return summary;
}

// Corrections save 600 a year, beyond chance; tests may be as good.
RateSummary UpdatesPay() {
  RateSummary rate = RateOf({CostingMore("never", 1000.0, {600.0, 50.0}),
                             CostingMore("output_error:3", 400.0, {0.0, 0.0}),
                             CostingMore("test:12", 450.0, {50.0, 80.0}),
                             CostingMore("test:1", 5450.0, {5050.0, 80.0}),
                             CostingMore("perfect", 100.0, {-300.0, 20.0})});
  rate.policies[1].saving.half_width = 50.0;
  return rate;
}

report::Verdict Verdict(const std::vector<RateSummary>& summaries,
                        std::size_t lives = 5,
                        const std::string& currency = "EUR") {
  Campaign campaign;
  campaign.seeds.resize(lives);
  return VerdictOf(campaign, summaries,
                   {.prices = {}, .years = 5.0, .currency = currency});
}

std::string Text(const report::Verdict& verdict) {
  return absl::StrJoin(verdict.sentences, "\n");
}

TEST(HeadlineTest, AnUpdateThatPaysIsAnInstruction) {
  const report::Verdict verdict = Verdict({UpdatesPay()});
  EXPECT_EQ(verdict.badge, report::Badge::kChanged);
  EXPECT_EQ(verdict.headline,
            "Correct the model after every 3rd set-point change");
  const std::string text = Text(verdict);
  EXPECT_THAT(text, HasSubstr("saves 600 ± 50.0 EUR a year"));
  EXPECT_THAT(text, HasSubstr("67 % of what a perfect model"));
  EXPECT_THAT(text, HasSubstr("Cannot be told apart from the cheapest: step "
                              "test every 12 months."));
  EXPECT_THAT(text, HasSubstr("5 lives of 5 years"));
  EXPECT_THAT(Text(Verdict({UpdatesPay()}, 5, "")),
              HasSubstr("saves 600 ± 50.0 a year"));
}

TEST(HeadlineTest, NeverMayBeCheapest) {
  const report::Verdict verdict =
      Verdict({RateOf({CostingMore("never", 1000.0, {0.0, 0.0}),
                       CostingMore("output_error:1", 1200.0, {200.0, 50.0})})});
  EXPECT_EQ(verdict.badge, report::Badge::kGood);
  EXPECT_THAT(verdict.headline, StartsWith("Leave the model as it is"));
  EXPECT_THAT(Text(verdict), Not(HasSubstr("saves")));
}

// The model that costs the same is the one that is there.
TEST(HeadlineTest, ATieKeepsTheModel) {
  const RateSummary rate =
      RateOf({CostingMore("output_error:1", 1000.0, {0.0, 0.0}),
              CostingMore("never", 1000.0, {0.0, 0.0})});
  EXPECT_EQ(AnswerAt(rate), Answer::kKeep);
}

TEST(HeadlineTest, AnIntervalThatHoldsZeroCannotTell) {
  RateSummary rate = RateOf({CostingMore("never", 1000.0, {100.0, 200.0}),
                             CostingMore("output_error:1", 900.0, {0.0, 0.0})});
  rate.policies[1].saving = {100.0, 200.0};
  const report::Verdict verdict = Verdict({rate});
  EXPECT_EQ(verdict.badge, report::Badge::kUnknown);
  EXPECT_EQ(verdict.label, "cannot tell");
  // Twice the interval of what would do: four times the lives.
  EXPECT_THAT(Text(verdict), HasSubstr("--seeds=20"));
  EXPECT_THAT(Text(verdict), HasSubstr("as it is for now"));
}

TEST(HeadlineTest, OneLifeCannotTell) {
  RateSummary rate = UpdatesPay();
  for (PolicySummary& policy : rate.policies) {
    policy.cost.half_width = policy.over_cheapest.half_width = kNaN;
    policy.saving.half_width = kNaN;
  }
  const report::Verdict verdict = Verdict({rate}, 1);
  EXPECT_EQ(verdict.label, "cannot tell");
  EXPECT_THAT(verdict.headline, HasSubstr("one life"));
  EXPECT_THAT(Text(verdict), HasSubstr("--seeds=5"));
}

TEST(HeadlineTest, ALoopThatDivergesWithoutUpdatesAsksForThem) {
  RateSummary rate = UpdatesPay();
  rate.policies[0].cost = rate.policies[0].over_cheapest = {kNaN, kNaN};
  rate.policies[0].ran_away = 2;
  rate.policies[1].saving = {kNaN, kNaN};
  const report::Verdict verdict = Verdict({rate});
  EXPECT_EQ(verdict.label, "update");
  EXPECT_THAT(Text(verdict), HasSubstr("diverged in 2 of 5 lives"));
}

TEST(HeadlineTest, WhatWasNotComparedIsNotAnswered) {
  const RateSummary possible =
      RateOf({CostingMore("never", 1000.0, {0.0, 0.0}),
              CostingMore("perfect", 100.0, {-900.0, 20.0})});
  EXPECT_EQ(AnswerAt(possible), Answer::kNoUpdates);
  EXPECT_THAT(Text(Verdict({possible})),
              HasSubstr("would save 900 ± 20.0 EUR"));
  const RateSummary without =
      RateOf({CostingMore("output_error:1", 900.0, {0.0, 0.0}),
              CostingMore("test:1", 1900.0, {1000.0, 10.0})});
  EXPECT_EQ(AnswerAt(without), Answer::kNoNever);
  EXPECT_THAT(Text(Verdict({without})), HasSubstr("Add never"));
  RateSummary diverged = without;
  for (PolicySummary& policy : diverged.policies) {
    policy.cost = {kNaN, kNaN};
    policy.ran_away = 1;
  }
  EXPECT_EQ(AnswerAt(diverged), Answer::kDiverged);
}

TEST(HeadlineTest, TheRateNearestToOneAnswersAndTheOthersFollow) {
  RateSummary slow =
      RateOf({CostingMore("never", 1000.0, {0.0, 0.0}),
              CostingMore("output_error:3", 1200.0, {200.0, 50.0})},
             0.5);
  const std::vector<RateSummary> summaries = {slow, UpdatesPay()};
  EXPECT_EQ(&NominalRate(summaries), &summaries[1]);
  const report::Verdict verdict = Verdict(summaries);
  EXPECT_EQ(verdict.label, "update");
  EXPECT_THAT(Text(verdict), HasSubstr("at 0.5: leave the model as it is"));
}

}  // namespace
}  // namespace mle::lifecycle
