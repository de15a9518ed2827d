// What the page of a study says first.

#include <string>
#include <vector>

#include "absl/strings/str_join.h"
#include "apps/experiment/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::experiment {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Mismatches and methods, all else single.
Campaign SomeCampaign(int mismatches, const std::vector<std::string>& methods) {
  Campaign campaign;
  campaign.methods.clear();
  for (int i = 0; i < mismatches; ++i) {
    campaign.mismatches.emplace_back().name = "case " + std::to_string(i);
  }
  for (const std::string& name : methods) {
    campaign.methods.push_back(*ParseMethod(name));
  }
  campaign.seeds = {1, 2, 3, 4};
  return campaign;
}

// A row for each scenario, with E before and then E of each method.
StudySummary SummaryOf(const std::vector<std::vector<double>>& scenarios) {
  StudySummary summary;
  for (std::size_t s = 0; s < scenarios.size(); ++s) {
    for (std::size_t m = 1; m < scenarios[s].size(); ++m) {
      Cell& cell = summary.cells.emplace_back();
      cell.number = static_cast<std::int64_t>(summary.cells.size()) - 1;
      cell.at.scenario.mismatch = static_cast<int>(s);
      cell.at.method = static_cast<int>(m) - 1;
      cell.runs = 4;
      summary.runs += 4;
      const auto set = [&](Metric metric, double value) {
        cell.metrics[static_cast<std::size_t>(metric)] =
            Describe(std::vector<double>(4, value), 0);
      };
      set(Metric::kInitialE, scenarios[s][0]);
      set(Metric::kE, scenarios[s][m]);
      cell.harmed = scenarios[s][m] > scenarios[s][0] ? 0.5 : 0.0;
    }
  }
  return summary;
}

std::string Text(const report::Verdict& verdict) {
  return absl::StrJoin(verdict.sentences, "\n");
}

TEST(StudyHeadlineTest, EveryCaseCloserIsGood) {
  const report::Verdict verdict =
      VerdictOf(SomeCampaign(1, {"arx:none"}), SummaryOf({{100.0, 5.0}}));
  EXPECT_EQ(verdict.badge, report::Badge::kGood);
  EXPECT_EQ(verdict.label, "closer");
  EXPECT_EQ(verdict.headline, "The correction ends closer to the plant");
  EXPECT_THAT(Text(verdict), HasSubstr("E from 100 to 5.00"));
  EXPECT_THAT(Text(verdict), HasSubstr("0 of 4 corrections (0 %)"));
}

TEST(StudyHeadlineTest, CasesThatEndFartherAreNamed) {
  const Campaign campaign = SomeCampaign(3, {"arx:none", "output_error"});
  const StudySummary summary =
      SummaryOf({{100.0, 5.0, 1.0}, {100.0, 200.0, 1.0}, {0.0, 3.0, 0.0}});
  const report::Verdict verdict = VerdictOf(campaign, summary);
  EXPECT_EQ(verdict.label, "mixed");
  EXPECT_EQ(verdict.headline,
            "Corrections end farther from the plant in 2 of 6 cases, closer in "
            "3");
  EXPECT_THAT(Text(verdict),
              HasSubstr("Farther: case 1, arx, no test; case 2, "));
  EXPECT_THAT(Text(verdict), HasSubstr("4 of 24 corrections (17 %)"));

  const std::vector<MethodTally> tallies = TallyMethods(campaign, summary);
  ASSERT_EQ(tallies.size(), 2u);
  EXPECT_EQ(tallies[0].closer, 1);
  EXPECT_EQ(tallies[0].farther, 2);
  EXPECT_EQ(tallies[0].closest, 0);
  // Without a mismatch there is no ratio.
  EXPECT_DOUBLE_EQ(tallies[0].worst_ratio, 2.0);
  EXPECT_EQ(tallies[1].closer, 2);
  EXPECT_EQ(tallies[1].unchanged, 1);
  EXPECT_EQ(tallies[1].closest, 3);
  EXPECT_EQ(tallies[1].harmed, 0.0);
  EXPECT_THAT(MethodTable(campaign, summary).rows[0],
              ElementsAre("arx, no test", "3", "1", "0", "2", "0", "200 %",
                          "200 %", "33.3 %"));
}

TEST(StudyHeadlineTest, NoCaseCloserWarns) {
  const report::Verdict verdict =
      VerdictOf(SomeCampaign(1, {"arx:none"}), SummaryOf({{1.0, 5.0}}));
  EXPECT_EQ(verdict.badge, report::Badge::kChanged);
  EXPECT_EQ(verdict.label, "farther");
}

TEST(StudyHeadlineTest, NothingComparedIsNotJudged) {
  EXPECT_EQ(VerdictOf(SomeCampaign(1, {"none"}), SummaryOf({{1.0, 1.0}})).label,
            "no correction");
  StudySummary failed = SummaryOf({{1.0, 5.0}});
  failed.failed = failed.runs;
  failed.cells[0].failed = 4;
  failed.cells[0].metrics.fill(Describe({}, 0));
  const report::Verdict verdict =
      VerdictOf(SomeCampaign(1, {"arx:none"}), failed);
  EXPECT_EQ(verdict.label, "failed");
  EXPECT_THAT(Text(verdict), Not(HasSubstr("corrections")));
  EXPECT_THAT(Text(verdict), HasSubstr("4 failed."));
}

TEST(StudyTablesTest, AColumnOfMethodsOnlyWhereTheyDiffer) {
  const StudySummary two = SummaryOf({{9.0, 1.0, 2.0}, {9.0, 3.0, 4.0}});
  const report::Table table =
      ErrorTable(SomeCampaign(2, {"arx:none", "output_error"}), two, {1, 2});
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.columns[1].header, "method");
  EXPECT_EQ(table.rows[0][1], "output_error");
  EXPECT_EQ(table.rows[1][0], "case 1");
  const report::Table one = ErrorTable(SomeCampaign(1, {"arx:none"}),
                                       SummaryOf({{9.0, 1.0}}), {0, 20});
  EXPECT_EQ(one.columns[1].header, "runs");
}

}  // namespace
}  // namespace mle::experiment
