// Random lasso problems on standardised lags of an output and two inputs, as
// collinear as records are: slow modes, inputs that are held between samples
// or for good, one that repeats the other, readings of few digits, little noise
// or none.

#ifndef TESTS_MLE_REGRESSION_LAGGED_LASSO_H_
#define TESTS_MLE_REGRESSION_LAGGED_LASSO_H_

#include <cmath>
#include <cstdint>
#include <random>

#include "Eigen/Core"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {

class LaggedLassoGenerator {
 public:
  explicit LaggedLassoGenerator(std::uint64_t seed) : random_(seed) {}

  ExplicitLasso Next() {
    const int order = 5 + Draw(60);
    const int rows = 20 + Draw(400);
    const Eigen::Index samples = rows + order;
    const double noise = Draw(4) == 0 ? 0.0 : std::pow(10.0, -Draw(8));
    Eigen::VectorXd u1 = RandomVector(samples, random_);
    Eigen::VectorXd u2 = RandomVector(samples, random_);
    const int hold = 1 + Draw(10);
    for (Eigen::Index k = 1; k < samples; ++k) {
      if (k % hold != 0) u1(k) = u1(k - 1);
      if (Draw(3) == 0) u2(k) = u2(k - 1);
    }
    if (Draw(4) == 0) u2 = u1;
    if (Draw(5) == 0) u2.setConstant(96.1);
    Eigen::VectorXd y =
        Response(u1, u2) + noise * RandomVector(samples, random_);
    if (Draw(3) == 0) {
      y = (y / 0.05).array().round() * 0.05;
      u1 = (u1 / 0.05).array().round() * 0.05;
    }
    Eigen::MatrixXd X(3 * order, rows);
    for (int lag = 1; lag <= order; ++lag) {
      X.row(3 * lag - 3) = y.segment(order - lag, rows);
      X.row(3 * lag - 2) = u1.segment(order - lag, rows);
      X.row(3 * lag - 1) = u2.segment(order - lag, rows);
    }
    Eigen::VectorXd e = y.tail(rows);
    if (Draw(2) == 0) e += (0.1 * X.row(1) - 0.9 * X.row(0)).transpose();
    Standardise(X);
    e.array() -= e.mean();
    return ExplicitLasso(X, e);
  }

 private:
  int Draw(int end) {
    return std::uniform_int_distribution<int>(0, end - 1)(random_);
  }

  // Of a process with a slow mode and a faster one.
  Eigen::VectorXd Response(const Eigen::VectorXd& u1,
                           const Eigen::VectorXd& u2) {
    const double slow = 1.0 - std::pow(10.0, -1.0 - Draw(30) / 10.0);
    const double fast = 0.5 + 0.0049 * Draw(100);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(u1.size());
    for (Eigen::Index k = 2; k < y.size(); ++k) {
      y(k) = (slow + fast) * y(k - 1) - slow * fast * y(k - 2) +
             0.3 * u1(k - 1) - 0.1 * u2(k - 2);
    }
    return y;
  }

  static void Standardise(Eigen::MatrixXd& X) {
    const double rows = static_cast<double>(X.cols());
    for (Eigen::Index j = 0; j < X.rows(); ++j) {
      X.row(j).array() -= X.row(j).mean();
      const double deviation = std::sqrt(X.row(j).squaredNorm() / rows);
      X.row(j) *= deviation > 1e-9 ? 1.0 / deviation : 0.0;
    }
  }

  std::mt19937_64 random_;
};

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_LAGGED_LASSO_H_
