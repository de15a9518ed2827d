#include "mle/trial/change_window.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRows = 12;

// G(l) = variance + drift l/2, as of many pairs.
Variogram NoiseOf(double variance, double drift) {
  Variogram noise = {VectorXd(kRows - 1), VectorXd(kRows - 1)};
  for (int l = 1; l < kRows; ++l) {
    noise.counts(l - 1) = 1e6;
    noise.sums(l - 1) = 1e6 * (variance + 0.5 * drift * l);
  }
  return noise;
}

VectorXd Response() {
  VectorXd response(kRows);
  for (int k = 0; k < kRows; ++k) {
    response(k) = k < 3 ? 0.0 : 1.0 - std::exp(-0.5 * (k - 2));
  }
  return response;
}

OutputComparison Compare(const Variogram& noise, const VectorXd& in_use,
                         const VectorXd& proposed, const VectorXd& driven) {
  return CompareOutput(noise, noise, in_use, proposed, driven,
                       driven.transpose());
}

// In white noise of variance σ² all directions count alike: W = P/((1 + δ) σ²),
// δ = 0.05.
TEST(ChangeWindowTest, WhiteNoiseWeighsAllDirectionsAlike) {
  const MatrixXd loss =
      LossMatrix(NoiseOf(0.04, 0.0), std::vector<bool>(kRows, true));
  const MatrixXd expected = (MatrixXd::Identity(kRows, kRows) -
                             MatrixXd::Constant(kRows, kRows, 1.0 / kRows)) /
                            (1.05 * 0.04);
  EXPECT_LT((loss - expected).cwiseAbs().maxCoeff(), 1e-10);
}

// A level is no error, whatever the noise is, and rows that are not known count
// for nothing.
TEST(ChangeWindowTest, LevelsAndUnknownRowsHaveNoWeight) {
  std::vector<bool> known(kRows, true);
  known[4] = false;
  const MatrixXd loss = LossMatrix(NoiseOf(0.01, 0.02), known);
  EXPECT_LT((loss * VectorXd::Ones(kRows)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(loss.row(4).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT((loss - loss.transpose()).cwiseAbs().maxCoeff(), 1e-9);
}

// D = ½ zᵀWz where the proposed model is right, −½ zᵀWz where the other is,
// and 0 half-way between; σ² = zᵀWz but for the rows that it was estimated
// from.
TEST(ChangeWindowTest, GainTellsWhichModelIsRight) {
  const Variogram noise = NoiseOf(0.01, 0.001);
  const VectorXd z = Response();
  const VectorXd nothing = VectorXd::Zero(kRows);
  const OutputComparison right = Compare(noise, z, nothing, z);
  EXPECT_GT(right.size, 0.0);
  EXPECT_NEAR(right.gain, 0.5 * right.size, 1e-9 * right.size);
  EXPECT_NEAR(right.deviation, std::sqrt(right.size),
              1e-4 * std::sqrt(right.size));
  const OutputComparison wrong = Compare(noise, nothing, -z, z);
  EXPECT_NEAR(wrong.gain, -0.5 * wrong.size, 1e-9 * wrong.size);
  const OutputComparison between = Compare(noise, 0.5 * z, -0.5 * z, z);
  EXPECT_NEAR(between.gain, 0.0, 1e-9 * right.size);
}

// What set points drive of residuals is what the shapes explain, less the one
// direction of noise.
TEST(ChangeWindowTest, ShapesExplainWhatSetPointsDrive) {
  const Variogram noise = NoiseOf(0.01, 0.0);
  const VectorXd z = Response();
  const OutputComparison compared = Compare(noise, z, VectorXd::Zero(kRows), z);
  EXPECT_NEAR(compared.in_use, compared.size - 1.0, 1e-3 * compared.size);
  EXPECT_NEAR(compared.proposed, -1.0, 1e-9);
}

// More noise in the response than at rest makes it count for less.
TEST(ChangeWindowTest, DisturbedResponsesCountForLess) {
  const Variogram noise = NoiseOf(0.01, 0.0);
  const VectorXd z = Response();
  VectorXd disturbance(kRows);
  for (int k = 0; k < kRows; ++k) disturbance(k) = k % 2 == 0 ? 1.0 : -1.0;
  const OutputComparison quiet = Compare(noise, z, VectorXd::Zero(kRows), z);
  const OutputComparison disturbed =
      Compare(noise, z + disturbance, disturbance, z);
  EXPECT_GT(disturbed.deviation, 5.0 * quiet.deviation);
}

TEST(ChangeWindowTest, NothingIsJudgedWithoutRestOrRows) {
  Variogram few = NoiseOf(0.01, 0.0);
  few.sums *= 1e-5;
  few.counts *= 1e-5;  // ten pairs: less than a window
  const VectorXd z = Response();
  EXPECT_EQ(Compare(few, z, VectorXd::Zero(kRows), z).deviation, 0.0);
  VectorXd gaps = z;
  gaps.head(4).setConstant(kNaN);
  EXPECT_EQ(
      Compare(NoiseOf(0.01, 0.0), gaps, VectorXd::Zero(kRows), z).deviation,
      0.0);
  // All rows stand in for the rest.
  EXPECT_GT(CompareOutput(few, NoiseOf(0.01, 0.0), z, VectorXd::Zero(kRows), z,
                          z.transpose())
                .deviation,
            0.0);
}

}  // namespace
}  // namespace mle
