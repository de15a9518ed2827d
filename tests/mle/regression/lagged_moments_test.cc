#include "mle/regression/lagged_moments.h"

#include <deque>
#include <random>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "mle/regression/lagged_products.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

struct Shape {
  int outputs;
  int inputs;
  int order;
  int responses;
};

// Series of random samples with an offset, cut into rows.
class Rows {
 public:
  explicit Rows(Shape shape) : shape_(shape) {}

  // Adds a series and the ranges of its rows.
  void Add(int samples, const std::vector<RowRange>& ranges) {
    Record record;
    record.sample_time = 1.0;
    record.outputs = RandomMatrix(shape_.outputs, samples, random_);
    record.outputs.array() += 1.5;
    record.inputs = 3.0 * RandomMatrix(shape_.inputs, samples, random_);
    series_.emplace_back(record, shape_.order);
    for (const RowRange range : ranges) {
      rows_.push_back({&series_.back(), range,
                       RandomMatrix(shape_.responses, range.rows(), random_)});
    }
  }

  const std::vector<RegressionRows>& rows() const { return rows_; }

 private:
  Shape shape_;
  std::mt19937_64 random_{1};
  std::deque<LaggedSeries> series_;
  std::vector<RegressionRows> rows_;
};

// The same sums with X formed.
LaggedMoments Dense(absl::Span<const RegressionRows> rows) {
  const int n = rows.front().series->num_regressors();
  const int q = static_cast<int>(rows.front().responses.rows());
  LaggedMoments sums = LaggedMoments::Zero(n, q);
  for (const RegressionRows& part : rows) {
    const Eigen::MatrixXd X = part.series->Regressors(part.rows);
    sums.gram += X * X.transpose();
    sums.cross += X * part.responses.transpose();
    sums.regressor_sum.col(0) += X.rowwise().sum();
    sums.response_sum.col(0) += part.responses.rowwise().sum();
    sums.response_squares += part.responses.rowwise().squaredNorm();
    sums.rows += X.cols();
  }
  return sums;
}

// Both sum the same products in another order: some hundred roundings, each
// relative to the greatest entry.
void ExpectSame(const LaggedMoments& actual, const LaggedMoments& expected) {
  constexpr double kTolerance = 1e-13;
  EXPECT_EQ(actual.rows, expected.rows);
  const auto near = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    ASSERT_EQ(a.rows(), b.rows());
    ASSERT_EQ(a.cols(), b.cols());
    EXPECT_LE((a - b).cwiseAbs().maxCoeff(),
              kTolerance * b.cwiseAbs().maxCoeff());
  };
  near(actual.gram, expected.gram);
  near(actual.cross, expected.cross);
  near(actual.regressor_sum, expected.regressor_sum);
  near(actual.response_sum, expected.response_sum);
  near(actual.response_squares, expected.response_squares);
}

// However much louder other samples are, by orders of magnitude: each entry to
// the roundings of the two columns that it is the product of.
TEST(LaggedMomentsOfQuietChannelsTest, AreNotLostInTheRoundingOfLoudOnes) {
  constexpr int kSamples = 60;
  constexpr int kOrder = 12;
  std::mt19937_64 random(7);
  Record record;
  record.sample_time = 1.0;
  record.outputs = RandomMatrix(2, kSamples, random);
  record.inputs = RandomMatrix(1, kSamples, random);
  // Quiet but for what only the first lags see; loud again before that.
  record.outputs.row(0).segment(5, 50) *= 1e-11;
  record.inputs.row(0).tail(3) *= 1e8;
  record.inputs.row(0).head(4) *= 1e12;
  const LaggedSeries series(record, kOrder);
  std::vector<RegressionRows> rows;
  for (const RowRange range : {RowRange{20, 33}, RowRange{40, kSamples - 1}}) {
    rows.push_back({&series, range, series.Outputs(range)});
  }
  const LaggedMoments moments = ComputeLaggedMoments(rows);
  const LaggedMoments dense = Dense(rows);
  EXPECT_EQ(moments.gram, moments.gram.transpose());
  const Eigen::VectorXd root = dense.gram.diagonal().cwiseSqrt();
  EXPECT_LE(root.minCoeff(), 1e-9);
  EXPECT_LE(
      ((moments.gram - dense.gram).array() / (root * root.transpose()).array())
          .abs()
          .maxCoeff(),
      1e-10);
}

class LaggedMomentsTest : public ::testing::TestWithParam<Shape> {};

TEST_P(LaggedMomentsTest, EqualTheDenseProducts) {
  const int d = GetParam().order;
  Rows rows(GetParam());
  // Whole, one row, many short pieces with lags that reach before them, and
  // what bad samples leave.
  rows.Add(300, {{d, 299}});
  rows.Add(d + 1, {{d, d}});
  std::vector<RowRange> pieces;
  for (int k = d; k + 2 < 90; k += 3) pieces.push_back({k, k + 2});
  rows.Add(90, pieces);
  rows.Add(120, {{d, d + 3}, {60, 60}, {100, 119}});
  const LaggedMoments moments = ComputeLaggedMoments(rows.rows());
  ExpectSame(moments, Dense(rows.rows()));
  EXPECT_EQ(moments.gram, moments.gram.transpose());
}

TEST_P(LaggedMomentsTest, AreAdditive) {
  const int d = GetParam().order;
  Rows rows(GetParam());
  rows.Add(200, {{d, 80}, {81, 81}, {82, 150}});
  rows.Add(100, {{d, 99}});
  LaggedMoments sum = LaggedMoments::Zero(
      rows.rows().front().series->num_regressors(), GetParam().responses);
  for (const RegressionRows& part : rows.rows()) {
    sum += ComputeLaggedMoments({&part, 1});
  }
  ExpectSame(sum, ComputeLaggedMoments(rows.rows()));
}

TEST(GramMatrixTest, IsTheProduct) {
  for (const int columns : {1, 3, 17, 40}) {
    const Eigen::MatrixXd X = Eigen::MatrixXd::Random(333, columns);
    const Eigen::MatrixXd gram = GramMatrix(X);
    EXPECT_LT((gram - X.transpose() * X).cwiseAbs().maxCoeff(), 1e-12 * 333);
    EXPECT_EQ(gram, gram.transpose());
  }
  EXPECT_EQ(GramMatrix(Eigen::MatrixXd(5, 0)).size(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, LaggedMomentsTest,
    ::testing::Values(Shape{1, 1, 1, 1}, Shape{1, 1, 7, 2}, Shape{2, 2, 30, 2},
                      Shape{3, 4, 5, 3}, Shape{9, 4, 8, 1}, Shape{1, 0, 12, 1}),
    [](const auto& test) {
      const Shape& s = test.param;
      return absl::StrCat("Outputs", s.outputs, "Inputs", s.inputs, "Order",
                          s.order, "Responses", s.responses);
    });

}  // namespace
}  // namespace mle
