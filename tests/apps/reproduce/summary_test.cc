#include "apps/reproduce/summary.h"

#include <cmath>
#include <string>
#include <vector>

#include "apps/report/table.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/reproduce/example_case.h"

namespace mle::reproduce {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(SummariseCase, GathersTheRuns) {
  CaseResult result = ExampleCase();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  EXPECT_EQ(result.E_star.mean, 3.5);
  EXPECT_EQ(result.E_star.max, 4.0);
  EXPECT_EQ(result.E_zero.mean, 20.0);
  EXPECT_EQ(result.E_oracle.mean, 1.5);
  EXPECT_EQ(result.lambda_star.min, 2e-4);
  EXPECT_EQ(result.lambda_star.max, 4e-4);
  EXPECT_EQ(result.max_relative_gap, 3e-11);
}

TEST(SummariseCase, HoldsThePairsAgainstThePlant) {
  CaseResult result = ExampleCase();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  ASSERT_EQ(result.elements.size(), 6u);
  // Root mean squares of (0.3, −0.4), (0.6, 0.8) and (0.5, 0.5).
  for (const ElementErrors& errors : result.elements) {
    EXPECT_NEAR(errors.static_gain_error_rms, std::sqrt(0.125), 1e-14);
    EXPECT_NEAR(errors.fopdt_gain_error_rms, std::sqrt(0.5), 1e-13);
    EXPECT_NEAR(errors.fopdt_delay_error_rms, 0.5, 1e-14);
    EXPECT_EQ(errors.delay_impulse_peak_mean, 3.0);
  }
  EXPECT_EQ(result.elements[0].initial_gain, 11.0);
  EXPECT_EQ(result.elements[0].true_gain, 10.0);
  EXPECT_EQ(result.elements[0].initial_delay, 2.0);
  EXPECT_EQ(result.elements[0].true_delay, 5.0);
  EXPECT_EQ(result.elements[2].true_gain, 13.0);  // (0, 2)
  EXPECT_EQ(result.elements[4].true_gain, 22.0);  // (1, 1)
  EXPECT_EQ(result.elements[1].true_gain, 0.0);   // absent
  EXPECT_EQ(result.elements[1].true_delay, 0.0);
}

TEST(SummariseCase, AnElementOfHigherOrderHasTheDeadTimeOfItsFit) {
  CaseResult result = ExampleCase();
  // 1/((3s + 1)(2s + 1)) with 1 s of dead time looks like more.
  result.plant.element(1, 1) = TransferFunction({1.0}, {6.0, 5.0, 1.0}, 1.0);
  result.truth = result.plant.ComputeStepResponse(0.5, 41);
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  EXPECT_GT(result.elements[4].true_delay, 1.5);
  EXPECT_LT(result.elements[4].true_delay, 1.0 + 2.0);  // the smaller constant
}

TEST(Tables, HaveARowForEveryPair) {
  CaseResult result = ExampleCase();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  const report::Table gains = GainTable(result);
  const report::Table delays = DelayTable(result);
  ASSERT_EQ(gains.rows.size(), 6u);
  ASSERT_EQ(delays.rows.size(), 6u);
  EXPECT_EQ(gains.rows[0][0], "(1,1) y ← u, 1");
  EXPECT_EQ(gains.rows[0][1], "11.0 → 10.0");
  EXPECT_EQ(gains.rows[2][1], "13.0");
  EXPECT_EQ(delays.rows[0][1], "2.00 → 5.00");
  for (const report::Table* table : {&gains, &delays}) {
    for (const std::vector<std::string>& row : table->rows) {
      EXPECT_EQ(row.size(), table->columns.size());
    }
  }
  EXPECT_THAT(delays.caption, HasSubstr("(s)"));
}

TEST(Tables, ThePapersFiguresAreForItsOwnCases) {
  CaseResult result = ExampleCase();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  EXPECT_THAT(report::RenderText(GainTable(result)), Not(HasSubstr("0.0933")));
  result.from_paper = true;
  EXPECT_THAT(report::RenderText(GainTable(result)), HasSubstr("0.0933"));
}

TEST(Tables, ThePaperIsConfronted) {
  CaseResult result = ExampleCase();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  EXPECT_TRUE(PaperTable({result}).rows.empty());
  result.from_paper = true;
  const report::Table table = PaperTable({result});
  ASSERT_EQ(table.rows.size(), 3u);  // λ* and two gains
  EXPECT_EQ(table.rows[0][1], "about 1×10⁻³");
  EXPECT_EQ(table.rows[0][2], "2.0×10⁻⁴ … 4.0×10⁻⁴");
  EXPECT_EQ(table.rows[1][1], "0.0933");
  EXPECT_EQ(table.rows[1][2], "0.30 … 0.40");
  EXPECT_THAT(table.rows[1][3], HasSubstr("lies among these"));
  // A decision that the paper leaves open, and where it leads.
  AblationResult& ablation = result.ablations.emplace_back();
  ablation.ablation = experiment::FindAblation("noise_free_conversion");
  ablation.runs.push_back({.E = 778.0, .lambda = 1.6e-3});
  EXPECT_THAT(PaperTable({result}).rows[0][3],
              HasSubstr("without noise: 0.0016 (E 778)"));
}

TEST(Tables, OfOneRunShowItsValues) {
  CaseResult result = ExampleCase();
  result.runs.pop_back();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  const report::Table table = DistanceTable(result);
  EXPECT_EQ(table.columns.size(), 3u);
  EXPECT_EQ(table.rows[0].back(), "100.00");
  EXPECT_EQ(table.rows[1].back(), "3.00");
  // One value is not a range.
  EXPECT_EQ(table.rows[1][1], Extremes(result.lambda_star));
  EXPECT_THAT(table.rows[1][1], Not(HasSubstr("…")));
}

}  // namespace
}  // namespace mle::reproduce
