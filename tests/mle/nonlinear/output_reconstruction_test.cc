#include "mle/nonlinear/output_reconstruction.h"

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kDeviation = 0.1;

// Bursts of up to ten samples off by 10 to 50 deviations to one side.
std::vector<Record> Spoil(std::vector<Record> records, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> size(10.0, 50.0);
  for (Record& record : records) {
    for (int k = 15; k + 40 < record.samples(); k += 40) {
      const double side = engine() % 2 == 0 ? kDeviation : -kDeviation;
      const int length = 1 + static_cast<int>(engine() % 10);
      const int first = k + static_cast<int>(engine() % 20);
      for (int i = first; i < first + length; ++i) {
        record.outputs(0, i) += side * size(engine);
      }
    }
  }
  return records;
}

struct Noisy {
  const char* name;
  double increment;
};

class MarkOutliersTest : public ::testing::TestWithParam<Noisy> {};

// Also where gains and dead times are not those of the model that is given, and
// under drift: all that was spoilt and hardly anything else.
TEST_P(MarkOutliersTest, FindsBurstsAndNothingElse) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::vector<Record> clean =
        MakeRecords(AgedPlant(), 400, seed,
                    {.variance = kDeviation * kDeviation,
                     .increment = GetParam().increment});
    const std::vector<Record> spoilt = Spoil(clean, seed);
    std::vector<Record> marked = spoilt;
    const auto report = MarkOutliers(TwoElements(), {}, {}, marked);
    ASSERT_TRUE(report.ok()) << report.status();
    int missed = 0;
    int wrong = 0;
    int found = 0;
    for (std::size_t r = 0; r < clean.size(); ++r) {
      EXPECT_EQ(marked[r].inputs, spoilt[r].inputs);
      for (int k = 0; k < clean[r].samples(); ++k) {
        const bool bad = spoilt[r].outputs(0, k) != clean[r].outputs(0, k);
        const bool is_marked = std::isnan(marked[r].outputs(0, k));
        missed += bad && !is_marked ? 1 : 0;
        wrong += !bad && is_marked ? 1 : 0;
        found += is_marked ? 1 : 0;
        if (!is_marked) {
          EXPECT_EQ(marked[r].outputs(0, k), spoilt[r].outputs(0, k));
        }
      }
    }
    EXPECT_EQ(missed, 0) << "seed " << seed;
    EXPECT_LE(wrong, 1) << "seed " << seed;
    EXPECT_EQ(report->marked[0], found);
    EXPECT_EQ(report->left[0], 0);
    EXPECT_LE(report->longest[0], 10 + wrong);
  }
}

INSTANTIATE_TEST_SUITE_P(Noise, MarkOutliersTest,
                         ::testing::Values(Noisy{"White", 0.0},
                                           Noisy{"Drifting", 1e-4}),
                         [](const auto& test) {
                           return std::string(test.param.name);
                         });

// Clean records stay as they are, where the plant's structure is another one
// too: five deviations are exceeded once in 1.7 million samples.
TEST(MarkOutliersInRecordsTest, LeavesCleanRecordsAlone) {
  ProcessModel second_order = AgedPlant();
  second_order.element(0, 1) = TransferFunction({-3.0}, {12.0, 8.0, 1.0}, 2.3);
  for (const ProcessModel& plant : {AgedPlant(), second_order}) {
    const std::vector<Record> clean =
        MakeRecords(plant, 400, 21, {.variance = kDeviation * kDeviation});
    std::vector<Record> marked = clean;
    const auto report = MarkOutliers(TwoElements(), {}, {}, marked);
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_EQ(report->marked[0], 0);
    EXPECT_EQ(marked[0].outputs, clean[0].outputs);
    EXPECT_EQ(marked[1].outputs, clean[1].outputs);
  }
}

// In other units the same samples.
TEST(MarkOutliersInRecordsTest, UnitsDoNotMatter) {
  const std::vector<Record> spoilt = Spoil(
      MakeRecords(AgedPlant(), 400, 31, {.variance = kDeviation * kDeviation}),
      31);
  std::vector<Record> marked = spoilt;
  ASSERT_TRUE(MarkOutliers(TwoElements(), {}, {}, marked).ok());
  const double unit = 1024.0;
  std::vector<Record> other = spoilt;
  ProcessModel model = TwoElements();
  model.element(0, 0) = TransferFunction::FirstOrder(2.0 * unit, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0 * unit, 6.0, 2.3);
  for (Record& record : other) record.outputs *= unit;
  ASSERT_TRUE(MarkOutliers(model, {}, {}, other).ok());
  for (std::size_t r = 0; r < marked.size(); ++r) {
    for (int k = 0; k < marked[r].samples(); ++k) {
      EXPECT_EQ(std::isnan(marked[r].outputs(0, k)),
                std::isnan(other[r].outputs(0, k)));
    }
  }
}

// What lasts is no outlier: it is left, and said to be.
TEST(MarkOutliersInRecordsTest, LongRowsAreLeft) {
  std::vector<Record> records = {MakeRecord(
      AgedPlant(), 400, 41, {.variance = kDeviation * kDeviation}, 0)};
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> size(20.0, 50.0);
  for (int k = 200; k < 206; ++k) {
    records[0].outputs(0, k) += kDeviation * size(engine);
  }
  const std::vector<Record> spoilt = records;
  const auto report = MarkOutliers(
      TwoElements(), {}, {.threshold = 5.0, .longest_burst = 5}, records);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->marked[0], 0);
  EXPECT_EQ(report->left[0], 6);
  EXPECT_EQ(records[0].outputs, spoilt[0].outputs);
  const auto as_long = MarkOutliers(
      TwoElements(), {}, {.threshold = 5.0, .longest_burst = 6}, records);
  ASSERT_TRUE(as_long.ok()) << as_long.status();
  EXPECT_EQ(as_long->marked[0], 6);
  EXPECT_EQ(as_long->left[0], 0);
}

// Without noise, and beginning at rest, the model knows what is missing.
TEST(FillOutputsTest, AnExactModelFillsExactly) {
  const ProcessModel plant = AgedPlant();
  const std::vector<Record> whole = {MakeRecord(plant, 300, 3, {}, 0)};
  std::vector<Record> records = whole;
  records[0].outputs.row(0).segment(120, 12).setConstant(kNaN);
  records[0].outputs(0, 200) = kNaN;
  const auto filled = FillOutputs(plant, {NoiseEstimate()}, 12, records);
  ASSERT_TRUE(filled.ok()) << filled.status();
  EXPECT_EQ(*filled, 13);
  EXPECT_LT((records[0].outputs - whole[0].outputs).cwiseAbs().maxCoeff(),
            1e-9 * whole[0].outputs.cwiseAbs().maxCoeff());
}

// Under noise and drift what is filled in errs by less than the noise of the
// sample it stands for, and by less than a line between the neighbours.
TEST(FillOutputsTest, ErrsByLessThanALine) {
  const ProcessModel plant = AgedPlant();
  const RecordNoise noise = {.variance = kDeviation * kDeviation,
                             .increment = 1e-5};
  double by_model = 0.0;
  double by_line = 0.0;
  int count = 0;
  for (unsigned seed = 50; seed < 56; ++seed) {
    RecordNoise drift = noise;
    drift.variance = 0.0;  // the same draws without the white part
    const Record signal = MakeRecord(plant, 400, seed, drift);
    const Record measured = MakeRecord(plant, 400, seed, noise);
    std::vector<Record> records = {measured};
    for (int k = 30; k < 360; k += 30) {
      records[0].outputs.row(0).segment(k, 10).setConstant(kNaN);
    }
    const NoiseEstimate estimate = {.variance = noise.variance,
                                    .ratio = noise.increment / noise.variance};
    ASSERT_TRUE(FillOutputs(plant, {estimate}, 10, records).ok());
    for (int k = 30; k < 360; k += 30) {
      for (int a = 0; a < 10; ++a) {
        const double line =
            measured.outputs(0, k - 1) +
            (measured.outputs(0, k + 10) - measured.outputs(0, k - 1)) *
                (a + 1) / 11.0;
        by_model += std::pow(
            records[0].outputs(0, k + a) - signal.outputs(0, k + a), 2);
        by_line += std::pow(line - signal.outputs(0, k + a), 2);
        ++count;
      }
    }
  }
  EXPECT_LT(std::sqrt(by_model / count), 0.7 * kDeviation);
  EXPECT_LT(by_model, 0.5 * by_line);
}

TEST(FillOutputsTest, LongGapsAndEndsStay) {
  const ProcessModel plant = AgedPlant();
  std::vector<Record> records = {MakeRecord(plant, 300, 3, {}, 0)};
  auto outputs = records[0].outputs.row(0);
  outputs.head(4).setConstant(kNaN);
  outputs.tail(3).setConstant(kNaN);
  outputs.segment(100, 6).setConstant(kNaN);
  const auto filled = FillOutputs(plant, {NoiseEstimate()}, 5, records);
  ASSERT_TRUE(filled.ok()) << filled.status();
  EXPECT_EQ(*filled, 0);
  EXPECT_EQ(records[0].outputs.array().isNaN().count(), 13);
}

// Between the samples at both ends of a gap a drift goes on.
TEST(FillOutputsTest, FollowsDriftAcrossAGap) {
  constexpr double kSlope = 0.05;  // a sample
  const ProcessModel plant = AgedPlant();
  Record whole = MakeRecord(plant, 300, 3, {}, 0);
  whole.outputs.row(0) += Eigen::RowVectorXd::LinSpaced(300, 0.0, 299 * kSlope);
  std::vector<Record> records = {whole};
  records[0].outputs.row(0).segment(150, 12).setConstant(kNaN);
  const NoiseEstimate quick = {.variance = 1e-4, .ratio = 100.0};
  ASSERT_TRUE(FillOutputs(plant, {quick}, 12, records).ok());
  EXPECT_LT((records[0].outputs - whole.outputs).cwiseAbs().maxCoeff(), kSlope);
}

// Inputs that are missing part a record: nothing is expected there, and each
// part has a level of its own.
TEST(ExpectedOutputsTest, IsNotKnownWithoutInputs) {
  const ProcessModel plant = AgedPlant();
  Record record = MakeRecord(plant, 300, 4, {.variance = 1e-4});
  record.inputs.row(0).segment(140, 3).setConstant(kNaN);
  record.outputs.rightCols(157).array() += 5.0;
  const auto expected = ExpectedOutputs(plant, {NoiseEstimate()}, record);
  ASSERT_TRUE(expected.ok()) << expected.status();
  EXPECT_EQ(expected->array().isNaN().count(), 3);
  EXPECT_TRUE(std::isnan((*expected)(0, 141)));
  const Eigen::MatrixXd errors = record.outputs - *expected;
  EXPECT_LT(errors.leftCols(140).cwiseAbs().mean(), 0.05);
  EXPECT_LT(errors.rightCols(100).cwiseAbs().mean(), 0.05);
}

TEST(ExpectedOutputsTest, OfNoSamplesIsEmpty) {
  Record record = MakeRecord(TwoElements(), 10, 4, {});
  record.outputs.resize(1, 0);
  record.inputs.resize(2, 0);
  const auto expected =
      ExpectedOutputs(TwoElements(), {NoiseEstimate()}, record);
  ASSERT_TRUE(expected.ok()) << expected.status();
  EXPECT_EQ(expected->rows(), 1);
  EXPECT_EQ(expected->cols(), 0);
}

TEST(ExpectedOutputsTest, SaysWhatIsWrong) {
  const ProcessModel model = TwoElements();
  const Record record = MakeRecord(model, 300, 4, {.variance = 1e-4});
  EXPECT_THAT(
      std::string(ExpectedOutputs(model, {}, record).status().message()),
      HasSubstr("noise is given for 0 outputs; the model has 1 and 2"));
  ProcessModel feedthrough = model;
  feedthrough.element(0, 1) = TransferFunction({1.0, 1.0}, {2.0, 1.0}, 0.0);
  EXPECT_THAT(
      std::string(ExpectedOutputs(feedthrough, {NoiseEstimate()}, record)
                      .status()
                      .message()),
      HasSubstr("element of output \"y0\", input \"u1\""));
  std::vector<Record> records = {record};
  EXPECT_THAT(std::string(FillOutputs(model, {NoiseEstimate()}, -1, records)
                              .status()
                              .message()),
              HasSubstr("max_gap is -1"));
  EXPECT_THAT(std::string(MarkOutliers(model, {}, {.threshold = 0.0}, records)
                              .status()
                              .message()),
              HasSubstr("threshold is 0"));
  EXPECT_THAT(std::string(MarkOutliers(model, {}, {.longest_burst = 0}, records)
                              .status()
                              .message()),
              HasSubstr("longest_burst is 0"));
}

}  // namespace
}  // namespace mle
