#include "apps/experiment/summary.h"

#include <string>
#include <vector>

#include "apps/experiment/campaign_json.h"
#include "apps/experiment/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {
namespace {

using ::testing::HasSubstr;

class SummaryTest : public ::testing::Test {
 protected:
  StudySummary SummaryOf(const std::function<void(Row&)>& fill) const {
    return *Summarise(campaign_, grid_, [&](std::int64_t run) {
      Row row;
      row.run = run;
      row[Metric::kInitialE] = 100.0;
      row[Metric::kE] = 10.0 + static_cast<double>(run);
      row[Metric::kBestE] = 8.0;
      row[Metric::kRatio] = row[Metric::kE] / 8.0;
      row[Metric::kLambdaMin] = row[Metric::kLambdaMax] = 1e-4;
      row[Metric::kBestLambda] = 2e-5 * static_cast<double>(run + 1);
      row[Metric::kGap] = 1e-11;
      fill(row);
      return row;
    });
  }

  const ScratchFolder scratch_;
  const Campaign campaign_ = *ParseCampaign(SmallCampaign(4).dump(), "c.json");
  const Grid grid_{campaign_};
};

TEST_F(SummaryTest, CellByCell) {
  const StudySummary summary = SummaryOf([](Row& row) {
    if (row.run == 1) row.status = "failed: a loop at 12.5 of 1e+30";
    if (row.run == 6) row.status = "failed: a loop at 3 of 4e-7";
    if (row.run == 7) row[Metric::kE] = 150.0;
  });
  EXPECT_EQ(summary.runs, 8);
  EXPECT_EQ(summary.failed, 2);
  ASSERT_EQ(summary.failures.size(), 1U);
  EXPECT_EQ(summary.failures.at("failed: a loop at # of #"), 2);
  EXPECT_EQ(summary.max_gap, 1e-11);
  ASSERT_EQ(summary.cells.size(), 2U);
  const Cell& gain = summary.cells[0];
  EXPECT_EQ(gain.runs, 4);
  EXPECT_EQ(gain.failed, 1);
  EXPECT_EQ(gain[Metric::kE].count, 3);
  EXPECT_DOUBLE_EQ(gain[Metric::kE].mean, (10.0 + 12.0 + 13.0) / 3.0);
  EXPECT_EQ(gain.harmed, 0.0);
  EXPECT_EQ(gain.above_twice_best, 0.0);
  EXPECT_EQ(gain[Metric::kPValue].count, 0);
  // Runs 4, 5 and 7: E of 14, 15 and 150.
  EXPECT_DOUBLE_EQ(summary.cells[1].harmed, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(summary.cells[1].above_twice_best, 1.0 / 3.0);
}

TEST_F(SummaryTest, FilesSayTheSame) {
  const StudySummary summary = SummaryOf([](Row&) {});
  const nlohmann::json json =
      nlohmann::json::parse(SummaryJson(summary, campaign_));
  EXPECT_EQ(json["version"], 1);
  ASSERT_EQ(json["cells"].size(), 2U);
  EXPECT_EQ(json["cells"][1]["mismatch"], "delay");
  scratch_.Write("summary.csv", SummaryCsv(summary, campaign_));
  const auto lines = ParsedCsv(scratch_ / "summary.csv");
  int compared = 0;
  const auto column = [&](const std::string& name) {
    return std::find(lines[0].begin(), lines[0].end(), name) - lines[0].begin();
  };
  for (std::size_t i = 1; i < lines.size(); ++i) {
    ASSERT_EQ(lines[i].size(), lines[0].size());
    const nlohmann::json& metric = json["cells"][std::stoi(lines[i][0])]
                                       ["metrics"][lines[i][column("metric")]];
    for (const char* value : {"mean", "q05", "median", "max"}) {
      EXPECT_EQ(std::stod(lines[i][column(value)]), metric[value]);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 2 * 8 * 4);
}

TEST_F(SummaryTest, FiguresAreValid) {
  const StudySummary summary = SummaryOf([](Row&) {});
  const std::vector<report::NamedFigure> figures =
      MakeFigures(campaign_, summary);
  ASSERT_EQ(figures.size(), 1U);
  for (const report::NamedFigure& figure : figures) {
    EXPECT_TRUE(figure.figure.Validate().ok()) << figure.name;
    EXPECT_EQ(figure.figure.panels.size(), 2U) << figure.name;
  }
}

// Without λ, or where every run failed, there is less to draw, or nothing.
TEST_F(SummaryTest, FiguresOfLittle) {
  const auto figures = MakeFigures(
      campaign_, SummaryOf([](Row& row) { row[Metric::kBestE] = NAN; }));
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(figures[0].name, "distribution");
  const StudySummary failed =
      SummaryOf([](Row& row) { row.status = "failed"; });
  EXPECT_EQ(failed.failed, 8);
  EXPECT_TRUE(MakeFigures(campaign_, failed).empty());
  EXPECT_THAT(SummaryCsv(failed, campaign_), testing::Not(HasSubstr("nan")));
  EXPECT_THAT(SummaryJson(failed, campaign_), testing::Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace mle::experiment
