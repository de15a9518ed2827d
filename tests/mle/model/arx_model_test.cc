#include "mle/model/arx_model.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// Random coefficients, a share `density` of them non-zero, that make a stable
// model: the sum of magnitudes over the outputs' past is below 1.
ArxModel RandomModel(int order, int p, int m, double density, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  ArxModel model{0.2, order, p, m, Eigen::MatrixXd::Zero(p, order * (p + m))};
  for (int i = 0; i < p; ++i) {
    double sum = 1e-3;
    for (int a = 0; a < order; ++a) {
      for (int c = 0; c < p + m; ++c) {
        if (uniform(engine) > density) continue;
        const double value = normal(engine);
        model.R(i, a * (p + m) + c) = value;
        if (c < p) sum += std::abs(value);
      }
    }
    for (int a = 0; a < order; ++a) {
      model.R.row(i).segment(a * (p + m), p) *= 0.95 / sum;
    }
  }
  return model;
}

// The model's equation, term by term.
Eigen::MatrixXd Simulate(const ArxModel& model, int input, int samples) {
  const int p = model.num_outputs;
  const int m = model.num_inputs;
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(p, samples);
  Eigen::VectorXd regressor(model.num_regressors());
  for (int k = 0; k + 1 < samples; ++k) {
    for (int a = 1; a <= model.order; ++a) {
      const int past = k - a + 1;
      auto part = regressor.segment((a - 1) * (p + m), p + m);
      part.setZero();
      if (past < 0) continue;
      part.head(p) = y.col(past);
      part(p + input) = 1.0;
    }
    y.col(k + 1) = model.R * regressor;
  }
  return y;
}

TEST(ArxModelTest, StepResponseIsASimulationOfTheEquation) {
  const struct {
    int order, p, m, samples;
    double density;
  } cases[] = {
      {1, 1, 1, 40, 1.0},    {2, 2, 1, 50, 1.0},   {7, 1, 3, 33, 1.0},
      {8, 2, 2, 200, 1.0},   {9, 3, 2, 201, 0.5},  {150, 2, 2, 501, 1.0},
      {150, 2, 2, 501, 0.1}, {60, 5, 4, 100, 0.2}, {40, 1, 1, 10, 1.0},
      {3, 2, 2, 1, 1.0},     {3, 2, 2, 2, 1.0},    {30, 2, 2, 400, 0.02},
  };
  unsigned seed = 1;
  for (const auto& c : cases) {
    const ArxModel model = RandomModel(c.order, c.p, c.m, c.density, seed++);
    ASSERT_TRUE(model.Validate().ok());
    const StepResponse response = model.ComputeStepResponse(c.samples);
    ASSERT_EQ(response.samples(), c.samples);
    EXPECT_EQ(response.sample_time, 0.2);
    for (int j = 0; j < c.m; ++j) {
      const Eigen::MatrixXd expected = Simulate(model, j, c.samples);
      const double scale = 1.0 + expected.cwiseAbs().maxCoeff();
      for (int i = 0; i < c.p; ++i) {
        // The same sums in another order; rounding does not grow in a stable
        // model.
        EXPECT_LT((response.element(i, j) - expected.row(i).transpose())
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-12 * scale)
            << "order " << c.order << " output " << i << " input " << j;
      }
    }
  }
}

TEST(ArxModelTest, FirstOrderModelHasTheClosedForm) {
  // y_{k+1} = a y_k + b u_{k−2}: b (1 − a^{k−2})/(1 − a) from k = 3 on.
  ArxModel model{0.5, 3, 1, 1, Eigen::MatrixXd::Zero(1, 6)};
  const double a = 0.9;
  const double b = 0.3;
  model.R(0, 0) = a;
  model.R(0, 5) = b;
  const StepResponse response = model.ComputeStepResponse(100);
  for (int k = 0; k < 100; ++k) {
    const double expected =
        k < 3 ? 0.0 : b * (1.0 - std::pow(a, k - 2)) / (1.0 - a);
    EXPECT_NEAR(response.values(k, 0), expected, 1e-14 * 100) << k;
  }
}

TEST(ArxModelTest, FiniteImpulseResponseIsACumulativeSum) {
  ArxModel model{0.2, 4, 1, 1, Eigen::MatrixXd::Zero(1, 8)};
  model.R << 0, 1, 0, 2, 0, 4, 0, 8;
  const StepResponse response = model.ComputeStepResponse(8);
  Eigen::VectorXd expected(8);
  expected << 0, 1, 3, 7, 15, 15, 15, 15;
  EXPECT_EQ(response.values.col(0), expected);
}

TEST(ArxModelTest, ResponseIsLinearInTheInputCoefficients) {
  ArxModel model = RandomModel(20, 2, 2, 0.5, 3);
  const StepResponse once = model.ComputeStepResponse(120);
  for (int a = 0; a < 20; ++a) model.R.middleCols(a * 4 + 2, 2) *= 2.0;
  const StepResponse twice = model.ComputeStepResponse(120);
  EXPECT_EQ(twice.values, 2.0 * once.values);  // Exact: a power of two.
}

TEST(ArxModelTest, UnstableModelSaturates) {
  for (const double root : {2.0, -2.0, 1e200}) {
    ArxModel model{0.2, 2, 1, 1, Eigen::MatrixXd::Zero(1, 4)};
    model.R << root, -1.0, 0.0, 0.0;
    for (const double tail : {0.0, -1e200, 0.5}) {
      model.R(0, 2) = tail;
      const StepResponse response = model.ComputeStepResponse(2000);
      EXPECT_TRUE(response.values.allFinite());
      EXPECT_LE(response.values.cwiseAbs().maxCoeff(), 1e100);
      if (tail == 0.0) {
        EXPECT_EQ(std::abs(response.values(1999, 0)), 1e100) << root;
      }
    }
    EXPECT_TRUE(std::isfinite(SquaredDistance(model.ComputeStepResponse(2000),
                                              StepResponse(0.2, 1, 1, 2000))));
  }
}

TEST(ArxModelTest, ValidateSaysWhatIsWrong) {
  const auto message = [](const ArxModel& model) {
    return std::string(model.Validate().message());
  };
  ArxModel model = RandomModel(5, 2, 1, 1.0, 1);
  EXPECT_TRUE(model.Validate().ok());
  model.order = 6;
  EXPECT_THAT(message(model), HasSubstr("R is 2 × 15, must be 2 × 18"));
  model.order = 0;
  EXPECT_THAT(message(model), HasSubstr("order is 0"));
  model.order = 5;
  model.sample_time = 0.0;
  EXPECT_THAT(message(model), HasSubstr("sample_time is 0"));
  model.sample_time = 0.2;
  model.R(1, 3) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(model), HasSubstr("not finite"));
}

}  // namespace
}  // namespace mle
