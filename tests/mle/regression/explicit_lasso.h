// Lasso problems with explicit rows, to hold the Gram-matrix code against.

#ifndef TESTS_MLE_REGRESSION_EXPLICIT_LASSO_H_
#define TESTS_MLE_REGRESSION_EXPLICIT_LASSO_H_

#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "Eigen/Core"
#include "mle/regression/lasso_problem.h"

namespace mle {

// 1/(2N) ‖e − Xᵀβ‖² + λ Σ w_j |β_j| with X (n × N) and e (N) at hand.
struct ExplicitLasso {
  Eigen::MatrixXd X;
  Eigen::VectorXd e;
  // Where the objective points to; stays put when this is moved or copied.
  std::shared_ptr<Eigen::MatrixXd> gram;
  LassoObjective objective;

  ExplicitLasso(Eigen::MatrixXd regressors, Eigen::VectorXd response,
                const Eigen::VectorXd& weights = {});

  int size() const { return static_cast<int>(X.rows()); }
};

inline ExplicitLasso::ExplicitLasso(Eigen::MatrixXd regressors,
                                    Eigen::VectorXd response,
                                    const Eigen::VectorXd& weights)
    : X(std::move(regressors)), e(std::move(response)) {
  const double rows = static_cast<double>(X.cols());
  gram = std::make_shared<Eigen::MatrixXd>(X * X.transpose() / rows);
  // Products of blocks need not be symmetric to the bit.
  *gram = Eigen::MatrixXd(gram->selfadjointView<Eigen::Lower>());
  objective.gram = gram.get();
  objective.correlation = X * e / rows;
  objective.response_square = e.squaredNorm() / rows;
  objective.weights =
      weights.size() > 0 ? weights : Eigen::VectorXd::Ones(X.rows()).eval();
}

inline Eigen::MatrixXd RandomMatrix(Eigen::Index rows, Eigen::Index cols,
                                    std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd values(rows, cols);
  for (double& value : values.reshaped()) value = normal(random);
  return values;
}

inline Eigen::VectorXd RandomVector(Eigen::Index size,
                                    std::mt19937_64& random) {
  return RandomMatrix(size, 1, random);
}

// From the greatest part of λ_max down to the smallest, ascending, in equal
// ratios, and 0 before them if asked for.
inline Eigen::VectorXd LambdaGrid(double lambda_max, double smallest_part,
                                  int count, bool with_zero) {
  Eigen::VectorXd lambdas(count + (with_zero ? 1 : 0));
  if (with_zero) lambdas(0) = 0.0;
  for (int i = 0; i < count; ++i) {
    lambdas(i + (with_zero ? 1 : 0)) =
        lambda_max * std::pow(smallest_part, 1.0 - (i + 1.0) / count);
  }
  return lambdas;
}

}  // namespace mle

#endif  // TESTS_MLE_REGRESSION_EXPLICIT_LASSO_H_
