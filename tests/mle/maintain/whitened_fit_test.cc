#include "mle/maintain/whitened_fit.h"

#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Cholesky"
#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle {
namespace {

// Two responses in a random walk and white noise.
WhitenedData Data(double walk, double noise, std::uint64_t seed) {
  constexpr int kSamples = 2000;
  WhitenedData data;
  GaussianNoise random(seed, 0, kMeasurementNoise);
  for (int w = 0; w < 2; ++w) {
    const Eigen::MatrixXd white = random.DrawMatrix(2, kSamples, 1.0);
    Eigen::VectorXd& output = data.outputs.emplace_back(kSamples);
    Eigen::MatrixXd& responses = data.responses.emplace_back(kSamples, 2);
    double level = 10.0 * w;
    for (int k = 0; k < kSamples; ++k) {
      level += walk * white(0, k);
      responses(k, 0) = std::sin(0.01 * k * (w + 1));
      responses(k, 1) = k / 300 % 2;
      output(k) = level + noise * white(1, k) + 2.0 * responses(k, 0) -
                  0.5 * responses(k, 1);
    }
  }
  return data;
}

// The regression of each value on those before it, row by row; its ends count
// as much as the rest, so few rows tell.
TEST(WhitenedFitTest, FilterIsTheLeastSquaresOne) {
  constexpr int kOrder = 3;
  WhitenedData data;
  GaussianNoise random(5, 0, kMeasurementNoise);
  for (const int samples : {9, 14}) {
    Eigen::VectorXd output = random.DrawMatrix(samples, 1, 1.0);
    output(0) = 5.0;
    output(samples - 1) = -6.0;
    data.outputs.emplace_back(output.array() - output.mean());
    data.responses.emplace_back(samples, 0);
  }
  Eigen::MatrixXd rows(9 + 14 - 2 * kOrder, kOrder);
  Eigen::VectorXd present(rows.rows());
  Eigen::Index row = 0;
  for (const Eigen::VectorXd& output : data.outputs) {
    for (Eigen::Index k = kOrder; k < output.size(); ++k, ++row) {
      rows.row(row) = output.segment(k - kOrder, kOrder);
      present(row) = output(k);
    }
  }
  const Eigen::VectorXd phi =
      (rows.transpose() * rows).llt().solve(rows.transpose() * present);
  const Eigen::VectorXd filter =
      WhiteningFilter(data, Eigen::VectorXd(), kOrder);
  EXPECT_LT((filter.head(kOrder) + phi).norm(), 1e-8);
  EXPECT_EQ(filter(kOrder), 1.0);
}

// A ramp and a level of an output become an offset of its increments.
TEST(WhitenedFitTest, IncrementsTurnRampsIntoOffsets) {
  WhitenedData data;
  data.outputs.push_back(Eigen::VectorXd::LinSpaced(5, 7.0, 15.0));
  data.responses.emplace_back(Eigen::MatrixXd::Random(5, 2));
  const WhitenedData increments = Increments(data);
  EXPECT_EQ(increments.outputs[0](0), 0.0);
  EXPECT_LT((increments.outputs[0].tail(4).array() - 2.0).abs().maxCoeff(),
            1e-14);
  for (int k = 1; k < 5; ++k) {
    EXPECT_EQ(increments.responses[0].row(k),
              data.responses[0].row(k) - data.responses[0].row(k - 1));
  }
  EXPECT_TRUE(increments.responses[0].row(0).isZero(0.0));
}

// Gains of 2 and −0.5: as the model has them nothing is free; where one or both
// are other than 1, each costs ½ ln 4000.
TEST(WhitenedFitTest, FewGainsCostTheirPrice) {
  WhitenedData data = Data(0.0, 0.1, 3);
  const double price = 0.5 * std::log(4000.0);
  const double both =
      FitWhitenedGains(data, Eigen::Vector2d(1.0, 1.0)).log_likelihood;
  EXPECT_NEAR(FewGainsLogLikelihood(data), both - 2.0 * price, 0.1);
  WhitenedData one = data;
  for (Eigen::MatrixXd& responses : one.responses) responses.col(1) *= -0.5;
  EXPECT_NEAR(FewGainsLogLikelihood(one), both - price, 3.0);
  EXPECT_GT(FewGainsLogLikelihood(one), both - price - 0.1);
  WhitenedData none = one;
  for (Eigen::MatrixXd& responses : none.responses) responses.col(0) *= 2.0;
  EXPECT_EQ(FewGainsLogLikelihood(none),
            WhitenedLogLikelihood(none, Eigen::Vector2d(1.0, 1.0)));
  EXPECT_EQ(FewGainsLogLikelihood(WhitenedData()),
            WhitenedLogLikelihood(WhitenedData(), Eigen::VectorXd()));
}

// Against sums that are written out, whatever is left of the last samples that
// are taken together.
TEST(WhitenedFitTest, AFilterIsTheSumOverItsTaps) {
  const Eigen::VectorXd filter{{-0.25, 0.5, -1.5, 1.0}};
  for (int samples = 4; samples < 30; ++samples) {
    const Eigen::VectorXd values = Eigen::VectorXd::Random(samples);
    Eigen::VectorXd expected(samples - 3);
    for (int k = 0; k < samples - 3; ++k) {
      expected(k) = -0.25 * values(k) + 0.5 * values(k + 1) -
                    1.5 * values(k + 2) + values(k + 3);
    }
    expected.array() -= expected.mean();
    const Eigen::VectorXd filtered = ApplyFilter(filter, values);
    ASSERT_EQ(filtered.size(), samples - 3);
    EXPECT_LT((filtered - expected).cwiseAbs().maxCoeff(), 1e-14) << samples;
  }
}

// At every seed within 4 standard errors, which are about the deviation of the
// estimates.
TEST(WhitenedFitTest, FindsGainsAndTheirErrors) {
  for (const double walk : {0.0, 0.02}) {
    double squares = 0.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const WhitenedFit fit =
          FitWhitenedGains(Data(walk, 0.05, seed), Eigen::Vector2d::Ones());
      EXPECT_LT(std::abs(fit.gains(0) - 2.0), 4.0 * fit.errors(0));
      const double deviation = (fit.gains(1) + 0.5) / fit.errors(1);
      EXPECT_LT(std::abs(deviation), 4.0);
      squares += deviation * deviation;
    }
    EXPECT_NEAR(squares / 40.0, 1.0, 0.6) << walk;
  }
}

TEST(WhitenedFitTest, TheFitHasTheLargestLikelihood) {
  const WhitenedData data = Data(0.02, 0.05, 1);
  const WhitenedFit fit = FitWhitenedGains(data, Eigen::Vector2d::Ones());
  EXPECT_NEAR(WhitenedLogLikelihood(data, fit.gains), fit.log_likelihood, 1e-6);
  for (const double step : {-0.1, 0.1}) {
    for (int j = 0; j < 2; ++j) {
      Eigen::VectorXd gains = fit.gains;
      gains(j) += step;
      EXPECT_LT(WhitenedLogLikelihood(data, gains), fit.log_likelihood);
    }
  }
}

// In other units the same gains, errors and differences of likelihoods.
TEST(WhitenedFitTest, UnitsDoNotMatter) {
  const WhitenedData data = Data(0.02, 0.05, 2);
  WhitenedData scaled = data;
  for (auto& output : scaled.outputs) output *= 1e-3;
  for (auto& responses : scaled.responses) responses *= 1e-3;
  const Eigen::Vector2d start = Eigen::Vector2d::Ones();
  const WhitenedFit a = FitWhitenedGains(data, start);
  const WhitenedFit b = FitWhitenedGains(scaled, start);
  EXPECT_LT((a.gains - b.gains).norm(), 1e-6);
  EXPECT_LT((a.errors - b.errors).norm(), 1e-6);
  EXPECT_NEAR(a.log_likelihood - WhitenedLogLikelihood(data, start),
              b.log_likelihood - WhitenedLogLikelihood(scaled, start), 1e-4);
}

TEST(WhitenedFitTest, AResponseOfZeroKeepsItsGain) {
  WhitenedData data = Data(0.0, 0.05, 3);
  for (auto& responses : data.responses) responses.col(1).setZero();
  const WhitenedFit fit = FitWhitenedGains(data, Eigen::Vector2d::Ones());
  EXPECT_EQ(fit.gains(1), 1.0);
  EXPECT_EQ(fit.errors(1), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isfinite(fit.errors(0)));
}

// Columns that are zero, in some windows or in all, are nowhere in the others'
// way.
TEST(WhitenedFitTest, ColumnsOfZerosChangeNothing) {
  WhitenedData data = Data(0.002, 0.05, 6);
  data.outputs[1] -= 2.0 * data.responses[1].col(0);
  data.responses[1].col(0).setZero();
  WhitenedData wide = data;
  for (std::size_t w = 0; w < data.responses.size(); ++w) {
    wide.responses[w].setZero(data.responses[w].rows(), 5);
    wide.responses[w].col(1) = data.responses[w].col(0);
    wide.responses[w].col(4) = data.responses[w].col(1);
  }
  const WhitenedFit narrow = FitWhitenedGains(data, Eigen::Vector2d::Ones());
  const WhitenedFit fit = FitWhitenedGains(wide, Eigen::VectorXd::Ones(5));
  for (const auto& [at, of] : {std::pair(1, 0), std::pair(4, 1)}) {
    EXPECT_NEAR(fit.gains(at), narrow.gains(of), 1e-9);
    EXPECT_NEAR(fit.errors(at), narrow.errors(of), 1e-9);
  }
  for (const int at : {0, 2, 3}) {
    EXPECT_EQ(fit.gains(at), 1.0);
    EXPECT_EQ(fit.errors(at), std::numeric_limits<double>::infinity());
  }
  EXPECT_NEAR(fit.log_likelihood, narrow.log_likelihood, 1e-6);
  const WhitenedFit first = FitWhitenedGains(
      {.outputs = {data.outputs[0]}, .responses = {data.responses[0]}},
      Eigen::Vector2d::Ones());
  EXPECT_LT(narrow.errors(1), 0.85 * first.errors(1));
  const WhitenedFit none = FitWhitenedGains(
      {.outputs = data.outputs,
       .responses = {Eigen::MatrixXd(2000, 0), Eigen::MatrixXd(2000, 0)}},
      Eigen::VectorXd());
  EXPECT_TRUE(std::isfinite(none.log_likelihood));
  EXPECT_LT(none.log_likelihood, fit.log_likelihood);
}

TEST(WhitenedFitTest, MeansOfBlocks) {
  const WhitenedData means = BlockMeans(Data(0.0, 0.05, 4), 7);
  const WhitenedData data = Data(0.0, 0.05, 4);
  ASSERT_EQ(means.outputs[1].size(), 285);
  EXPECT_NEAR(means.outputs[1](3), data.outputs[1].segment(21, 7).mean(),
              1e-12);
  EXPECT_NEAR(means.responses[0](284, 0),
              data.responses[0].col(0).segment(284 * 7, 7).mean(), 1e-12);
}

// An exact fit has a likelihood that is large, not infinite.
TEST(WhitenedFitTest, NothingLeftIsFinite) {
  const WhitenedData data = Data(0.0, 0.0, 5);
  const WhitenedFit fit = FitWhitenedGains(data, Eigen::Vector2d::Ones());
  EXPECT_TRUE(std::isfinite(fit.log_likelihood));
  EXPECT_NEAR(fit.gains(0), 2.0, 1e-6);
}

}  // namespace
}  // namespace mle
