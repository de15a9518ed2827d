// The peaks of the sensitivities of loops.

#include <algorithm>
#include <cmath>
#include <complex>

#include "control/loop_analysis.h"
#include "gtest/gtest.h"
#include "tests/control/analysed_loops.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using analysed_loops::Analyse;
using analysed_loops::FastTwoByTwo;
using analysed_loops::MakeAnalysedMpc;
using analysed_loops::Options;
using analysed_loops::Predict;
using testing::SecondOrder;
using testing::SingleLoop;

// A plant whose gain grows loses stability where the sensitivity's peak goes to
// infinity.
TEST(LoopPeaksTest, SensitivityGrowsWithoutBoundTowardsInstability) {
  const auto process = [](double gain) {
    return SingleLoop(TransferFunction::FirstOrder(gain, 5.0, 2.0));
  };
  const Mpc mpc = MakeAnalysedMpc(Predict(process(1.0)), Options(1, 1, 0.1));
  double stable = 1.0, unstable = 100.0;
  while (unstable - stable > 1e-5) {
    const double gain = 0.5 * (stable + unstable);
    (Analyse(mpc, Predict(process(gain))).stable ? stable : unstable) = gain;
  }
  const double far = Analyse(mpc, Predict(process(1.0))).sensitivity_peak;
  const double near =
      Analyse(mpc, Predict(process(stable * 0.999))).sensitivity_peak;
  EXPECT_LT(far, 2.5);
  EXPECT_GT(near, 100.0);
}

// A relative change of the plant below 1/‖T‖ cannot make the loop unstable
// (small-gain theorem).
TEST(LoopPeaksTest, ComplementaryPeakBoundsHarmlessChanges) {
  const auto process = [](double gain) {
    return SingleLoop(SecondOrder(gain, -1.0, 4.0, 2.0, 1.5));
  };
  for (const double weight : {0.01, 0.1, 1.0}) {
    const Mpc mpc =
        MakeAnalysedMpc(Predict(process(1.0)), Options(1, 1, weight));
    const double M_T = Analyse(mpc, Predict(process(1.0))).complementary_peak;
    const double change = 0.99 / M_T;
    EXPECT_TRUE(Analyse(mpc, Predict(process(1.0 + change))).stable) << weight;
    if (change < 1.0) {
      EXPECT_TRUE(Analyse(mpc, Predict(process(1.0 - change))).stable);
    }
  }
}

// The peaks of one loop whose plant has aged, with a slow observer, from the
// series of the header term by term, S = 1/(1 + P C): over all frequencies, and
// so fine that what lies between does not matter.
TEST(LoopPeaksTest, PeaksAreThoseOfTheSeries) {
  const PredictionModel model =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 5.0, 2.0)));
  const PredictionModel plant =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.6, 4.0, 3.0)));
  const Mpc mpc = MakeAnalysedMpc(model, Options(1, 1, 0.1));
  const double g = mpc.observer().gains()(0);
  ASSERT_LT(g, 0.9);
  using Complex = std::complex<double>;
  const auto at = [](const PredictionModel& of, int k) {
    return of.responses(std::min(k, of.periods()), 0);
  };
  double sensitivity = 0.0;
  double complementary = 0.0;
  for (double theta = 2e-3; theta <= M_PI; theta += 2e-3) {
    const Complex w = std::polar(1.0, -theta);
    // Σ_{a≥1} S_{a+i−1} w^a: the rest beyond the last term is one geometric.
    const auto series = [&](const PredictionModel& of, int i) {
      Complex sum = 0.0;
      Complex power = 1.0;
      for (int a = 1; a <= of.periods(); ++a) {
        power *= w;
        sum += at(of, a + i - 1) * power;
      }
      return sum + at(of, of.periods()) * power * w / (1.0 - w);
    };
    const Complex observer = g / (1.0 - (1.0 - g) * w);
    const Complex F_0 = series(model, 0);
    Complex back = 1.0;
    Complex forward = 0.0;
    for (Eigen::Index i = 0; i < mpc.gain().cols(); ++i) {
      const double K = mpc.gain()(0, i);
      back += K * (series(model, static_cast<int>(i) + 1) - observer * F_0);
      forward += K * observer;
    }
    const Complex S = 1.0 / (1.0 + series(plant, 0) * forward / back);
    sensitivity = std::max(sensitivity, std::abs(S));
    complementary = std::max(complementary, std::abs(1.0 - S));
  }
  const LoopAnalysis analysis = Analyse(mpc, plant);
  ASSERT_TRUE(analysis.stable);
  EXPECT_NEAR(analysis.sensitivity_peak, sensitivity, 1e-3 * sensitivity);
  EXPECT_NEAR(analysis.complementary_peak, complementary, 1e-3 * complementary);
}

// T(0) = 1: no offset. So both peaks are at least 1 for T, and S exceeds 1
// somewhere (Bode's integral).
TEST(LoopPeaksTest, PeaksAreAtLeastOne) {
  const PredictionModel model = Predict(FastTwoByTwo());
  const LoopAnalysis analysis =
      Analyse(MakeAnalysedMpc(model, Options(2, 2, 0.1)), model);
  EXPECT_TRUE(analysis.stable);
  EXPECT_GT(analysis.sensitivity_peak, 1.0);
  EXPECT_GE(analysis.complementary_peak, 1.0 - 1e-3);
  EXPECT_GT(analysis.peak_frequency, 0.0);
}

}  // namespace
}  // namespace mle::control
