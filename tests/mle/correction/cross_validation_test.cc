#include "mle/correction/cross_validation.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/correction/prediction_residuals.h"
#include "mle/regression/homotopy.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

// Windows of different lengths, about an operating point, of a plant whose
// first gain is not what the model believes.
RegressionData Data(int windows, Scaling scaling) {
  ArxModel model = SparseArx();
  model.R(0, 2) = 0.6;
  std::vector<Record> records;
  for (int i = 0; i < windows; ++i) {
    records.push_back(
        SimulateArx(SparseArx(), 120 + 30 * i, 0.3, 5 + i, 2.0, 1.0));
  }
  auto data = RegressionData::Create(records, model, scaling);
  EXPECT_TRUE(data.ok()) << data.status();
  return *std::move(data);
}

struct DirectLosses {
  Eigen::MatrixXd values;  // folds × outputs, 1/(2N) Σ (e − b₀ − bᵀx)²
  double penalty = 0.0;
};

// Each fold predicted by the fit to the others, row by row.
DirectLosses Direct(const std::vector<Fold>& folds, Scaling scaling,
                    double lambda, const Eigen::VectorXd& weight) {
  DirectLosses losses;
  losses.values.setZero(static_cast<Eigen::Index>(folds.size()), 2);
  for (std::size_t f = 0; f < folds.size(); ++f) {
    std::vector<RegressionRows> others;
    for (std::size_t g = 0; g < folds.size(); ++g) {
      if (g != f) others.insert(others.end(), folds[g].begin(), folds[g].end());
    }
    const LassoProblem problem =
        MakeLassoProblem(ComputeLaggedMoments(others), scaling);
    for (int q = 0; q < 2; ++q) {
      const auto fit = SolveHomotopy(LassoObjective(problem, q), {});
      EXPECT_TRUE(fit.ok());
      const Eigen::VectorXd beta = fit->path.Coefficients(lambda);
      const auto fold = static_cast<Eigen::Index>(f);
      losses.penalty += weight(fold) * lambda * beta.lpNorm<1>();
      const Eigen::VectorXd b = problem.Unscale(beta);
      const double intercept =
          problem.response_mean(q, 0) - b.dot(problem.regressor_mean.col(0));
      double sum = 0.0;
      double count = 0.0;
      for (const RegressionRows& rows : folds[f]) {
        const Eigen::VectorXd error =
            rows.responses.row(q).transpose() -
            rows.series->Regressors(rows.rows).transpose() * b;
        sum += (error.array() - intercept).square().sum();
        count += rows.rows.rows();
      }
      losses.values(fold, q) = sum / (2.0 * count);
    }
  }
  return losses;
}

class CrossValidationTest : public ::testing::TestWithParam<Scaling> {};

TEST_P(CrossValidationTest, LossesAreThoseOfTheFoldsRows) {
  const RegressionData data = Data(3, GetParam());
  for (const std::vector<Fold>& folds :
       {FoldsByWindow(data), FoldsByBlock(data, 4, 20)}) {
    CrossValidationOptions options;
    options.scaling = GetParam();
    options.grid = Eigen::VectorXd::LinSpaced(101, 0.0, 0.5);
    options.lambdas = options.grid;
    const auto losses = CrossValidate(data, folds, options);
    ASSERT_TRUE(losses.ok()) << losses.status();
    EXPECT_LE(losses->max_relative_gap, 1e-9);
    ASSERT_EQ(losses->values.size(), 2U);
    ASSERT_EQ(losses->exact.size(), folds.size());

    double rows = 0.0;
    for (const Fold& fold : folds) {
      for (const RegressionRows& part : fold) rows += part.rows.rows();
    }
    const double count = static_cast<double>(folds.size());
    for (std::size_t f = 0; f < folds.size(); ++f) {
      double own = 0.0;
      for (const RegressionRows& part : folds[f]) own += part.rows.rows();
      EXPECT_NEAR(losses->weight(static_cast<Eigen::Index>(f)),
                  own * count / rows, 1e-14);
    }
    for (const int i : {0, 1, 20, 60, 100}) {
      const double lambda = options.grid(i);
      const DirectLosses direct =
          Direct(folds, GetParam(), lambda, losses->weight);
      for (std::size_t f = 0; f < folds.size(); ++f) {
        const auto fold = static_cast<Eigen::Index>(f);
        for (std::size_t q = 0; q < 2; ++q) {
          const double expected =
              direct.values(fold, static_cast<Eigen::Index>(q));
          // The same squares, here as moments about other means.
          EXPECT_NEAR(losses->values[q](fold, i), expected, 1e-12 * expected);
          EXPECT_NEAR(losses->exact[f][q](lambda),
                      losses->weight(fold) * expected, 1e-12 * expected);
        }
      }
      EXPECT_NEAR(losses->penalty(i), direct.penalty,
                  1e-12 * (1.0 + direct.penalty));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scalings, CrossValidationTest,
    ::testing::Values(Scaling::kStandardise, Scaling::kRaw),
    [](const auto& test) {
      return std::string(test.param == Scaling::kRaw ? "Raw" : "Standardised");
    });

// Measured less simulated outputs, oldest first, on the model's own outputs
// after the lags of the first row.
Eigen::MatrixXd SimulationErrors(const LaggedSeries& series, RowRange rows,
                                 const Eigen::MatrixXd& R) {
  Eigen::MatrixXd z = series.Samples({0, rows.last}).rowwise().reverse();
  const Eigen::MatrixXd measured = z;
  for (int k = rows.first; k <= rows.last; ++k) {
    Eigen::Vector2d y = Eigen::Vector2d::Zero();
    for (int lag = 1; lag <= series.order(); ++lag) {
      y += R.middleCols(4 * lag - 4, 4) * z.col(k - lag);
    }
    z.col(k).head(2) = y;
  }
  return (measured - z).topRightCorner(2, rows.rows());
}

// Anew from measured outputs every `horizon` samples, less the mean.
Eigen::MatrixXd ErrorsAhead(const LaggedSeries& series, RowRange rows,
                            const Eigen::MatrixXd& R, int horizon) {
  const int length = horizon > 0 ? horizon : rows.rows();
  Eigen::MatrixXd errors(2, rows.rows());
  for (int first = rows.first; first <= rows.last; first += length) {
    const int last = std::min(first + length - 1, rows.last);
    errors.middleCols(first - rows.first, last - first + 1) =
        SimulationErrors(series, {first, last}, R);
  }
  errors.colwise() -= errors.rowwise().mean().eval();
  return errors;
}

class CrossValidationAheadTest : public ::testing::TestWithParam<int> {};

TEST_P(CrossValidationAheadTest, LossesAreThoseOfTheRecursion) {
  const RegressionData data = Data(2, Scaling::kRaw);
  for (const std::vector<Fold>& folds :
       {FoldsByWindow(data), FoldsByBlock(data, 3, 20, 5)}) {
    CrossValidationOptions options;
    options.scaling = Scaling::kRaw;
    options.horizon = GetParam();
    options.grid = Eigen::Vector3d(0.01, 0.1, 0.3);
    options.lambdas = options.grid;
    const auto losses = CrossValidate(data, folds, options);
    ASSERT_TRUE(losses.ok()) << losses.status();
    EXPECT_TRUE(losses->exact.empty());
    for (std::size_t f = 0; f < folds.size(); ++f) {
      std::vector<RegressionRows> others;
      for (std::size_t g = 0; g < folds.size(); ++g) {
        if (g != f) {
          others.insert(others.end(), folds[g].begin(), folds[g].end());
        }
      }
      const LassoProblem problem =
          MakeLassoProblem(ComputeLaggedMoments(others), Scaling::kRaw);
      for (Eigen::Index i = 0; i < options.lambdas.size(); ++i) {
        Eigen::MatrixXd R = data.model_R();
        for (int q = 0; q < 2; ++q) {
          const auto fit = SolveHomotopy(LassoObjective(problem, q), {});
          ASSERT_TRUE(fit.ok());
          R.row(q) += fit->path.Coefficients(options.lambdas(i)).transpose();
        }
        Eigen::Vector2d squares = Eigen::Vector2d::Zero();
        double count = 0.0;
        for (const RegressionRows& part : folds[f]) {
          // Predictions run through the whole window of the part.
          for (int w = 0; w < data.num_windows(); ++w) {
            const RegressionRows& run = data.window(w).front();
            if (run.series != part.series) continue;
            squares += ErrorsAhead(*run.series, run.rows, R, GetParam())
                           .middleCols(part.rows.first - run.rows.first,
                                       part.rows.rows())
                           .rowwise()
                           .squaredNorm();
            count += part.rows.rows();
          }
        }
        for (Eigen::Index q = 0; q < 2; ++q) {
          const double expected = 0.5 * squares(q) / count;
          EXPECT_NEAR(losses->values[q](static_cast<Eigen::Index>(f), i),
                      expected, 1e-11 * expected);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Horizons, CrossValidationAheadTest,
                         ::testing::Values(0, 2, 7, 1000));

TEST(PredictionResidualsTest, AreThoseOfTheRecursion) {
  const RegressionData data = Data(2, Scaling::kRaw);
  const RegressionRows& run = data.window(1).front();
  for (const int horizon : {0, 1, 2, 7, 1000}) {
    const Eigen::MatrixXd errors =
        PredictionResiduals(*run.series, run.rows, data.model_R(), horizon);
    const Eigen::MatrixXd expected =
        ErrorsAhead(*run.series, run.rows, data.model_R(), horizon);
    EXPECT_LE((errors.rowwise().reverse() - expected).cwiseAbs().maxCoeff(),
              1e-12 * expected.cwiseAbs().maxCoeff())
        << "horizon " << horizon;
  }
}

TEST(PredictionResidualsTest, LossOfAModelThatRunsAwayIsInfinite) {
  const RegressionData data = Data(2, Scaling::kRaw);
  const std::vector<Fold> folds = FoldsByWindow(data);
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(2, 16);
  change(0, 0) = 1e12;
  change(1, 1) = 1e12;
  const std::vector<Eigen::MatrixXd> changes = {Eigen::MatrixXd::Zero(2, 16),
                                                change};
  const Eigen::MatrixXd loss = AheadLosses(data, folds[0], 0).Of(changes);
  EXPECT_TRUE(loss.col(0).allFinite());
  EXPECT_EQ(loss(0, 1), std::numeric_limits<double>::infinity());
  EXPECT_EQ(loss(1, 1), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace mle
