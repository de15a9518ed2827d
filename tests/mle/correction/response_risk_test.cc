#include "mle/correction/response_risk.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "gtest/gtest.h"
#include "mle/correction/correction.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

constexpr int kSamples = 13;  // N + 1, three times the order and one

ArxModel BelievedModel() {
  ArxModel model = SparseArx();
  model.R(0, 2) = 0.6;
  return model;
}

Correction Corrected(std::uint64_t seed, int samples = 200,
                     double noise = 0.3) {
  CorrectionOptions options;
  options.lambdas = *MakeLambdaGrid(0.4, 0.01);
  options.selection.rule = SelectionOptions::Rule::kAic;  // the quickest
  auto correction =
      CorrectModel(BelievedModel(),
                   {SimulateArx(SparseArx(), samples, noise, seed)}, options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

std::optional<ResponseRisk> RiskOf(const Correction& correction) {
  return ResponseRisk::Create(correction.initial(), correction.problem(),
                              correction.penalty_weights(), kSamples);
}

double Distance(const ArxModel& model) {
  return SquaredDistance(SparseArx().ComputeStepResponse(kSamples),
                         model.ComputeStepResponse(kSamples));
}

TEST(StepResponseSensitivityTest, IsTheDerivative) {
  const ArxModel model = SparseArx();
  const std::vector<int> samples = {0, 1, 5, 12};
  constexpr double kStep = 1e-6;
  for (int q = 0; q < 2; ++q) {
    const Eigen::MatrixXd J = StepResponseSensitivity(model, q, samples);
    ASSERT_EQ(J.rows(), 16);
    for (int column = 0; column < 16; ++column) {
      ArxModel up = model;
      ArxModel down = model;
      up.R(q, column) += kStep;
      down.R(q, column) -= kStep;
      const StepResponse above = up.ComputeStepResponse(kSamples);
      const StepResponse below = down.ComputeStepResponse(kSamples);
      Eigen::Index row = 0;
      for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) {
          for (const int k : samples) {
            const double numeric =
                (above.element(i, j)(k) - below.element(i, j)(k)) /
                (2.0 * kStep);
            // Third derivatives and rounding: 1e-12 and 1e-16 over the step.
            EXPECT_NEAR(J(row, column), numeric, 1e-8)
                << "row " << q << ", column " << column << ", pair " << i << j
                << ", sample " << k;
            ++row;
          }
        }
      }
    }
  }
}

// The mean of Ê over records is that of E, at every λ, and that of E of least
// squares is the variance.
TEST(ResponseRiskTest, IsUnbiased) {
  constexpr int kRecords = 200;
  const std::vector<double> lambdas = {0.0, 0.02, 0.1, 0.4};
  Eigen::VectorXd estimated = Eigen::VectorXd::Zero(4);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(4);
  Eigen::VectorXd actual = Eigen::VectorXd::Zero(4);
  double variance = 0.0;
  for (int seed = 1; seed <= kRecords; ++seed) {
    const Correction correction = Corrected(seed);
    const auto risk = RiskOf(correction);
    ASSERT_TRUE(risk.has_value());
    variance += risk->variance() / kRecords;
    for (int n = 0; n < 4; ++n) {
      const double error = Distance(correction.Model(lambdas[n]));
      const double estimate = (*risk)(correction.fits(), lambdas[n]);
      estimated(n) += estimate / kRecords;
      actual(n) += error / kRecords;
      squares(n) += std::pow(estimate - error, 2.0) / kRecords;
    }
  }
  for (int n = 0; n < 4; ++n) {
    // Four standard errors of the mean, and a tenth for what is not linear.
    const double tolerance =
        4.0 * std::sqrt(squares(n) / kRecords) + 0.1 * actual(n);
    EXPECT_NEAR(estimated(n), actual(n), tolerance) << "λ = " << lambdas[n];
    EXPECT_LT(tolerance, 0.5 * actual(n));
  }
  EXPECT_NEAR(variance, actual(0), 0.15 * actual(0));
}

// Ŝ₀ alone makes Ê uncertain: its square has √(2 tr K²).
TEST(ResponseRiskTest, DeviationIsThatOfTheLeastSquaresError) {
  constexpr int kRecords = 300;
  double sum = 0.0;
  double squares = 0.0;
  double deviation = 0.0;
  for (int seed = 1; seed <= kRecords; ++seed) {
    const Correction correction = Corrected(seed);
    const auto risk = RiskOf(correction);
    ASSERT_TRUE(risk.has_value());
    const double error = Distance(correction.Model(0.0));
    sum += error / kRecords;
    squares += error * error / kRecords;
    deviation += risk->deviation() / kRecords;
  }
  const double actual = std::sqrt(squares - sum * sum);
  EXPECT_NEAR(deviation, actual, 0.25 * actual);
}

TEST(ResponseRiskTest, NeedsADeterminedLeastSquaresFit) {
  EXPECT_TRUE(RiskOf(Corrected(1, 40)).has_value());
  // 18 samples have 14 rows, for 16 coefficients.
  EXPECT_FALSE(RiskOf(Corrected(1, 18)).has_value());

  // An input that copies another one.
  Record twin = SimulateArx(SparseArx(), 200, 0.3, 1);
  twin.inputs.row(1) = twin.inputs.row(0);
  CorrectionOptions options;
  options.lambdas = *MakeLambdaGrid(0.4, 0.01);
  const auto dependent = CorrectModel(BelievedModel(), {twin}, options);
  ASSERT_TRUE(dependent.ok()) << dependent.status();
  EXPECT_FALSE(RiskOf(*dependent).has_value());
  EXPECT_EQ(dependent->selection().response_risk.size(), 0);

  // An input that nearly copies another one: their sum alone is determined.
  twin.inputs.row(1) +=
      1e-4 * SimulateArx(SparseArx(), 200, 0.3, 2).inputs.row(0);
  const auto vague = CorrectModel(BelievedModel(), {twin}, options);
  ASSERT_TRUE(vague.ok()) << vague.status();
  EXPECT_FALSE(RiskOf(*vague).has_value());

  ArxModel unstable = SparseArx();
  unstable.R(0, 0) = 1.3;
  const auto growing = CorrectModel(
      BelievedModel(), {SimulateArx(unstable, 60, 0.3, 1)}, options);
  ASSERT_TRUE(growing.ok()) << growing.status();
  EXPECT_FALSE(RiskOf(*growing).has_value());
}

// A column held at zero is none of the least-squares fit.
TEST(ResponseRiskTest, HeldColumnsStayAtZero) {
  CorrectionOptions options;
  options.lambdas = *MakeLambdaGrid(0.4, 0.01);
  options.penalty_weights.setOnes(2, 16);
  options.penalty_weights(0, 2) = std::numeric_limits<double>::infinity();
  const auto correction = CorrectModel(
      BelievedModel(), {SimulateArx(SparseArx(), 200, 0.3, 1)}, options);
  ASSERT_TRUE(correction.ok()) << correction.status();
  const auto held = RiskOf(*correction);
  const auto freed = ResponseRisk::Create(correction->initial(),
                                          correction->problem(), {}, kSamples);
  ASSERT_TRUE(held.has_value());
  ASSERT_TRUE(freed.has_value());
  // The best fit without it is far from the best fit with it.
  EXPECT_LT((*held)(correction->fits(), 0.0), held->variance() + 1e-9);
  EXPECT_GT((*freed)(correction->fits(), 0.0), 10.0 * freed->variance());
}

}  // namespace
}  // namespace mle
