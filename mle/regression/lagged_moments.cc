#include "mle/regression/lagged_moments.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>

#include "glog/logging.h"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

// The recursion is given up where a channel's sum of squares falls below this
// part of the largest that passed through: its rounding, ε of that, is then no
// longer small beside what is left.
constexpr double kQuietPart = 1e-4;

// Σ x_k and the diagonal of S, entry by entry squares of x_k. Only the samples
// that some lags miss are gone through lag by lag, and nothing is subtracted,
// so that every sum is as good as one of its own.
void AddWindowSums(const LaggedSeries& series, RowRange rows,
                   Eigen::Ref<Eigen::VectorXd> sums, Eigen::VectorXd& squares) {
  const int c = series.num_channels();
  const int d = series.order();
  if (rows.rows() < d) {
    sums += series.Regressors(rows).rowwise().sum();
    squares += series.Regressors(rows).cwiseAbs2().rowwise().sum();
    return;
  }
  // Lag a = 1 … d has samples first − a … last − a: those all lags share, the
  // older ones and the newer ones.
  const auto common = series.Samples({rows.first - 1, rows.last - d});
  Eigen::VectorXd sum = common.rowwise().sum();
  Eigen::VectorXd square = common.cwiseAbs2().rowwise().sum();
  const auto add_sample = [&](int k) {
    const auto sample = series.Samples({k, k}).col(0);
    sum += sample;
    square += sample.cwiseAbs2();
  };
  const auto add_to_lag = [&](int a) {
    sums.segment((a - 1) * c, c) += sum;
    squares.segment((a - 1) * c, c) += square;
  };
  add_to_lag(1);
  for (int a = 2; a <= d; ++a) {
    add_sample(rows.first - a);
    add_to_lag(a);
  }
  sum.setZero();
  square.setZero();
  for (int a = d - 1; a >= 1; --a) {
    add_sample(rows.last - a);
    add_to_lag(a);
  }
}

// The sums that run over the data, but for S itself. `squares` is its diagonal.
// Adds to them.
void AddDataSums(const RegressionRows& part, Eigen::VectorXd& squares,
                 LaggedMoments& moments) {
  const LaggedSeries& series = *part.series;
  AddLaggedProducts(series.Regressors(part.rows), part.responses,
                    moments.cross);
  AddWindowSums(series, part.rows, moments.regressor_sum.col(part.group),
                squares);
  moments.response_sum.col(part.group) += part.responses.rowwise().sum();
  moments.group_rows(part.group) += static_cast<double>(part.rows.rows());
  moments.response_squares += part.responses.rowwise().squaredNorm();
  moments.rows += part.rows.rows();
}

// The block columns of S that are summed over the data: the first, and those
// where a channel has become quiet.
std::vector<int> SummedBlocks(const Eigen::VectorXd& squares, int c) {
  const Eigen::Map<const Eigen::ArrayXXd> of_lag(squares.data(), c,
                                                 squares.size() / c);
  std::vector<int> blocks = {0};
  Eigen::ArrayXd largest = of_lag.col(0);
  for (int b = 1; b < of_lag.cols(); ++b) {
    const auto square = of_lag.col(b);
    largest = largest.max(square);
    if ((square > 0.0 && square < kQuietPart * largest).any()) {
      blocks.push_back(b);
      largest = square;
    }
  }
  return blocks;
}

// Each of `blocks` (ascending), the same above the diagonal as below.
void SumBlocks(absl::Span<const RegressionRows> rows,
               const std::vector<int>& blocks, int c, Eigen::MatrixXd& gram) {
  for (const int b : blocks) {
    auto columns = gram.middleCols(b * c, c);
    columns.setZero();
    for (const RegressionRows& part : rows) {
      AddLaggedProducts(part.series->Regressors(part.rows),
                        part.series->Samples(part.rows, /*lag=*/b + 1),
                        columns);
    }
    gram.block(b * c, b * c, c, c).triangularView<Eigen::StrictlyUpper>() =
        gram.block(b * c, b * c, c, c).transpose();
    for (const int before : blocks) {
      if (before >= b) break;
      gram.block(before * c, b * c, c, c) =
          gram.block(b * c, before * c, c, c).transpose();
    }
  }
}

// An n × n matrix, not initialised. To touch it page by page for the first time
// costs more than to compute it, so large pages are asked for.
Eigen::MatrixXd UninitialisedGram(Eigen::Index n) {
  Eigen::MatrixXd gram(n, n);
#ifdef __linux__
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  auto* const data = reinterpret_cast<char*>(gram.data());
  const auto size = sizeof(double) * static_cast<std::uintptr_t>(n * n);
  const std::uintptr_t past = reinterpret_cast<std::uintptr_t>(data) % kPage;
  const std::uintptr_t skipped = past == 0 ? 0 : kPage - past;
  if (skipped + kPage <= size) {
    // Advice: without it all is the same, but slower.
    static_cast<void>(madvise(data + skipped, (size - skipped) / kPage * kPage,
                              MADV_HUGEPAGE));
  }
#endif
  return gram;
}

// Fills the other block columns of S from those that are summed by the
// recursion. Column j of `entering` (n−c × ranges) holds x_{k₀−1}, of `leaving`
// x_{k₁}, without the last block. One product at a time is added, so that S is
// symmetric to the bit however the compiler fuses products and sums.
void ExtendGram(const Eigen::MatrixXd& entering, const Eigen::MatrixXd& leaving,
                const std::vector<int>& summed, int c, Eigen::MatrixXd& gram) {
  const Eigen::Index n = gram.rows();
  for (Eigen::Index column = c; column < n; ++column) {
    if (std::binary_search(summed.begin(), summed.end(), column / c)) continue;
    const Eigen::Index previous = column - c;
    auto rest = gram.col(column).tail(n - c);
    rest = gram.col(previous).head(n - c) +
           entering(previous, 0) * entering.col(0) -
           leaving(previous, 0) * leaving.col(0);
    for (Eigen::Index r = 1; r < entering.cols(); ++r) {
      rest = rest + entering(previous, r) * entering.col(r) -
             leaving(previous, r) * leaving.col(r);
    }
    for (const int b : summed) {
      gram.col(column).segment(b * c, c) =
          gram.row(column).segment(b * c, c).transpose();
    }
  }
}

}  // namespace

LaggedMoments LaggedMoments::Zero(int num_regressors, int num_responses,
                                  int num_groups) {
  LaggedMoments zero;
  zero.gram.setZero(num_regressors, num_regressors);
  zero.cross.setZero(num_regressors, num_responses);
  zero.response_squares.setZero(num_responses);
  zero.group_rows.setZero(num_groups);
  zero.regressor_sum.setZero(num_regressors, num_groups);
  zero.response_sum.setZero(num_responses, num_groups);
  return zero;
}

LaggedMoments& LaggedMoments::operator+=(const LaggedMoments& other) {
  CHECK_EQ(num_regressors(), other.num_regressors());
  CHECK_EQ(num_responses(), other.num_responses());
  CHECK_EQ(num_groups(), other.num_groups());
  rows += other.rows;
  gram += other.gram;
  cross += other.cross;
  response_squares += other.response_squares;
  group_rows += other.group_rows;
  regressor_sum += other.regressor_sum;
  response_sum += other.response_sum;
  return *this;
}

LaggedMoments ComputeLaggedMoments(absl::Span<const RegressionRows> rows,
                                   int num_groups) {
  CHECK(!rows.empty());
  const int n = rows.front().series->num_regressors();
  const int c = rows.front().series->num_channels();
  LaggedMoments moments = LaggedMoments::Zero(
      0, static_cast<int>(rows.front().responses.rows()), num_groups);
  moments.gram = UninitialisedGram(n);
  moments.cross.setZero(n, moments.cross.cols());
  moments.regressor_sum.setZero(n, num_groups);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd entering(n - c, rows.size());
  Eigen::MatrixXd leaving(n - c, rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const LaggedSeries& series = *rows[r].series;
    const RowRange range = rows[r].rows;
    CHECK_EQ(series.num_regressors(), n);
    CHECK_EQ(rows[r].responses.cols(), range.rows());
    CHECK(rows[r].group >= 0 && rows[r].group < num_groups);
    AddDataSums(rows[r], squares, moments);
    // x_{k₁} and x_{k₀−1} without the oldest block, which row k₀ may lack.
    leaving.col(r) =
        series.Regressors({range.last, range.last}).col(0).head(n - c);
    for (int a = 0; a + 1 < series.order(); ++a) {
      entering.col(r).segment(a * c, c) =
          series.Samples({range.first, range.first}, a + 2).col(0);
    }
  }
  const std::vector<int> summed = SummedBlocks(squares, c);
  SumBlocks(rows, summed, c, moments.gram);
  ExtendGram(entering, leaving, summed, c, moments.gram);
  moments.gram.diagonal() = squares;
  return moments;
}

}  // namespace mle
