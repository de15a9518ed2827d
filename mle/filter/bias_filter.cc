#include "mle/filter/bias_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "glog/logging.h"
#include "mle/nonlinear/brent_search.h"

namespace mle {
namespace {

using Eigen::Index;

const double kLeastLogGain = std::log(1e-6);
constexpr int kGridPoints = 28;  // two an e-fold
constexpr int kGainBits = 20;

}  // namespace

double BiasFilterError(const DisturbanceSystem& system, double gain,
                       int horizon) {
  CHECK(gain > 0.0 && gain <= 1.0);
  CHECK_GE(horizon, 1);
  const Index n = system.order();
  const double r = system.noise_variance;
  const LevelAndRest parts = Separate(system);
  const StateRow C = system.C.tail(n - 1);
  // (δ, y)_l = M (δ, y)_{l−1} + W (ξ, η) + (g v, 0).
  StateMatrix M = StateMatrix::Zero(n, n);
  M(0, 0) = 1.0 - gain;
  M.row(0).tail(n - 1) = gain * C * parts.B;
  M.bottomRightCorner(n - 1, n - 1) = parts.B;
  StateMatrix W = StateMatrix::Identity(n, n);
  W(0, 0) = gain - 1.0;
  W.row(0).tail(n - 1) = gain * C;
  StateMatrix shocks = W * parts.N * W.transpose();
  shocks(0, 0) += gain * gain * r;
  const StateMatrix stationary = StationaryCovariance(M, shocks);
  StateRow row(n);
  StateRow ahead = C;  // C B^h
  double of_shocks = 0.0;
  double sum = 0.0;
  for (int h = 1; h <= horizon; ++h) {
    row << 1.0, ahead;
    of_shocks += (row * parts.N).dot(row);
    ahead *= parts.B;
    row << -1.0, ahead;
    sum += (row * stationary).dot(row) + of_shocks;
  }
  return sum / horizon + r;
}

double BestBiasGain(const DisturbanceSystem& system, int horizon) {
  const auto error = [&](double log_gain) {
    return BiasFilterError(system, std::min(std::exp(log_gain), 1.0), horizon);
  };
  const double step = -kLeastLogGain / kGridPoints;
  double best = 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kGridPoints; ++i) {
    const double at = kLeastLogGain + i * step;
    const double value = error(at);
    if (value >= least) continue;
    least = value;
    best = at;
  }
  const double found =
      SearchLeast(std::max(best - step, kLeastLogGain),
                  std::min(best + step, 0.0), kGainBits, error);
  return std::min(std::exp(error(found) < least ? found : best), 1.0);
}

}  // namespace mle
