#include "mle/filter/residual_prediction.h"

#include <algorithm>
#include <cmath>

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The variance of a level that is not known, in those of a sample.
constexpr double kUnknown = 1e7;
// A gain this near to the stationary one, as a share, is it.
constexpr double kSettled = 1e-3;

// The squared errors of forecasts f(h), h = 1 … H, made at sample l.
template <typename Forecast>
SquaredErrors ErrorsFrom(const VectorXd& residual, Index l,
                         const PredictionGrid& grid, const Forecast& forecast) {
  SquaredErrors errors;
  for (Index h = 1; h <= grid.horizon; ++h) {
    const Index at = l + h * grid.samples;
    if (at >= residual.size()) break;
    if (!std::isfinite(residual(at))) continue;
    const double error = residual(at) - forecast(h);
    errors.sum += error * error;
    errors.count += 1.0;
  }
  return errors;
}

// Adds what is predicted from sample l to its block.
void AddTo(std::vector<SquaredErrors>& blocks, Index l, Index first,
           const PredictionGrid& grid, const SquaredErrors& errors) {
  const auto block = static_cast<std::size_t>(
      (l - first) / (Index{grid.horizon} * grid.samples));
  if (block >= blocks.size()) blocks.resize(block + 1);
  blocks[block].Add(errors);
}

Index FirstMeasured(const VectorXd& residual) {
  Index first = 0;
  while (first < residual.size() && !std::isfinite(residual(first))) ++first;
  return first;
}

// Nothing is known of the walk; what decays is stationary.
StateMatrix StartCovariance(const DisturbanceSystem& system,
                            const LevelAndRest& parts) {
  const Index n = system.order() - 1;
  StateMatrix P = StateMatrix::Zero(n + 1, n + 1);
  if (n > 0) {
    P.bottomRightCorner(n, n) =
        StationaryCovariance(parts.B, parts.N.bottomRightCorner(n, n));
  }
  const double size = system.noise_variance + P.trace();
  return P + kUnknown * size * parts.level * parts.level.transpose();
}

// P of the next sample, and the gain of this one, 0 where it is not measured;
// whether the gain is the stationary one from here on.
bool AdvanceCovariance(const DisturbanceSystem& system,
                       const StationaryFilter& filter, bool measured,
                       StateMatrix& P, StateVector& gain) {
  const StateVector PC = P * system.C.transpose();
  const double F = system.C.dot(PC) + system.noise_variance;
  P = (system.A * P * system.A.transpose() + system.Q).eval();
  if (!measured) {
    gain.setZero();
    return false;
  }
  gain = system.A * PC / F;
  P -= gain * gain.transpose() * F;
  if (!((gain - filter.gain).norm() <= kSettled * filter.gain.norm())) {
    return false;
  }
  gain = filter.gain;
  return true;
}

}  // namespace

SquaredErrors Together(const std::vector<SquaredErrors>& blocks) {
  SquaredErrors all;
  for (const SquaredErrors& block : blocks) all.Add(block);
  return all;
}

std::vector<SquaredErrors> BiasErrors(const VectorXd& residual, double gain,
                                      const PredictionGrid& grid, Index first,
                                      Index last) {
  std::vector<SquaredErrors> errors;
  Index l = FirstMeasured(residual);
  if (l == residual.size()) return errors;
  double bias = 0.0;
  double known = 0.0;  // samples, as a mean counts them
  for (; l < last; l += grid.samples) {
    if (std::isfinite(residual(l))) {
      known += 1.0;
      bias += std::max(gain, 1.0 / known) * (residual(l) - bias);
    }
    if (l < first) continue;
    AddTo(errors, l, first, grid,
          ErrorsFrom(residual, l, grid, [&](Index) { return bias; }));
  }
  return errors;
}

std::vector<SquaredErrors> KalmanErrors(const VectorXd& residual,
                                        const DisturbanceSystem& system,
                                        const StationaryFilter& filter,
                                        const PredictionGrid& grid, Index first,
                                        Index last) {
  std::vector<SquaredErrors> errors;
  const Index start = FirstMeasured(residual);
  if (start == residual.size()) return errors;
  // Rows C A^{hs−1}, which predict from the state of the sample to come.
  MatrixXd ahead(grid.horizon, system.order());
  StateRow row = system.C;
  for (Index h = 0, power = 0; h < grid.horizon; ++h) {
    for (; power < (h + 1) * grid.samples - 1; ++power) row *= system.A;
    ahead.row(h) = row;
  }
  const LevelAndRest parts = Separate(system);
  StateVector state = parts.level * residual(start);
  StateMatrix P = StartCovariance(system, parts);
  StateVector gain = filter.gain;
  bool settled = false;
  for (Index k = start; k < last; ++k) {
    const bool measured = std::isfinite(residual(k));
    if (!settled) {
      settled = AdvanceCovariance(system, filter, measured, P, gain);
    }
    const double innovation =
        measured ? residual(k) - system.C.dot(state) : 0.0;
    state = (system.A * state + innovation * gain).eval();
    if (k < first || (k - start) % grid.samples != 0) continue;
    AddTo(errors, k, first, grid, ErrorsFrom(residual, k, grid, [&](Index h) {
            return ahead.row(h - 1).dot(state);
          }));
  }
  return errors;
}

}  // namespace mle
