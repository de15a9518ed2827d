#include "mle/nonlinear/innovations_filter.h"

#include <cmath>
#include <complex>
#include <numeric>
#include <random>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/QR"
#include "absl/strings/str_format.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd RandomSamples(int rows, int cols) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) value = normal(engine);
  return matrix;
}

// Autocovariances of the AR component of `shape` from its impulse response, the
// products of powers of the poles.
std::vector<double> Autocovariances(const NoiseShape& shape, int lags) {
  constexpr int kTerms = 20000;
  std::complex<double> poles[2] = {shape.ar_pole, 0.0};
  if (shape.ar_damping > 0.0) {
    const std::complex<double> zeta = shape.ar_damping;
    const double omega = -std::log(shape.ar_pole);
    poles[0] = std::exp(-omega * (zeta + std::sqrt(zeta * zeta - 1.0)));
    poles[1] = std::exp(-omega * (zeta - std::sqrt(zeta * zeta - 1.0)));
  }
  std::vector<double> response(kTerms + lags);
  std::complex<double> first = 1.0;
  std::complex<double> second = 1.0;
  for (double& value : response) {
    value = second.real();
    first *= poles[0];
    second = poles[1] * second + first;
  }
  std::vector<double> covariances(lags);
  for (int lag = 0; lag < lags; ++lag) {
    for (int k = 0; k < kTerms; ++k) {
      covariances[lag] += shape.ar_ratio * response[k] * response[k + lag];
    }
  }
  return covariances;
}

// Covariance of noise of unit white part at `times`, random walk from the
// first.
MatrixXd Covariance(const std::vector<int>& times, const NoiseShape& shape) {
  const int n = static_cast<int>(times.size());
  MatrixXd covariance = MatrixXd::Identity(n, n);
  const std::vector<double> ar =
      Autocovariances(shape, times.back() - times.front() + 1);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      covariance(i, k) +=
          shape.ratio * (std::min(times[i], times[k]) - times[0]) +
          ar[std::abs(times[i] - times[k])];
    }
  }
  return covariance;
}

class InnovationsFilterTest : public ::testing::TestWithParam<NoiseShape> {};

TEST_P(InnovationsFilterTest, IsGeneralisedLeastSquaresWithAFreeOffset) {
  const std::vector<int> times = {0, 1, 2, 3, 7, 8, 10, 11, 12, 30, 31, 32};
  const int n = static_cast<int>(times.size());
  const MatrixXd columns = RandomSamples(n, 3);
  MatrixXd whitened = columns;
  const InnovationsFilter filter(times, GetParam());
  filter.Apply(whitened);
  EXPECT_EQ(whitened.row(0).norm(), 0.0);

  // In the space of contrasts A (orthonormal, orthogonal to a constant), the
  // noise has covariance AᵀVA, whose inverse gives the same products, and whose
  // determinant is that of the innovations up to the constant's length n.
  const VectorXd ones = VectorXd::Ones(n);
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(ones).householderQ();
  const MatrixXd A = Q.rightCols(n - 1);
  const MatrixXd V = A.transpose() * Covariance(times, GetParam()) * A;
  const Eigen::LLT<MatrixXd> factor(V);
  const MatrixXd contrasts = A.transpose() * columns;
  const MatrixXd expected = contrasts.transpose() * factor.solve(contrasts);
  // Rounding, at most 1e-12 of each product.
  EXPECT_LT((whitened.transpose() * whitened - expected).norm(),
            1e-11 * expected.norm());
  const double log_determinant =
      2.0 * factor.matrixLLT().diagonal().array().log().sum();
  EXPECT_NEAR(filter.log_determinant(),
              log_determinant + std::log(static_cast<double>(n)), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    Ratios, InnovationsFilterTest,
    ::testing::Values(
        NoiseShape(), NoiseShape{.ratio = 1e-4}, NoiseShape{.ratio = 0.1},
        NoiseShape{.ratio = 1.0}, NoiseShape{.ratio = 1e4},
        NoiseShape{.ar_ratio = 0.3, .ar_pole = 0.0},
        NoiseShape{.ar_ratio = 2.0, .ar_pole = 0.9},
        NoiseShape{.ratio = 0.05, .ar_ratio = 0.5, .ar_pole = 0.7},
        NoiseShape{.ratio = 1e-6, .ar_ratio = 40.0, .ar_pole = 0.99},
        // Two real poles, poles that are one, and a resonance.
        NoiseShape{.ar_ratio = 0.1, .ar_pole = 0.9, .ar_damping = 2.0},
        NoiseShape{
            .ratio = 0.02, .ar_ratio = 0.1, .ar_pole = 0.8, .ar_damping = 1.0},
        NoiseShape{
            .ratio = 0.02, .ar_ratio = 0.3, .ar_pole = 0.7, .ar_damping = 0.1}),
    [](const auto& test) {
      const NoiseShape& s = test.param;
      return absl::StrFormat("Ratio%.0fppmColour%.0fppmPole%.0fDamping%.0f",
                             1e6 * s.ratio, 1e6 * s.ar_ratio, 100.0 * s.ar_pole,
                             100.0 * s.ar_damping);
    });

// Whatever the number of columns, over more than one block of rows.
TEST_P(InnovationsFilterTest, ProductsAreThoseOfWhitenedColumns) {
  std::vector<int> times(3000);
  std::iota(times.begin(), times.end(), 0);
  for (std::size_t k = 1000; k < times.size(); ++k) times[k] += 7;
  const InnovationsFilter filter(times, GetParam());
  for (const int width : {1, 3, 8, 33}) {
    const MatrixXd columns =
        RandomSamples(static_cast<int>(times.size()), width);
    MatrixXd whitened = columns;
    filter.Apply(whitened);
    const MatrixXd expected = whitened.transpose() * whitened;
    const MatrixXd products = filter.WhitenedProducts(columns);
    EXPECT_LT((products - expected).norm(), 1e-12 * expected.norm()) << width;
    EXPECT_EQ(products, products.transpose());
  }
}

// Zeros after the end of a column are no rows to multiply: the products are
// those of all rows, whichever columns end first, in a gap, at once or never.
TEST_P(InnovationsFilterTest, ColumnsThatEndHaveTheSameProducts) {
  const int samples = 3000;
  std::vector<int> times(samples);
  std::iota(times.begin(), times.end(), 0);
  for (int k = 1000; k < samples; ++k) times[k] += 7;
  const InnovationsFilter filter(times, GetParam());
  for (const int width : {1, 9, 40}) {
    MatrixXd columns = RandomSamples(samples, width);
    std::vector<Eigen::Index> ends(width, samples);
    for (int c = 0; c < width; ++c) {
      // Every third goes on, the first is zero, some end together.
      if (c % 3 != 0) ends[c] = 1000 + 300 * (c % 7);
      if (c == 0 && width > 1) ends[c] = 0;
      columns.col(c).tail(samples - ends[c]).setZero();
    }
    const MatrixXd expected = filter.WhitenedProducts(columns);
    const MatrixXd products = filter.WhitenedProducts(columns, ends);
    EXPECT_LT((products - expected).norm(), 1e-12 * expected.norm()) << width;
    for (int c = 0; c < width; ++c) {
      // Of each column by itself: small ones are not lost beside large ones.
      EXPECT_NEAR(products(c, c), expected(c, c), 1e-12 * expected(c, c));
    }
    EXPECT_EQ(products, products.transpose());
  }
}

// All columns may end, and one may end at every sample.
TEST_P(InnovationsFilterTest, AllColumnsMayEnd) {
  const int samples = 60;
  std::vector<int> times(samples);
  std::iota(times.begin(), times.end(), 0);
  const InnovationsFilter filter(times, GetParam());
  MatrixXd columns = RandomSamples(samples, samples);
  std::vector<Eigen::Index> ends(samples);
  for (int c = 0; c < samples; ++c) {
    ends[c] = c;
    columns.col(c).tail(samples - c).setZero();
  }
  const MatrixXd expected = filter.WhitenedProducts(columns);
  EXPECT_LT((filter.WhitenedProducts(columns, ends) - expected).norm(),
            1e-12 * expected.norm());
}

// Weighted samples: the same identity with variances 1/ω on the diagonal.
TEST_P(InnovationsFilterTest, WeightsAreInverseVariances) {
  const std::vector<int> times = {0, 1, 2, 3, 7, 8, 10, 11, 12, 30, 31, 32};
  const int n = static_cast<int>(times.size());
  VectorXd weights = VectorXd::Ones(n);
  weights(0) = 0.2;
  weights(4) = 0.01;
  weights(9) = 0.5;
  const MatrixXd columns = RandomSamples(n, 3);
  MatrixXd whitened = columns;
  const InnovationsFilter filter(times, GetParam(), weights);
  filter.Apply(whitened);
  MatrixXd V = Covariance(times, GetParam());
  V.diagonal().array() += weights.array().inverse() - 1.0;
  const VectorXd ones = VectorXd::Ones(n);
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(ones).householderQ();
  const MatrixXd A = Q.rightCols(n - 1);
  const Eigen::LLT<MatrixXd> factor(MatrixXd(A.transpose() * V * A));
  const MatrixXd contrasts = A.transpose() * columns;
  const MatrixXd expected = contrasts.transpose() * factor.solve(contrasts);
  EXPECT_LT((whitened.transpose() * whitened - expected).norm(),
            1e-11 * expected.norm());
  EXPECT_NEAR(filter.log_determinant(),
              2.0 * factor.matrixLLT().diagonal().array().log().sum() +
                  std::log(static_cast<double>(n)),
              1e-9);

  // The best guess of the white part e = n − w: D V⁻¹ (n − c), D = diag(1/ω), c
  // the generalised mean.
  const VectorXd noise = columns.col(0);
  const Eigen::LLT<MatrixXd> full(V);
  const double mean = ones.dot(full.solve(noise)) / ones.dot(full.solve(ones));
  const VectorXd white =
      weights.cwiseInverse().cwiseProduct(full.solve(noise - mean * ones));
  EXPECT_LT((filter.WhitePart(noise) - white).norm(),
            1e-10 * (noise.norm() + white.norm()));
}

TEST(InnovationsFilterTest, WhitensWhatItIsMeantFor) {
  const int n = 20000;
  const double ratio = 0.01;
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  MatrixXd noise(n, 1);
  double level = 5.0;
  for (int k = 0; k < n; ++k) {
    noise(k, 0) = level + 2.0 * normal(engine);
    level += 2.0 * std::sqrt(ratio) * normal(engine);
  }
  std::vector<int> times(n);
  std::iota(times.begin(), times.end(), 0);
  InnovationsFilter(times, {.ratio = ratio}).Apply(noise);
  // Variances of n samples have the relative deviation √(2/n), correlations
  // 1/√n; five of them.
  EXPECT_NEAR(noise.squaredNorm() / n, 4.0, 5.0 * 4.0 * std::sqrt(2.0 / n));
  for (const int lag : {1, 2, 5, 20, 100}) {
    const double correlation =
        noise.col(0).head(n - lag).dot(noise.col(0).tail(n - lag)) /
        noise.squaredNorm();
    EXPECT_LT(std::abs(correlation), 5.0 / std::sqrt(n)) << lag;
  }
}

// Without an offset nothing is free: products and determinant are those of the
// whole covariance.
class ArWithoutOffsetTest : public ::testing::TestWithParam<double> {};

TEST_P(ArWithoutOffsetTest, IsGeneralisedLeastSquares) {
  const std::vector<int> times = {0, 1, 2, 5, 6, 9, 10};
  const NoiseShape shape = {.offset = false,
                            .ar_ratio = 0.4,
                            .ar_pole = 0.8,
                            .ar_damping = GetParam()};
  const InnovationsFilter filter(times, shape);
  const MatrixXd columns = RandomSamples(7, 5);
  MatrixXd whitened = columns;
  filter.Apply(whitened);
  const Eigen::LLT<MatrixXd> factor(Covariance(times, shape));
  const MatrixXd expected = columns.transpose() * factor.solve(columns);
  EXPECT_LT((whitened.transpose() * whitened - expected).norm(),
            1e-12 * expected.norm());
  EXPECT_NEAR(filter.log_determinant(),
              2.0 * factor.matrixLLT().diagonal().array().log().sum(), 1e-12);
  EXPECT_LT(
      (filter.WhitePart(columns.col(0)) - factor.solve(columns.col(0))).norm(),
      1e-12 * columns.col(0).norm());
}

INSTANTIATE_TEST_SUITE_P(Dampings, ArWithoutOffsetTest,
                         ::testing::Values(0.0, 0.3, 1.0, 3.0));

TEST(InnovationsFilterTest, WithoutOffsetWhiteNoisePassesAsItIs) {
  const MatrixXd columns = RandomSamples(5, 2);
  MatrixXd filtered = columns;
  const InnovationsFilter filter({0, 1, 2, 5, 6},
                                 {.ratio = 0.0, .offset = false});
  filter.Apply(filtered);
  EXPECT_EQ(filtered, columns);
  EXPECT_EQ(filter.log_determinant(), 0.0);
  EXPECT_EQ(filter.WhitePart(columns.col(0)), columns.col(0));
}

// Where the gains have settled they are not computed again. Weights, also of
// one, keep the filter from that: the same bytes, over gaps too.
TEST(InnovationsFilterTest, SettledGainsAreTheSame) {
  std::vector<int> times;
  for (int k = 0; k < 4000; ++k) {
    if (k % 1100 < 1000) times.push_back(k);
  }
  const auto rows = static_cast<int>(times.size());
  const MatrixXd columns = RandomSamples(rows, 2);
  for (const NoiseShape& shape :
       {NoiseShape{.ratio = 0.3}, NoiseShape{.ratio = 1e-6},
        NoiseShape{.ratio = 0.1, .ar_ratio = 0.5, .ar_pole = 0.7},
        NoiseShape{.ratio = 0.1,
        .ar_ratio = 0.5,
        .ar_pole = 0.7,
        .ar_damping = 0.4}}) {
    const InnovationsFilter filter(times, shape);
    const InnovationsFilter weighted(times, shape, VectorXd::Ones(rows));
    MatrixXd one = columns;
    MatrixXd other = columns;
    filter.Apply(one);
    weighted.Apply(other);
    EXPECT_EQ(one, other);
    EXPECT_EQ(filter.log_determinant(), weighted.log_determinant());
    EXPECT_EQ(filter.WhitePart(columns.col(0)),
              weighted.WhitePart(columns.col(0)));
  }
}

}  // namespace
}  // namespace mle
