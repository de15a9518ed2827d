#include "mle/nonlinear/noise_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

// Two records of 1,500 samples.
OutputSetup Prepare(const RecordNoise& noise, unsigned seed) {
  const ProcessModel model = TwoElements();
  auto setups = SetUpOutputs(model, MakeRecords(model, 1500, seed, noise), {});
  EXPECT_TRUE(setups.ok()) << setups.status();
  return std::move(setups->front());
}

NoiseEstimate Estimate(const OutputSetup& setup, const NoiseEstimate& start,
                       bool search_ar) {
  return EstimateNoise(*setup.problem, setup.start, {true, true}, start,
                       /*estimate_drift=*/true, search_ar);
}

// The products that likelihoods and evidences are made of are those of the
// whitened columns, with columns besides, whatever the shape.
TEST(NoiseSearchTest, ProductsAreThoseOfTheWhitenedColumns) {
  const OutputSetup setup = Prepare({.variance = 0.01, .increment = 1e-4}, 3);
  const OutputErrorProblem& problem = *setup.problem;
  const std::vector<bool> free = {true, true};
  for (const NoiseShape& shape : {NoiseShape{}, NoiseShape{.ratio = 0.02}}) {
    std::vector<SegmentColumns> columns =
        problem.Linearise(setup.start, shape, free);
    const std::vector<Eigen::MatrixXd> more = problem.LagSums({1, 4, 9});
    const ShapedProducts shaped =
        ShapeLikelihood(problem, columns, free, /*restricted=*/true)
            .With(more)
            .ProductsAt(shape);
    for (std::size_t s = 0; s < columns.size(); ++s) {
      Eigen::MatrixXd all(more[s].rows(), 6 + more[s].cols());
      all << columns[s].jacobian, more[s];
      columns[s].jacobian = all;
    }
    const WhitenedColumns whitened = problem.Whiten(columns, shape);
    Eigen::MatrixXd rows(whitened.residuals.size(),
                         whitened.jacobian.cols() + 1);
    rows << whitened.jacobian, whitened.residuals;
    const Eigen::MatrixXd products = rows.transpose() * rows;
    const Eigen::VectorXd roots = products.diagonal().cwiseSqrt();
    EXPECT_LT((roots.cwiseInverse().asDiagonal() *
               (shaped.products - products) * roots.cwiseInverse().asDiagonal())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
    EXPECT_NEAR(shaped.log_determinant, whitened.log_determinant, 1e-8);
    EXPECT_NEAR(shaped.log_amplitudes, whitened.log_amplitudes, 1e-6);
    EXPECT_EQ(shaped.num_amplitudes, whitened.num_amplitudes);
  }
}

// Whatever the drift, wherever the search begins and however many columns take
// slow changes up: no value of a fine grid is likelier, but for what does not
// count.
TEST(NoiseSearchTest, NoRatioIsLikelierThanTheBest) {
  for (const double increment : {0.0, 1e-9, 1e-6, 1e-4, 1e-2, 1.0}) {
    const OutputSetup setup =
        Prepare({.variance = 0.01, .increment = increment}, 11);
    const ShapeLikelihood alone(*setup.problem, setup.start, {true, true},
                                NoiseShape(), /*restricted=*/true);
    std::vector<int> lags;
    for (int lag = 1; lag < 60; lag += 3) lags.push_back(lag);
    for (const ShapeLikelihood& likelihood :
         {alone, alone.With(setup.problem->LagSums(lags))}) {
      double least = likelihood.At(NoiseShape()).value;
      for (double at = kMinLogRatio; at <= kMaxLogRatio; at += 0.05) {
        least = std::min(least, likelihood.At({.ratio = std::exp(at)}).value);
      }
      for (const double start :
           {0.0, 1e-9, LeastRatio(*setup.problem), 1e-4, 1.0, 1e5}) {
        const Profile best =
            FindBestShape(likelihood, {.ratio = start},
                          /*estimate_drift=*/true, /*search_ar=*/false);
        EXPECT_LT(best.value, least + 0.01)
            << increment << ", " << likelihood.width() << " columns, from "
            << start << ": " << best.shape.ratio;
        EXPECT_EQ(best.value, likelihood.At(best.shape).value);
      }
    }
  }
}

// At the true parameters; with 2,900 samples r and s are known to about 10 %
// and 15 %, 1 − φ to 20 %. Four such deviations.
TEST(NoiseSearchTest, FindsAnArComponent) {
  for (const double pole : {0.8, 0.95}) {
    const OutputSetup setup =
        Prepare({.variance = 0.01, .shock = 0.01, .pole = pole}, 1);
    const NoiseEstimate noise = Estimate(setup, NoiseEstimate(), true);
    EXPECT_NEAR(noise.variance, 0.01, 0.004);
    EXPECT_NEAR(noise.ar_ratio * noise.variance, 0.01, 0.006);
    EXPECT_NEAR((1.0 - noise.ar_pole) / (1.0 - pole), 1.0, 0.6);
    EXPECT_EQ(noise.ar_damping, 0.0);
    // The walk that is left: less than the AR component's deviation over a
    // record.
    EXPECT_LT(1500.0 * noise.increment_variance(), noise.ar_variance());
    EXPECT_NEAR(noise.ar_memory(), -1.0 / std::log(noise.ar_pole), 1e-9);
    for (const int i : {1, 2}) {
      EXPECT_GT(noise.log_deviations[i], 0.02);
      EXPECT_LT(noise.log_deviations[i], 0.5);
    }
  }
}

// Twice the logarithm of the number of samples has to be gained: of twenty
// records without an AR component not one is given it.
TEST(NoiseSearchTest, WhiteNoiseAndDriftStayWhatTheyAre) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const double increment = seed % 2 == 0 ? 0.0 : 1e-4;
    const OutputSetup setup =
        Prepare({.variance = 0.01, .increment = increment}, seed);
    const NoiseEstimate noise = Estimate(setup, NoiseEstimate(), true);
    EXPECT_EQ(noise.ar_ratio, 0.0) << seed;
    EXPECT_EQ(noise.log_deviations[1], 0.0);
    EXPECT_NEAR(noise.variance, 0.01, 0.0015);
  }
}

// An autoregression behind a lag, as from an input; the time constants of both
// poles are known to some 20 %, the natural one is their geometric mean.
TEST(NoiseSearchTest, FindsALoad) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const double lag = std::exp(-0.5 / 4.0);
    const OutputSetup setup = Prepare(
        {.variance = 0.0025, .shock = 0.01, .pole = 0.97, .lag = lag}, seed);
    const NoiseEstimate noise = Estimate(setup, NoiseEstimate(), true);
    ASSERT_GT(noise.ar_damping, 0.0) << seed;
    EXPECT_NEAR(noise.variance, 0.0025, 0.0005);
    EXPECT_NEAR(noise.ar_memory() / std::sqrt(8.0 / -std::log(0.97)), 1.0, 0.5);
    EXPECT_GT(noise.ar_damping, 0.6);
    // Of (1 − ψ) η behind the lag.
    EXPECT_NEAR(
        noise.ar_ratio * noise.variance / (0.01 * (1.0 - lag) * (1.0 - lag)),
        1.0, 0.7);
    for (const int i : {1, 2, 3}) {
      EXPECT_GT(noise.log_deviations[i], 0.01);
      EXPECT_LT(noise.log_deviations[i], 1.0);
    }
  }
}

// The search ends at a maximum: the shape moved in any of its logarithms is
// less likely; from there it stays.
class NoiseSearchEndTest : public ::testing::TestWithParam<double> {};

TEST_P(NoiseSearchEndTest, IsAMaximumAndStays) {
  const OutputSetup setup = Prepare({.variance = 0.01,
                                     .increment = 1e-4,
                                     .shock = 0.02,
                                     .pole = 0.7 + 0.2 * GetParam(),
                                     .lag = GetParam()},
                                    3);
  const NoiseEstimate noise = Estimate(setup, NoiseEstimate(), true);
  ASSERT_GT(noise.ar_ratio, 0.0);
  EXPECT_EQ(noise.ar_damping > 0.0, GetParam() > 0.0);
  const NoiseShape shape = ShapeOf(noise);
  const ShapeLikelihood likelihood(*setup.problem, setup.start, {true, true},
                                   shape, /*restricted=*/true);
  const double best = likelihood.At(shape).value;
  for (int i = 0; i < kShapeParameters; ++i) {
    if (!HasParameter(shape, i)) continue;
    for (const double by : {-0.3, 0.3}) {
      EXPECT_GT(likelihood.At(Moved(shape, i, by)).value, best + 0.01)
          << i << " by " << by;
    }
  }
  const NoiseEstimate again = Estimate(setup, noise, false);
  EXPECT_EQ(again.ar_ratio, noise.ar_ratio);
  EXPECT_EQ(again.ar_pole, noise.ar_pole);
  EXPECT_EQ(again.ar_damping, noise.ar_damping);
  EXPECT_EQ(again.ratio, noise.ratio);
}

INSTANTIATE_TEST_SUITE_P(Lags, NoiseSearchEndTest, ::testing::Values(0.0, 0.8));

TEST(NoiseSearchTest, ArComponentIsNotSoughtUnasked) {
  const OutputSetup setup =
      Prepare({.variance = 0.01, .shock = 0.01, .pole = 0.9}, 4);
  EXPECT_EQ(Estimate(setup, NoiseEstimate(), false).ar_ratio, 0.0);
}

}  // namespace
}  // namespace mle
