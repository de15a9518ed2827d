#include "mle/filter/bias_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/LU"
#include "glog/logging.h"
#include "mle/nonlinear/brent_search.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const double kLeastLogGain = std::log(1e-6);
constexpr int kGridPoints = 28;  // two an e-fold
constexpr int kGainBits = 20;

// The coloured component (a) or (a, b): γ_k = (A^k Σ)_{11} with its stationary
// covariance Σ.
struct Coloured {
  MatrixXd A;
  VectorXd covariance;  // the first column of Σ

  explicit Coloured(const DisturbanceSystem& system) {
    const Eigen::Index n = system.order() - 1;
    A = system.A.bottomRightCorner(n, n);
    covariance =
        StationaryCovariance(A, system.Q.bottomRightCorner(n, n)).col(0);
  }
};

}  // namespace

double BiasFilterError(const DisturbanceSystem& system, double gain,
                       int horizon) {
  CHECK(gain > 0.0 && gain <= 1.0);
  CHECK_GE(horizon, 1);
  const double q = system.Q(0, 0);
  const double r = system.noise_variance;
  const double kept = 1.0 - gain;
  const double left = gain * (2.0 - gain);  // 1 − θ²
  double error = (kept * kept * q + gain * gain * r) / left + r +
                 0.5 * (horizon + 1.0) * q;
  if (system.order() == 1) return error;
  const Coloured coloured(system);
  const Eigen::Index n = coloured.A.rows();
  const Eigen::PartialPivLU<MatrixXd> rest(MatrixXd::Identity(n, n) -
                                           kept * coloured.A);
  // Σ_{k≥0} θ^k γ_k.
  const double now = coloured.covariance(0);
  const double sum = rest.solve(coloured.covariance)(0);
  error += gain * gain * (2.0 * sum - now) / left + now;
  VectorXd later = coloured.covariance;
  double ahead = 0.0;
  for (int h = 1; h <= horizon; ++h) {
    later = (coloured.A * later).eval();
    ahead += rest.solve(later)(0);
  }
  return error - 2.0 * gain * ahead / horizon;
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
