// Records whose rows are finer or coarser than the samples, or stand at other
// times than these.

#include <cmath>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// White noise sampled R times as often has a variance R times smaller, for odd
// R exactly white; a slow signal passes with its timing.
TEST(HistorianResamplingTest, FinerRecordsAreAveragedWithoutDelay) {
  for (const int ratio : {2, 4, 5, 25}) {
    std::mt19937_64 engine(ratio);
    std::normal_distribution<double> normal;
    std::string text = "time,level,steam\n";
    std::string noise = "time,level,steam\n";
    for (int k = 0; k <= 2000 * ratio; ++k) {
      const double time = static_cast<double>(k) / ratio;
      absl::StrAppend(&text, time, ",", std::sin(0.05 * time), ",", k / ratio,
                      "\n");
      absl::StrAppend(&noise, time, ",", normal(engine), ",0\n");
    }
    HistorianOptions options;
    options.sample_time = 1.0;
    const HistorianImport import = ImportOk(text, options);
    const Record& record = import.records[0];
    EXPECT_TRUE(import.report.averaged);
    // The input of the last row's sample is not known to its end.
    EXPECT_EQ(record.samples(), 2000);
    for (int k = 1; k < 2000; ++k) {
      // The mean of a sine about its middle: smaller by (0.05)²/24.
      ASSERT_NEAR(record.outputs(0, k), std::sin(0.05 * k), 2e-4) << k;
      ASSERT_NEAR(record.inputs(0, k), k, 1e-9) << k;
    }
    const Eigen::RowVectorXd mean =
        ImportOk(noise, options).records[0].outputs.row(0).segment(1, 1999);
    const double variance = mean.squaredNorm() / 1999.0;
    const double expected =
        ratio % 2 == 1 ? 1.0 / ratio : (ratio - 0.5) / (ratio * ratio);
    EXPECT_NEAR(variance / expected, 1.0, 0.12) << ratio;
    if (ratio % 2 == 1) {
      const double product = mean.head(1998).dot(mean.tail(1998)) / 1998.0;
      EXPECT_NEAR(product / variance, 0.0, 4.0 / std::sqrt(1998.0));
    }
  }
}

// Rows that do not divide a sample count by the time they stand for: an input
// from its row to the next in [k, k + 1), an output as far as half the way to
// its neighbours in [k − ½, k + ½).
TEST(HistorianResamplingTest, MeansAreOverTime) {
  std::string text = "time,level,steam\n";
  for (int row = 0; row <= 40; ++row) {
    absl::StrAppend(&text, 0.4 * row, ",", row * row, ",", row * row, "\n");
  }
  HistorianOptions options;
  options.sample_time = 1.0;
  const HistorianImport import = ImportOk(text, options);
  EXPECT_TRUE(import.report.averaged);
  const Record& record = import.records[0];
  // Samples 1 and 2, from rows at 0.4, 0.8, 1.2, …
  EXPECT_NEAR(record.inputs(0, 1), 0.2 * 4 + 0.4 * 9 + 0.4 * 16, 1e-9);
  EXPECT_NEAR(record.inputs(0, 2), 0.4 * 25 + 0.4 * 36 + 0.2 * 49, 1e-9);
  EXPECT_NEAR(record.outputs(0, 1), 0.1 * 1 + 0.4 * 4 + 0.4 * 9 + 0.1 * 16,
              1e-9);
  EXPECT_NEAR(record.outputs(0, 2), 0.3 * 16 + 0.4 * 25 + 0.3 * 36, 1e-9);
}

TEST(HistorianResamplingTest, UnevenRowsAreInterpolatedAndInputsHeld) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  std::string text = "time,level,steam\n";
  for (int k = 0; k < 1000; ++k) {
    const double time = k + (k == 0 ? 0.0 : uniform(engine));
    absl::StrAppend(&text, time, ",", 3.0 * time, ",", k < 500 ? 1 : 2, "\n");
  }
  HistorianOptions options;
  options.sample_time = 1.0;
  const HistorianImport import = ImportOk(text, options);
  ASSERT_EQ(import.records.size(), 1u);
  const Record& record = import.records[0];
  EXPECT_EQ(import.report.num_gaps, 0);
  for (int k = 0; k < record.samples(); ++k) {
    // Six digits in the text.
    ASSERT_NEAR(record.outputs(0, k), 3.0 * k, 0.05) << k;
    if (k < 498 || k > 501) {
      ASSERT_EQ(record.inputs(0, k), k < 500 ? 1.0 : 2.0) << k;
    }
  }
}

TEST(HistorianResamplingTest, CoarserRowsAreInterpolatedWithAWarning) {
  HistorianOptions options;
  options.sample_time = 0.25;
  const HistorianImport import =
      ImportOk("time,level,steam\n0,0,1\n1,4,2\n2,0,3\n", options);
  EXPECT_THAT(RowOf(import.records[0].outputs),
              ElementsAre(0, 1, 2, 3, 4, 3, 2, 1, 0));
  EXPECT_THAT(RowOf(import.records[0].inputs),
              ElementsAre(1, 1, 1, 1, 2, 2, 2, 2, 3));
  ASSERT_EQ(import.report.warnings.size(), 1u);
  EXPECT_THAT(import.report.warnings[0], HasSubstr("interpolated"));
  options.sample_time = 1e-9;
  EXPECT_THAT(Error("time,level,steam\n0,0,1\n1,4,2\n2,0,3\n", options),
              HasSubstr("rows are 1 apart"));
}

// Stamps that are late are shifted, by parts of a sample too.
TEST(HistorianResamplingTest, DeclaredLatenessIsTakenOff) {
  std::string text = "time,level,level_setpoint,steam\n";
  for (int k = 0; k < 12; ++k) {
    absl::StrAppend(&text, k, ",", 10 + k, ",", k, ",", 100 + k, "\n");
  }
  HistorianOptions options;
  options.columns.tags = {{"level", "level"}, {"steam", "steam"}};
  options.columns.tags[0].sampling = Sampling{.late_by = 2.5};
  options.columns.tags[1].sampling = Sampling{.late_by = -1.0};
  const HistorianImport import = ImportOk(text, options);
  ASSERT_EQ(import.records.size(), 1u);
  const Record& record = import.records[0];
  ASSERT_EQ(record.samples(), 12);
  for (int k = 1; k < 9; ++k) {
    EXPECT_DOUBLE_EQ(record.outputs(0, k), 12.5 + k);
    EXPECT_EQ(record.inputs(0, k), 99.0 + k);
    EXPECT_EQ(record.set_points(0, k), k);
  }
  EXPECT_THAT(record.outputs(0, 10), IsNan());
  ASSERT_EQ(import.report.notes.size(), 2u);
  EXPECT_EQ(import.report.notes[0].text,
            "level: as declared, taken 2.5 min earlier than its stamps.");
}

// Means of what lies between rows stand in the middle of it, half a step from
// the rows; those of inputs are held over it.
TEST(HistorianResamplingTest, DeclaredMeansStandInTheMiddle) {
  for (const bool at_end : {true, false}) {
    std::string text = "time,level,steam\n";
    for (int k = 0; k < 12; ++k) {
      absl::StrAppend(&text, 10 * k, ",", 10 + k, ",", 100 + k, "\n");
    }
    ProcessModel tank("tank", "min", {{"steam", ""}}, {{"level", ""}});
    const Sampling means = {.average = 10.0, .stamped_at_end = at_end};
    tank = ProcessModel("tank", "min", {{"steam", "", {}, means}},
                        {{"level", "", means}});
    const auto import = Import(text, {}, tank);
    ASSERT_TRUE(import.ok()) << import.status();
    const Record& record = import->records[0];
    EXPECT_EQ(record.sample_time, 5.0);
    const int shift = at_end ? 1 : 0;  // rows
    for (int k = 2; k < 16; ++k) {
      const int row = k / 2;
      EXPECT_EQ(record.inputs(0, k), 100.0 + row + shift);
      if (k % 2 == 1) {
        EXPECT_EQ(record.outputs(0, k), 10.0 + row + shift);
      } else {
        EXPECT_THAT(record.outputs(0, k), IsNan());
      }
    }
  }
}

// A laboratory's sample is that of the nearest sample, in finer records too.
TEST(HistorianResamplingTest, DeclaredPointsAreKeptAsTheyAre) {
  std::string text = "time,level,steam\n";
  for (int k = 0; k < 60; ++k) {
    absl::StrAppend(&text, k, ",", k % 20 == 7 ? absl::StrCat(k) : "", ",1\n");
  }
  HistorianOptions options;
  options.sample_time = 4.0;
  options.empty_fields = EmptyFields::kBad;
  options.columns.tags = {{"level", "level"}};
  options.columns.tags[0].sampling = Sampling{.period = 20.0, .late_by = 2.0};
  const Record record = ImportOk(text, options).records[0];
  for (int k = 0; k < record.samples(); ++k) {
    if (k % 5 == 1) {
      EXPECT_EQ(record.outputs(0, k), 4.0 * (k - 1) + 7.0) << k;
    } else {
      EXPECT_THAT(record.outputs(0, k), IsNan()) << k;
    }
  }
}

}  // namespace
}  // namespace mle
