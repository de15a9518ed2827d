#include <cmath>
#include <vector>

#include "Eigen/LU"
#include "gtest/gtest.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/fitted_output.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Dead times between samples: the response has a kink where one is a whole
// number of them.
FittedOutput FitWrongModel(unsigned seed,
                           const RecordNoise& noise = {.variance = 0.01,
                                                       .increment = 1e-4}) {
  ProcessModel model = TwoElements();
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.2);
  return FitRecords(model, noise, seed);
}

VectorXd Residuals(const OutputErrorProblem& problem, OutputPoint point,
                   const NoiseShape& shape) {
  point.SetCells(problem.sample_time());
  return problem.Whiten(problem.Linearise(point, shape, {}), shape).residuals;
}

// r (JᵀJ)⁻¹ with J from differences in K, T and L themselves. Where the fit is
// exact: J leaves out how the estimates of what is eliminated (initial states)
// move with T, which counts with the residuals.
TEST(OutputCovarianceTest, IsTheInverseOfInformationInUnitsOfTheParameters) {
  const FittedOutput f = FitWrongModel(1, {});
  NoiseEstimate noise;
  noise.variance = 0.01;
  noise.ratio = 1e-2;
  noise.offset = true;
  const NoiseShape shape = ShapeOf(noise);
  const double h = 1e-5;
  std::vector<VectorXd> columns;
  for (int j = 0; j < 2; ++j) {
    for (double ElementValues::*value :
         {&ElementValues::gain, &ElementValues::time_scale,
          &ElementValues::delay}) {
      OutputPoint up = f.fit.point;
      OutputPoint down = f.fit.point;
      up.values[j].*value += h;
      down.values[j].*value -= h;
      columns.push_back((Residuals(f.problem(), up, shape) -
                         Residuals(f.problem(), down, shape)) /
                        (2.0 * h));
    }
  }
  MatrixXd J(columns[0].size(), 6);
  for (int k = 0; k < 6; ++k) J.col(k) = columns[k];
  const MatrixXd expected = noise.variance * (J.transpose() * J).inverse();
  const OutputCovariance found =
      ComputeCovariance(f.problem(), f.fit.point, {true, true}, noise);
  EXPECT_EQ(found.rank, 6);
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      EXPECT_NEAR(found.covariance(a, b), expected(a, b),
                  1e-5 * std::sqrt(expected(a, a) * expected(b, b)));
    }
  }
}

// What is held has none; what stands in no relation to the record, any.
TEST(OutputCovarianceTest, HeldElementsAndUnexcitedOnes) {
  const FittedOutput f = FitWrongModel(2);
  const OutputCovariance held =
      ComputeCovariance(f.problem(), f.fit.point, {true, false}, f.fit.noise);
  EXPECT_EQ(held.rank, 3);
  EXPECT_TRUE(held.covariance.bottomRows(3).isZero(0.0));
  WhitenedColumns blind = f.problem().Whiten(
      f.problem().Linearise(f.fit.point, ShapeOf(f.fit.noise), {true, true}),
      ShapeOf(f.fit.noise));
  blind.jacobian.col(4).setZero();
  const OutputCovariance unknown =
      CovarianceOf(f.problem(), blind.jacobian.transpose() * blind.jacobian,
                   f.fit.point, {true, true}, f.fit.noise.variance);
  EXPECT_EQ(unknown.rank, 5);
  EXPECT_TRUE(std::isinf(unknown.covariance(4, 4)));
  EXPECT_TRUE(std::isfinite(unknown.covariance(3, 3)));
}

// A variance known as well as n squares tell it has n degrees of freedom; each
// part of its variance adds: 2/ν = 2/n + (d ln V / d ln ρ · σ)².
TEST(OutputCovarianceTest, DegreesOfFreedomAreSatterthwaites) {
  const FittedOutput f = FitWrongModel(3);
  const double n = f.problem().num_innovations(ShapeOf(f.fit.noise));
  NoiseEstimate noise = f.fit.noise;
  ASSERT_GT(noise.ratio, 0.0);
  const std::vector<bool> free = {true, true};
  const auto degrees = [&](double deviation) {
    noise.log_deviations[0] = deviation;
    return ComputeDegreesOfFreedom(f.problem(), f.fit.point, free, noise);
  };
  EXPECT_TRUE(degrees(0.0).isApproxToConstant(n, 1e-12));

  const auto log_variances = [&](double log_ratio) {
    NoiseEstimate at = f.fit.noise;
    at.ratio *= std::exp(log_ratio);
    at.variance =
        Residuals(f.problem(), f.fit.point, ShapeOf(at)).squaredNorm() / n;
    return VectorXd(ComputeCovariance(f.problem(), f.fit.point, free, at)
                        .covariance.diagonal()
                        .array()
                        .log());
  };
  const VectorXd slope = (log_variances(0.02) - log_variances(-0.02)) / 0.04;
  for (const double deviation : {0.2, 0.4}) {
    const VectorXd found = degrees(deviation);
    for (int k = 0; k < 6; ++k) {
      const double expected =
          2.0 / (2.0 / n + std::pow(slope(k) * deviation, 2));
      EXPECT_GT(expected, 4.0);  // else the approximation's bound shows
      EXPECT_NEAR(found(k), expected, 0.05 * expected);
    }
  }
}

}  // namespace
}  // namespace mle
