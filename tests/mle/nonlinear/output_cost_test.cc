#include "mle/nonlinear/output_cost.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "Eigen/Core"
#include "ceres/cost_function.h"
#include "gtest/gtest.h"
#include "tests/mle/nonlinear/fitted_output.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const NoiseShape kCostShapes[] = {
    {.ratio = 0.0, .offset = false},
    {.ratio = 1e-3},
    {.ratio = 0.01, .ar_ratio = 0.3, .ar_pole = 0.8, .ar_damping = 0.4}};

// What Ceres is given at a point: residuals and the Jacobian of all blocks.
struct Evaluation {
  VectorXd residuals;
  MatrixXd jacobian;
};

Evaluation Evaluate(const ceres::CostFunction& cost, const OutputPoint& point,
                    const std::vector<bool>& free, bool derivatives) {
  std::vector<std::vector<double>> x;
  for (std::size_t j = 0; j < free.size(); ++j) {
    if (!free[j]) continue;
    const ElementValues& values = point.values[j];
    x.push_back({values.gain, std::log(values.time_scale), values.delay});
  }
  const int rows = cost.num_residuals();
  std::vector<std::vector<double>> blocks(x.size(),
                                          std::vector<double>(3 * rows));
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (std::size_t f = 0; f < x.size(); ++f) {
    parameters.push_back(x[f].data());
    jacobians.push_back(blocks[f].data());
  }
  Evaluation result;
  result.residuals.resize(rows);
  EXPECT_TRUE(cost.Evaluate(parameters.data(), result.residuals.data(),
                            derivatives ? jacobians.data() : nullptr));
  result.jacobian.resize(rows, 3 * static_cast<Eigen::Index>(x.size()));
  for (std::size_t f = 0; f < x.size(); ++f) {
    result.jacobian.middleCols<3>(3 * static_cast<Eigen::Index>(f)) =
        Eigen::Map<
            const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
            blocks[f].data(), rows, 3);
  }
  return result;
}

class OutputCostTest : public testing::Test {
 protected:
  // Away from the optimum, with dead times within their samples.
  OutputCostTest()
      : fitted_(FitRecords(TwoElements(), {.variance = 0.01}, 3)),
        point_(fitted_.fit.point) {
    point_.values[0].gain *= 1.3;
    point_.values[1].time_scale *= 0.8;
    point_.values[0].delay = 1.2;
    point_.values[1].delay = 2.6;
    point_.SetCells(problem().sample_time());
  }
  const OutputErrorProblem& problem() const { return fitted_.problem(); }

  FittedOutput fitted_;
  OutputPoint point_;
};

TEST_F(OutputCostTest, HasCostGradientAndNormalMatrixOfTheWhitenedResiduals) {
  for (const std::vector<bool>& free :
       {std::vector<bool>{true, true}, std::vector<bool>{false, true}}) {
    std::vector<int> kept;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; free[j] && i < 3; ++i) kept.push_back(3 * j + i);
    }
    for (const NoiseShape& shape : kCostShapes) {
      const auto cost = MakeOutputCost(problem(), point_, free, shape, true);
      const WhitenedColumns whitened = problem().Whiten(
          problem().Linearise(point_, shape, {true, true}), shape);
      const MatrixXd J = whitened.jacobian(Eigen::all, kept);
      const VectorXd scales = J.colwise().norm().cwiseInverse();
      const double squares = whitened.residuals.squaredNorm();
      // What was evaluated before, there or elsewhere, does not matter.
      OutputPoint elsewhere = point_;
      for (ElementValues& values : elsewhere.values) values.time_scale *= 0.2;
      for (int time = 0; time < 3; ++time) {
        if (time == 1) Evaluate(*cost, elsewhere, free, true);
        const Evaluation given = Evaluate(*cost, point_, free, true);
        EXPECT_NEAR(given.residuals.squaredNorm(), squares, 1e-9 * squares);
        EXPECT_LT((scales.asDiagonal() *
                   (given.jacobian.transpose() * given.residuals -
                    J.transpose() * whitened.residuals))
                      .norm(),
                  1e-8 * std::sqrt(squares));
        EXPECT_LT(
            (scales.asDiagonal() *
             (given.jacobian.transpose() * given.jacobian - J.transpose() * J) *
             scales.asDiagonal())
                .norm(),
            1e-8);
        const Evaluation alone = Evaluate(*cost, point_, free, false);
        EXPECT_NEAR(alone.residuals.squaredNorm(), squares, 1e-9 * squares);
      }
    }
  }
}

// The gradient is that of the cost, by differences.
TEST_F(OutputCostTest, GradientIsTheDerivativeOfTheCost) {
  const NoiseShape shape = kCostShapes[2];
  const std::vector<bool> free = {true, true};
  const auto cost = MakeOutputCost(problem(), point_, free, shape, true);
  const Evaluation at = Evaluate(*cost, point_, free, true);
  const VectorXd gradient = at.jacobian.transpose() * at.residuals;
  for (int parameter = 0; parameter < 6; ++parameter) {
    const double step = 1e-5;
    double costs[2];
    for (const int side : {0, 1}) {
      OutputPoint moved = point_;
      ElementValues& values = moved.values[parameter / 3];
      const double by = side == 0 ? -step : step;
      if (parameter % 3 == 0) values.gain += by;
      if (parameter % 3 == 1) values.time_scale *= std::exp(by);
      if (parameter % 3 == 2) values.delay += by;
      costs[side] =
          0.5 * Evaluate(*cost, moved, free, false).residuals.squaredNorm();
    }
    EXPECT_NEAR((costs[1] - costs[0]) / (2.0 * step), gradient(parameter),
                1e-4 * gradient.norm())
        << parameter;
  }
}

// Where two time constants part the free responses are two and no longer one,
// and explain more of noise: little by little, not at once.
TEST_F(OutputCostTest, DoesNotJumpWhereTimeConstantsPart) {
  const std::vector<bool> free = {true, true};
  const NoiseShape shape = kCostShapes[1];
  const auto cost = MakeOutputCost(problem(), point_, free, shape, true);
  const auto at = [&](double apart) {
    OutputPoint point = point_;
    point.values[0].time_scale = point.values[1].time_scale * std::exp(apart);
    return Evaluate(*cost, point, free, false).residuals.squaredNorm();
  };
  const double together = at(1e-9);
  double former = together;
  double largest = 0.0;
  for (double apart = 1e-9; apart < 1e-3; apart *= 1.2) {
    const double squares = at(apart);
    largest = std::max(largest, std::abs(squares - former));
    former = squares;
  }
  // A degree of freedom for each record.
  EXPECT_GT(together - former, 0.1 * fitted_.fit.noise.variance);
  EXPECT_LT(largest, 0.25 * (together - former));
}

}  // namespace
}  // namespace mle
