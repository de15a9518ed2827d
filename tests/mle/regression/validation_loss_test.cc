#include "mle/regression/validation_loss.h"

#include <cmath>
#include <random>

#include "gtest/gtest.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/regression/explicit_lasso.h"

namespace mle {
namespace {

// A fit to one part of a series, with validation on another part.
class ValidationLossTest : public ::testing::TestWithParam<Scaling> {
 protected:
  static constexpr int kOrder = 6;

  ValidationLossTest() : series_(MakeRecord(), kOrder) {
    std::mt19937_64 random(2);
    fitted_ = Rows({kOrder, 149}, 0.5, random);
    validation_ = Rows({150, 239}, 0.9, random);
    problem_ =
        MakeLassoProblem(ComputeLaggedMoments({&fitted_, 1}), GetParam());
  }

  // Means far from zero, different in the two parts, and an input that is held
  // during the first.
  static Record MakeRecord() {
    std::mt19937_64 random(1);
    Record record;
    record.sample_time = 1.0;
    record.outputs = RandomMatrix(1, 240, random).array() + 3.0;
    record.inputs = 10.0 * RandomMatrix(2, 240, random);
    record.outputs.rightCols(90).array() += 0.5;
    record.inputs.row(1).head(150).setConstant(0.0);
    return record;
  }

  // Two responses: lags with noise and an offset.
  RegressionRows Rows(RowRange range, double offset,
                      std::mt19937_64& random) const {
    const Eigen::MatrixXd X = series_.Regressors(range);
    RegressionRows rows{&series_, range, RandomMatrix(2, range.rows(), random)};
    rows.responses.row(0) += 0.8 * X.row(0) - 0.05 * X.row(4);
    rows.responses.row(1) += 0.02 * X.row(7);
    rows.responses.array() += offset;
    return rows;
  }

  LassoPath Path(int response) const {
    const auto summary = SolveHomotopy(LassoObjective(problem_, response), {});
    EXPECT_TRUE(summary.ok()) << summary.status();
    return summary->path;
  }

  // 1/(2N) Σ (e − b₀ − bᵀx)², row by row.
  double DirectLoss(const Eigen::VectorXd& beta, int response) const {
    const Eigen::VectorXd b = problem_.Unscale(beta);
    const double intercept = problem_.response_mean(response, 0) -
                             b.dot(problem_.regressor_mean.col(0));
    const auto X = series_.Regressors(validation_.rows);
    double sum = 0.0;
    for (Eigen::Index k = 0; k < X.cols(); ++k) {
      const double error =
          validation_.responses(response, k) - intercept - b.dot(X.col(k));
      sum += error * error;
    }
    return sum / (2.0 * static_cast<double>(X.cols()));
  }

  LaggedSeries series_;
  RegressionRows fitted_;
  RegressionRows validation_;
  LassoProblem problem_;
};

TEST_P(ValidationLossTest, IsTheLossOfTheRows) {
  const ValidationRows rows(problem_, ComputeLaggedMoments({&validation_, 1}));
  for (int response = 0; response < 2; ++response) {
    const LassoPath path = Path(response);
    const PiecewiseQuadratic loss = rows.Loss(path, response);
    for (const double part :
         {2.0, 1.0, 0.99, 0.7, 0.3, 0.1, 1e-2, 1e-3, 1e-5, 0.0}) {
      const double lambda = part * path.lambda_begin();
      const double direct = DirectLoss(path.Coefficients(lambda), response);
      // Sums of 90 squares about a mean of their own size.
      EXPECT_NEAR(loss(lambda), direct, 1e-12 * direct) << "at " << part;
    }
    for (const auto& piece : loss.pieces()) {
      EXPECT_GE(piece.curvature, 0.0);
      EXPECT_NEAR(loss(piece.lambda_begin), piece.value, 1e-12 * piece.value);
    }
  }
}

// A group that was fitted is predicted about the fitted means, another about
// its own.
TEST_P(ValidationLossTest, KnowsTheMeansOfGroups) {
  if (GetParam() == Scaling::kRaw) return;
  for (const int group : {0, 1}) {
    RegressionRows fitted = fitted_;
    fitted.group = group;
    const ValidationRows one(problem_, ComputeLaggedMoments({&validation_, 1}));
    const LassoProblem problem =
        MakeLassoProblem(ComputeLaggedMoments({&fitted, 1}, 2), GetParam());
    const ValidationRows rows(problem,
                              ComputeLaggedMoments({&validation_, 1}, 2));
    const LassoPath path = Path(0);
    const double lambda = 0.1 * path.lambda_begin();
    const double loss = rows.Loss(path, 0)(lambda);
    const Eigen::VectorXd b = problem.Unscale(path.Coefficients(lambda));
    const Eigen::RowVectorXd error =
        validation_.responses.row(0) -
        b.transpose() * series_.Regressors(validation_.rows);
    const double spread = (error.array() - error.mean()).square().sum() / 180.0;
    const double expected = group == 0 ? one.Loss(path, 0)(lambda) : spread;
    EXPECT_NEAR(loss, expected, 1e-12 * expected);
  }
}

TEST_P(ValidationLossTest, OnTheFittedRowsIsThePrimalLoss) {
  const ValidationRows rows(problem_, ComputeLaggedMoments({&fitted_, 1}));
  const LassoObjective objective(problem_, 0);
  const LassoPath path = Path(0);
  const PiecewiseQuadratic loss = rows.Loss(path, 0);
  const PiecewiseQuadratic penalty = PenaltyAlong(path, objective.weights);
  for (const double part : {1.5, 0.8, 0.2, 1e-2, 1e-4, 0.0}) {
    const double lambda = part * path.lambda_begin();
    const DualityGap gap =
        ComputeDualityGap(objective, lambda, path.Coefficients(lambda));
    EXPECT_NEAR(loss(lambda) + penalty(lambda), gap.primal, 1e-12 * gap.primal);
  }
}

TEST_P(ValidationLossTest, PenaltyIsTheWeightedNorm) {
  Eigen::VectorXd weights =
      Eigen::VectorXd::LinSpaced(problem_.num_regressors(), 0.5, 2.0);
  weights(3) = 0.0;
  const LassoObjective objective(problem_, 0, weights);
  const auto summary = SolveHomotopy(objective, {});
  ASSERT_TRUE(summary.ok());
  const LassoPath& path = summary->path;
  const PiecewiseQuadratic penalty = PenaltyAlong(path, objective.weights);
  const double lambda_max = objective.LambdaMax();
  for (const double part : {3.0, 0.9, 0.5, 0.1, 1e-2, 1e-4, 0.0}) {
    const double lambda = part * lambda_max;
    const Eigen::VectorXd beta = path.Coefficients(lambda);
    double expected = 0.0;
    for (int j = 0; j < beta.size(); ++j) {
      if (beta(j) != 0.0) {
        expected += lambda * objective.weights(j) * std::abs(beta(j));
      }
    }
    // Of terms no greater than λ_max Σ|β|.
    EXPECT_NEAR(penalty(lambda), expected,
                1e-13 * lambda_max * beta.lpNorm<1>());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scalings, ValidationLossTest,
    ::testing::Values(Scaling::kStandardise, Scaling::kRaw),
    [](const auto& test) {
      return std::string(test.param == Scaling::kRaw ? "Raw" : "Standardised");
    });

}  // namespace
}  // namespace mle
