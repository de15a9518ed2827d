#include "mle/data/lagged_series.h"

#include <limits>
#include <random>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {

// For messages and for comparisons of whole lists.
bool operator==(const RowRange& a, const RowRange& b) {
  return a.first == b.first && a.last == b.last;
}
void PrintTo(const RowRange& range, std::ostream* out) {
  *out << range.first << " … " << range.last;
}

namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Record RandomRecord(int outputs, int inputs, int samples) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Record record;
  record.sample_time = 1.0;
  record.outputs.resize(outputs, samples);
  record.inputs.resize(inputs, samples);
  for (double& value : record.outputs.reshaped()) value = normal(random);
  for (double& value : record.inputs.reshaped()) value = normal(random);
  return record;
}

// z_k, less the offset.
Eigen::VectorXd Sample(const Record& record, int k,
                       const Eigen::VectorXd& offset = {}) {
  Eigen::VectorXd z(record.num_outputs() + record.num_inputs());
  z << record.outputs.col(k), record.inputs.col(k);
  if (offset.size() > 0) z -= offset;
  return z;
}

TEST(LaggedSeriesTest, ViewsAreTheLaggedSamplesLatestFirst) {
  const Record record = RandomRecord(2, 3, 20);
  const Eigen::VectorXd offset = Eigen::VectorXd::LinSpaced(5, -3.0, 7.0);
  for (const Eigen::VectorXd& off : {Eigen::VectorXd(), offset}) {
    const LaggedSeries series(record, 4, off);
    EXPECT_EQ(series.order(), 4);
    EXPECT_EQ(series.num_channels(), 5);
    EXPECT_EQ(series.num_regressors(), 20);
    EXPECT_EQ(series.samples(), 20);
    for (const RowRange rows : {RowRange{4, 19}, {4, 4}, {19, 19}, {7, 12}}) {
      const auto regressors = series.Regressors(rows);
      const auto outputs = series.Outputs(rows);
      const auto lagged = series.Samples(rows, 3);
      ASSERT_EQ(regressors.cols(), rows.rows());
      ASSERT_EQ(regressors.rows(), 20);
      ASSERT_EQ(outputs.cols(), rows.rows());
      ASSERT_EQ(lagged.cols(), rows.rows());
      for (int i = 0; i < rows.rows(); ++i) {
        const int k = rows.last - i;
        Eigen::VectorXd x(20);
        for (int lag = 1; lag <= 4; ++lag) {
          x.segment(5 * (lag - 1), 5) = Sample(record, k - lag, off);
        }
        // Copies and one subtraction each: equal to the bit.
        EXPECT_EQ(regressors.col(i), x) << "row " << k;
        EXPECT_EQ(outputs.col(i), Sample(record, k, off).head(2));
        EXPECT_EQ(lagged.col(i), Sample(record, k - 3, off));
      }
    }
  }
}

TEST(LaggedSeriesTest, AllRowsOfGoodDataAreUsable) {
  EXPECT_THAT(LaggedSeries(RandomRecord(1, 1, 10), 3).UsableRows(),
              ElementsAre(RowRange{3, 9}));
  EXPECT_THAT(LaggedSeries(RandomRecord(1, 1, 4), 3).UsableRows(),
              ElementsAre(RowRange{3, 3}));
  EXPECT_THAT(LaggedSeries(RandomRecord(1, 1, 3), 3).UsableRows(), IsEmpty());
}

TEST(LaggedSeriesTest, ABadOutputSpoilsItsRowAndThoseThatLookBackAtIt) {
  Record record = RandomRecord(2, 1, 20);
  record.outputs(1, 8) = kNaN;
  EXPECT_THAT(LaggedSeries(record, 3).UsableRows(),
              ElementsAre(RowRange{3, 7}, RowRange{12, 19}));
}

TEST(LaggedSeriesTest, ABadInputSpoilsOnlyTheRowsThatLookBackAtIt) {
  Record record = RandomRecord(2, 2, 20);
  record.inputs(1, 8) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(LaggedSeries(record, 3).UsableRows(),
              ElementsAre(RowRange{3, 8}, RowRange{12, 19}));
  record.inputs(0, 19) = kNaN;
  EXPECT_THAT(LaggedSeries(record, 3).UsableRows(),
              ElementsAre(RowRange{3, 8}, RowRange{12, 19}));
}

TEST(LaggedSeriesTest, UsableRowsAgreeWithTheirDefinition) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    Record record = RandomRecord(2, 2, 40);
    for (int i = 0; i < trial % 7; ++i) {
      auto& values = random() % 2 == 0 ? record.outputs : record.inputs;
      values(random() % 2, random() % 40) = kNaN;
    }
    const int order = 1 + trial % 4;
    const LaggedSeries series(record, order);
    std::vector<bool> usable(40, false);
    int last = -2;
    for (const RowRange range : series.UsableRows()) {
      EXPECT_GT(range.first, last + 1) << "two ranges that belong together";
      last = range.last;
      for (int k = range.first; k <= range.last; ++k) usable[k] = true;
    }
    for (int k = 0; k < 40; ++k) {
      bool good = k >= order && record.outputs.col(k).allFinite();
      for (int lag = 1; lag <= order && good; ++lag) {
        good = Sample(record, k - lag).allFinite();
      }
      EXPECT_EQ(usable[k], good) << "sample " << k << ", order " << order;
    }
  }
}

TEST(ChannelMeansTest, AreOverTheGoodSamplesOfAllRecords) {
  Record a = RandomRecord(1, 2, 3);
  a.outputs << 1.0, kNaN, 3.0;
  a.inputs << 5.0, 5.0, 5.0, kNaN, kNaN, kNaN;
  Record b = a;
  b.outputs.setConstant(1, 1, 8.0);
  b.inputs.resize(2, 1);
  b.inputs << -3.0, kNaN;
  // (1 + 3 + 8)/3; (5·3 − 3)/4; none good.
  EXPECT_EQ(ChannelMeans({a, b}), Eigen::Vector3d(4.0, 3.0, 0.0));
  EXPECT_EQ(ChannelMeans({}).size(), 0);
}

// Taken off, the mean of a held channel must leave zeros, not its rounding.
TEST(ChannelMeansTest, OfAHeldChannelIsItsValueToTheBit) {
  Record record;
  record.sample_time = 1.0;
  record.outputs.setZero(1, 50000);
  for (const double value : {96.1, 1.0 / 3.0, -7e8 / 11.0, 1e-9 / 7.0}) {
    record.inputs.setConstant(1, 50000, value);
    EXPECT_EQ(ChannelMeans({record})(1), value);
  }
}

}  // namespace
}  // namespace mle
