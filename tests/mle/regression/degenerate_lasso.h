// Small random lasso problems that are as degenerate as can be: twins,
// opposites and sums of columns, zero columns, integer data full of ties,
// fewer rows than columns, exact fits, weights of 0 and ∞.

#ifndef TESTS_MLE_REGRESSION_DEGENERATE_LASSO_H_
#define TESTS_MLE_REGRESSION_DEGENERATE_LASSO_H_

#include <cstdint>
#include <limits>
#include <random>

#include "Eigen/Core"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {

class DegenerateLassoGenerator {
 public:
  explicit DegenerateLassoGenerator(std::uint64_t seed) : random_(seed) {}

  ExplicitLasso Next() {
    const int n = Uniform(1, 40);
    const int rows = Uniform(2, 40);
    const int kind = Uniform(0, 3);
    Eigen::MatrixXd X = Values(n, rows, kind);
    Degrade(X);
    Eigen::VectorXd e = Values(rows, 1, kind);
    if (Uniform(0, 3) == 0) {  // an exact fit of few columns
      Eigen::VectorXd beta = Eigen::VectorXd::Zero(n);
      for (int i = 0; i < 3; ++i) beta(Uniform(0, n - 1)) = Uniform(-2, 2);
      e = X.transpose() * beta;
    }
    return ExplicitLasso(X, e, Weights(n));
  }

 private:
  int Uniform(int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random_);
  }

  // Signs and zeros, small integers, tenths, or normal numbers.
  Eigen::MatrixXd Values(int rows, int cols, int kind) {
    if (kind == 3) return RandomMatrix(rows, cols, random_);
    Eigen::MatrixXd values(rows, cols);
    for (double& value : values.reshaped()) {
      value = kind == 0   ? Uniform(-1, 1)
              : kind == 1 ? Uniform(-5, 5)
                          : Uniform(-30, 30) / 10.0;
    }
    return values;
  }

  void Degrade(Eigen::MatrixXd& X) {
    const int n = static_cast<int>(X.rows());
    const int changes = Uniform(0, 1) * Uniform(0, n);
    for (int i = 0; i < changes; ++i) {
      const int j = Uniform(0, n - 1);
      const Eigen::RowVectorXd a = X.row(Uniform(0, n - 1));
      const Eigen::RowVectorXd b = X.row(Uniform(0, n - 1));
      switch (Uniform(0, 5)) {
        case 0:
          X.row(j) = a;
          break;
        case 1:
          X.row(j) = -a;
          break;
        case 2:
          X.row(j) = a + b;
          break;
        case 3:
          X.row(j) = a - b + X.row(Uniform(0, n - 1));
          break;
        case 4:
          X.row(j) = 2.0 * a;
          break;
        default:
          X.row(j).setZero();
      }
    }
  }

  Eigen::VectorXd Weights(int n) {
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(n);
    const int kind = Uniform(0, 3);
    if (kind <= 1) return weights;
    for (double& w : weights) {
      const int draw = Uniform(0, 9);
      if (draw == 0) w = 0.0;
      if (draw == 1) w = std::numeric_limits<double>::infinity();
      if (kind == 3 && draw > 1) {
        w = std::uniform_real_distribution<double>(0.1, 3.0)(random_);
      }
    }
    if (!(weights.minCoeff() < std::numeric_limits<double>::infinity())) {
      weights(0) = 1.0;
    }
    return weights;
  }

  std::mt19937_64 random_;
};

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_DEGENERATE_LASSO_H_
