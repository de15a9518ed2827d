#include "mle/regression/lagged_moments.h"

#include "glog/logging.h"

namespace mle {
namespace {

// The sums that run over the data: S's first block column, its diagonal
// (`squares`) and those with the responses. Adds to them.
void AddDataSums(const RegressionRows& part, Eigen::VectorXd& squares,
                 LaggedMoments& moments) {
  const LaggedSeries& series = *part.series;
  const int c = series.num_channels();
  const auto regressors = series.Regressors(part.rows);
  const auto latest = series.Samples(part.rows, /*lag=*/1);
  moments.gram.leftCols(c).noalias() += regressors * latest.transpose();
  moments.cross.noalias() += regressors * part.responses.transpose();
  squares += regressors.cwiseAbs2().rowwise().sum();
  moments.regressor_sum += regressors.rowwise().sum();
  moments.response_sum += part.responses.rowwise().sum();
  moments.response_squares += part.responses.rowwise().squaredNorm();
  moments.rows += part.rows.rows();
}

// Fills the other block columns of S from the first by the recursion. Column j
// of `entering` (n−c × ranges) holds x_{k₀−1}, of `leaving` x_{k₁}, without the
// last block.
void ExtendGram(const Eigen::MatrixXd& entering, const Eigen::MatrixXd& leaving,
                int c, Eigen::MatrixXd& gram) {
  const Eigen::Index n = gram.rows();
  for (Eigen::Index column = c; column < n; ++column) {
    const Eigen::Index previous = column - c;
    gram.col(column).head(c) = gram.row(column).head(c).transpose();
    auto rest = gram.col(column).tail(n - c);
    rest = gram.col(previous).head(n - c);
    for (Eigen::Index r = 0; r < entering.cols(); ++r) {
      rest += entering(previous, r) * entering.col(r) -
              leaving(previous, r) * leaving.col(r);
    }
  }
}

}  // namespace

LaggedMoments LaggedMoments::Zero(int num_regressors, int num_responses) {
  LaggedMoments zero;
  zero.gram.setZero(num_regressors, num_regressors);
  zero.cross.setZero(num_regressors, num_responses);
  zero.regressor_sum.setZero(num_regressors);
  zero.response_sum.setZero(num_responses);
  zero.response_squares.setZero(num_responses);
  return zero;
}

LaggedMoments& LaggedMoments::operator+=(const LaggedMoments& other) {
  CHECK_EQ(num_regressors(), other.num_regressors());
  CHECK_EQ(num_responses(), other.num_responses());
  rows += other.rows;
  gram += other.gram;
  cross += other.cross;
  regressor_sum += other.regressor_sum;
  response_sum += other.response_sum;
  response_squares += other.response_squares;
  return *this;
}

LaggedMoments ComputeLaggedMoments(absl::Span<const RegressionRows> rows) {
  CHECK(!rows.empty());
  const int n = rows.front().series->num_regressors();
  const int c = rows.front().series->num_channels();
  LaggedMoments moments =
      LaggedMoments::Zero(n, static_cast<int>(rows.front().responses.rows()));
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd entering(n - c, rows.size());
  Eigen::MatrixXd leaving(n - c, rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const LaggedSeries& series = *rows[r].series;
    const RowRange range = rows[r].rows;
    CHECK_EQ(series.num_regressors(), n);
    CHECK_EQ(rows[r].responses.cols(), range.rows());
    AddDataSums(rows[r], squares, moments);
    // x_{k₁} and x_{k₀−1} without the oldest block, which row k₀ may lack.
    leaving.col(r) =
        series.Regressors({range.last, range.last}).col(0).head(n - c);
    for (int a = 0; a + 1 < series.order(); ++a) {
      entering.col(r).segment(a * c, c) =
          series.Samples({range.first, range.first}, a + 2).col(0);
    }
  }
  ExtendGram(entering, leaving, c, moments.gram);
  moments.gram.diagonal() = squares;
  return moments;
}

}  // namespace mle
