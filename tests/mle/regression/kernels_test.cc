#include "mle/regression/kernels/kernels.h"

#include <cstring>
#include <numeric>
#include <ostream>
#include <random>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {

void PrintTo(const Kernels& kernels, std::ostream* out) {
  *out << kernels.instruction_set;
}

namespace {

// Below, at and above every width, depth and panel.
const std::vector<int> kSizes = {0, 1,  2,  3,  4,  5,  7,   8,
                                 9, 15, 16, 17, 31, 33, 100, 203};

// A copy whose first number lies `shift` numbers behind an allocation's start.
class Shifted {
 public:
  Shifted(const Eigen::MatrixXd& values, int shift)
      : storage_(values.size() + shift), shift_(shift) {
    std::copy(values.data(), values.data() + values.size(), data());
  }
  double* data() { return storage_.data() + shift_; }

 private:
  std::vector<double> storage_;
  int shift_;
};

class KernelsTest : public testing::TestWithParam<Kernels> {
 protected:
  const Kernels& kernels() const { return GetParam(); }
  std::mt19937_64 random_{1};
};

TEST_P(KernelsTest, ProductsOfOverlappingColumns) {
  for (const int rows : kSizes) {
    for (const int columns : {1, 2, 3, 4, 5, 9}) {
      const int stride = 3, count = 70;
      const Eigen::VectorXd samples =
          RandomVector(stride * count + rows, random_);
      const Eigen::MatrixXd w = RandomMatrix(columns, count, random_);
      Eigen::MatrixXd sums = RandomMatrix(rows, columns, random_);
      const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> x(
          samples.data(), rows, count, Eigen::OuterStride<>(stride));
      const Eigen::MatrixXd expected = sums + x * w.transpose();
      kernels().add_products(
          {samples.data(), stride, rows, w.data(), columns, columns, count},
          sums.data(), rows);
      // Sums of 70 products of numbers of size one.
      EXPECT_LE((sums - expected).cwiseAbs().sum(),
                1e3 * kEpsilon * (1.0 + static_cast<double>(sums.size())))
          << rows << " × " << columns;
    }
  }
}

TEST_P(KernelsTest, FiltersRowsOfAnyWidth) {
  const int count = 60;
  const Eigen::MatrixXd steps = RandomMatrix(6, count, random_) * 0.3;
  const Eigen::VectorXd gains = steps.row(0);
  const Eigen::VectorXd roots = steps.row(1);
  const Eigen::MatrixXd ar = steps.bottomRows(4);
  const double spread = 0.7;
  for (const int width : kSizes) {
    for (const bool has_ar : {false, true}) {
      // A row is a column here; behind each there is a number that is not its.
      const Eigen::MatrixXd rows = RandomMatrix(width + 1, count, random_);
      const Eigen::MatrixXd before = RandomMatrix(width, 3, random_);
      Eigen::MatrixXd filtered = rows;
      Eigen::MatrixXd state = before;
      kernels().filter_rows(
          {gains.data(), roots.data(), has_ar ? ar.data() : nullptr, spread},
          count, filtered.data(), width + 1, width, state.data());
      for (int c = 0; c < width; ++c) {
        double w = before(c, 0);
        double a = has_ar ? before(c, 1) : 0.0;
        double b = has_ar ? before(c, 2) : 0.0;
        for (int k = 0; k < count; ++k) {
          const double innovation = rows(c, k) - w - a;
          EXPECT_NEAR(filtered(c, k), innovation * roots(k), 1e-12);
          w += gains(k) * innovation;
          if (!has_ar) continue;
          const double next =
              ar(0, k) * a + ar(1, k) * b + ar(2, k) * innovation;
          b = spread * ar(1, k) * a + ar(0, k) * b + ar(3, k) * innovation;
          a = next;
        }
        EXPECT_NEAR(state(c, 0), w, 1e-12);
        EXPECT_NEAR(state(c, 1), has_ar ? a : before(c, 1), 1e-12);
        EXPECT_NEAR(state(c, 2), has_ar ? b : before(c, 2), 1e-12);
      }
      EXPECT_EQ(filtered.row(width), rows.row(width));
    }
  }
}

TEST_P(KernelsTest, RunsElementsOfFirstOrder) {
  constexpr int kNumbers = FirstOrderElements::kNumbers;
  const int samples = 50;
  for (const int count : {1, 2, 3, 7, 8, 9, 15, 16, 17, 24, 33}) {
    const int width = (count + 7) / 8 * 8;
    const int between = count + 2;
    // A row of numbers is a column here.
    Eigen::MatrixXd numbers = RandomMatrix(width, kNumbers, random_) * 0.3;
    numbers.bottomRows(width - count).setZero();
    const Eigen::MatrixXd inputs = RandomMatrix(width, samples + 1, random_);
    const Eigen::MatrixXd before = RandomMatrix(width, 2, random_);
    const Eigen::VectorXd sums_before = RandomVector(samples, random_);
    const Eigen::MatrixXd rows_before =
        RandomMatrix(3 * between + 1, samples, random_);
    for (const bool derivatives : {true, false}) {
      Eigen::VectorXd sums = sums_before;
      Eigen::MatrixXd rows = rows_before;
      Eigen::MatrixXd state = before;
      kernels().run_first_order({numbers.data(), width, count}, samples,
                                inputs.data(), state.data(), sums.data(),
                                derivatives ? rows.data() : nullptr,
                                rows.rows(), between);
      Eigen::VectorXd expected_sums = sums_before;
      Eigen::MatrixXd expected = rows_before;
      for (int c = 0; c < count; ++c) {
        const auto by = numbers.row(c);
        double y = before(c, 0);
        double d = before(c, 1);
        for (int k = 0; k < samples; ++k) {
          const double u1 = inputs(c, k);
          const double u0 = inputs(c, k + 1);
          expected_sums(k) += by(8) * y;
          if (derivatives) {
            expected(c, k) = y;
            expected(between + c, k) = d;
            expected(2 * between + c, k) = by(6) * y + by(7) * u1;
            d = by(0) * d + by(3) * y + by(4) * u1 + by(5) * u0;
          }
          y = by(0) * y + by(1) * u1 + by(2) * u0;
        }
        EXPECT_NEAR(state(c, 0), y, 1e-12);
        EXPECT_NEAR(state(c, 1), d, 1e-12);
      }
      EXPECT_LT((sums - expected_sums).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_LT((rows - expected).cwiseAbs().maxCoeff(), 1e-12)
          << count << " elements";
    }
  }
}

TEST_P(KernelsTest, ProductsWithColumns) {
  for (const int n : kSizes) {
    const Eigen::MatrixXd g = RandomMatrix(n, 30, random_);
    for (const int count : {0, 1, 3, 8, 9, 17}) {
      std::vector<int> columns(30);
      std::iota(columns.begin(), columns.end(), 0);
      std::shuffle(columns.begin(), columns.end(), random_);
      columns.resize(count);
      const Eigen::VectorXd x = RandomVector(count, random_);
      const Eigen::VectorXd q = RandomVector(count, random_);
      Eigen::VectorXd gx = Eigen::VectorXd::Constant(n, 1.0);
      Eigen::VectorXd gq = Eigen::VectorXd::Constant(n, 2.0);
      kernels().multiply_columns({g.data(), n, columns.data(), count}, x.data(),
                                 q.data(), n, gx.data(), gq.data());
      const Eigen::MatrixXd active = g(Eigen::all, columns);
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
      EXPECT_LE((gx - ones - active * x).norm(), 100 * kEpsilon * (1 + n));
      EXPECT_LE((gq - 2 * ones - active * q).norm(), 100 * kEpsilon * (1 + n));
    }
  }
}

// Numbers that cancel to 1e-20 of their size: nothing of the result is left in
// working precision, where twice that, ε² 1e20, leaves eleven digits.
TEST_P(KernelsTest, CompensatedSumsKeepWhatCancels) {
  for (const int n : kSizes) {
    Eigen::MatrixXd g = RandomMatrix(n, 4, random_);
    g.col(1) = g.col(0);
    Eigen::VectorXd x(4);
    x << 1e10 / 3.0, -1e10 / 3.0, 1e-10, 1e-10;
    const std::vector<int> columns = {0, 2, 1, 3};
    const Eigen::VectorXd ordered = x(columns);
    const Eigen::VectorXd expected = -1e-10 * (g.col(2) + g.col(3));
    Eigen::VectorXd high = Eigen::VectorXd::Zero(n);
    Eigen::VectorXd low = high;
    const ColumnSet set{g.data(), n, columns.data(), 4};
    kernels().subtract_columns_twice(set, ordered.data(), n, high.data(),
                                     low.data());
    EXPECT_LE((high + low - expected).norm(), 1e-11 * expected.norm());
  }
}

TEST_P(KernelsTest, TriangularSolves) {
  for (const int n : kSizes) {
    const int stride = n + 3;
    Eigen::MatrixXd u = RandomMatrix(stride, n, random_);
    for (int i = 0; i < n; ++i) u(i, i) = n + 1.0;
    const Eigen::MatrixXd upper = u.topRows(n).triangularView<Eigen::Upper>();
    const Eigen::VectorXd b = RandomVector(n, random_);
    Eigen::VectorXd x = b;
    kernels().solve_transposed(u.data(), stride, n, x.data());
    EXPECT_LE((upper.transpose() * x - b).norm(), 1e-13 * (1.0 + b.norm()));
    x = b;
    kernels().solve(u.data(), stride, n, x.data());
    EXPECT_LE((upper * x - b).norm(), 1e-13 * (1.0 + b.norm()));
  }
}

// The same bytes wherever the arrays happen to lie.
TEST_P(KernelsTest, AddressesDoNotMatter) {
  const int n = 203, count = 37;
  const Eigen::MatrixXd g = RandomMatrix(n, count, random_);
  const Eigen::VectorXd x = RandomVector(count, random_);
  std::vector<int> columns(count);
  std::iota(columns.begin(), columns.end(), 0);
  std::vector<std::vector<double>> results;
  for (const int shift : {0, 1, 2, 3, 5, 7}) {
    Shifted matrix(g, shift);
    Shifted gx(Eigen::VectorXd::Zero(n), (shift * 3) % 8);
    Shifted gq(Eigen::VectorXd::Zero(n), (shift * 5) % 8);
    Shifted sums(Eigen::MatrixXd::Zero(n, 2), shift);
    Shifted solved(x, (shift + 4) % 8);
    kernels().multiply_columns({matrix.data(), n, columns.data(), count},
                               x.data(), x.data(), n, gx.data(), gq.data());
    kernels().add_products({matrix.data(), n, n, x.data(), 1, 2, count - 1},
                           sums.data(), n);
    kernels().solve_transposed(matrix.data(), n, count, solved.data());
    kernels().solve(matrix.data(), n, count, solved.data());
    std::vector<double> all(gx.data(), gx.data() + n);
    all.insert(all.end(), gq.data(), gq.data() + n);
    all.insert(all.end(), sums.data(), sums.data() + 2 * n);
    all.insert(all.end(), solved.data(), solved.data() + count);
    results.push_back(all);
  }
  for (const std::vector<double>& result : results) {
    EXPECT_EQ(std::memcmp(result.data(), results[0].data(),
                          result.size() * sizeof(double)),
              0);
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, KernelsTest,
                         testing::ValuesIn(AvailableKernels()),
                         [](const auto& test) {
                           return std::string(test.param.instruction_set);
                         });

TEST(VectorKernelsTest, TheBaselineIsAlwaysThere) {
  ASSERT_FALSE(AvailableKernels().empty());
  EXPECT_STREQ(AvailableKernels().front().instruction_set, "baseline");
}

}  // namespace
}  // namespace mle
