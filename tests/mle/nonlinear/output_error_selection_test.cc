#include "mle/nonlinear/output_error_selection.h"

#include <cmath>
#include <random>

#include "Eigen/Cholesky"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd RandomCovariance(int size, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  MatrixXd root(size, 2 * size);
  for (double& value : root.reshaped()) value = normal(engine);
  return root * root.transpose();
}

TEST(OutputErrorSelectionTest, IndependentGroupsAreWaldTests) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const double critical =
      ChiSquareTail(0.0, 3.0) * 3.0 * FisherQuantile(0.01, 3.0, kInfinity);
  int changed = 0;
  for (int trial = 0; trial < 200; ++trial) {
    MatrixXd covariance = MatrixXd::Zero(6, 6);
    covariance.topLeftCorner(3, 3) = RandomCovariance(3, engine);
    covariance.bottomRightCorner(3, 3) = RandomCovariance(3, engine);
    VectorXd changes(6);
    for (double& value : changes) value = 6.0 * normal(engine);
    const ElementSelection selection =
        SelectChanged(changes, covariance, {kInfinity, kInfinity}, 0.01);
    for (int g = 0; g < 2; ++g) {
      const VectorXd own = changes.segment(3 * g, 3);
      const double wald =
          own.dot(covariance.block(3 * g, 3 * g, 3, 3).llt().solve(own));
      EXPECT_NEAR(selection.statistics[g], wald, 1e-9 * wald);
      EXPECT_EQ(selection.changed[g], wald > critical) << wald;
      EXPECT_NEAR(selection.p_values[g], ChiSquareTail(wald, 3.0), 1e-12);
      changed += selection.changed[g];
    }
  }
  // Both answers occur.
  EXPECT_GT(changed, 40);
  EXPECT_LT(changed, 360);
}

TEST(OutputErrorSelectionTest, NoisePassesAtTheStatedRate) {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  const MatrixXd covariance = RandomCovariance(9, engine);
  const MatrixXd root = covariance.llt().matrixL();
  const int trials = 2000;
  int alarms = 0;
  for (int trial = 0; trial < trials; ++trial) {
    VectorXd draw(9);
    for (double& value : draw) value = normal(engine);
    const ElementSelection selection = SelectChanged(
        root * draw, covariance, {kInfinity, kInfinity, kInfinity}, 0.02);
    for (const bool changed : selection.changed) alarms += changed;
  }
  // 6000 tests at 2 %: 120 ± 11 if independent; correlated ones scatter more,
  // and the others' penalty may only take alarms away. Four deviations.
  EXPECT_LT(alarms, 120 + 4 * 19);
  EXPECT_GT(alarms, 20);
}

TEST(OutputErrorSelectionTest, OneChangeIsNotSpreadOverTwo) {
  // Two groups that the data can hardly tell apart; one has changed a lot.
  MatrixXd covariance = MatrixXd::Identity(6, 6);
  covariance.topRightCorner(3, 3) = -0.95 * MatrixXd::Identity(3, 3);
  covariance.bottomLeftCorner(3, 3) = covariance.topRightCorner(3, 3);
  VectorXd changes(6);
  changes << 40.0, -30.0, 20.0, 0.5, -1.0, 0.3;
  const ElementSelection selection =
      SelectChanged(changes, covariance, {kInfinity, kInfinity}, 0.01);
  EXPECT_TRUE(selection.changed[0]);
  EXPECT_FALSE(selection.changed[1]);
}

TEST(OutputErrorSelectionTest, UncertainVariancesAskForMore) {
  const MatrixXd covariance = MatrixXd::Identity(3, 3);
  const VectorXd changes = VectorXd::Constant(3, 2.2);
  EXPECT_TRUE(SelectChanged(changes, covariance, {kInfinity}, 0.01).changed[0]);
  EXPECT_FALSE(SelectChanged(changes, covariance, {5.0}, 0.01).changed[0]);
}

}  // namespace
}  // namespace mle
