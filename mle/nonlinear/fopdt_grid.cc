#include "mle/nonlinear/fopdt_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "glog/logging.h"
#include "mle/nonlinear/brent_search.h"

namespace mle {
namespace {

// Neighbours on the grid differ by at most this factor.
constexpr double kGridRatio = 1.3;
// Accuracy of a search, in bits of half its interval of ln T: some 1e-5.
constexpr int kTimeBits = 16;

struct GridCandidate {
  FopdtParameters parameters;
  // Σ y² less this is the sum of squared residuals.
  double explained = -std::numeric_limits<double>::infinity();
};

// Sums over the samples k ≥ k₀ with weights e_j = r^j, j = k − k₀.
struct TailSums {
  double n = 0.0;
  double e = 0.0;
  double ee = 0.0;
  double y = 0.0;
  double ye = 0.0;
};

// The best gain for a given q.
GridCandidate BestGain(const TailSums& sums, double q) {
  GridCandidate candidate;
  const double norm = sums.n - 2.0 * q * sums.e + q * q * sums.ee;
  const double product = sums.y - q * sums.ye;
  if (!(norm > 0.0)) return candidate;
  candidate.parameters.gain = product / norm;
  candidate.explained = product * product / norm;
  return candidate;
}

// The best gain and dead time in the sample before k₀. Its late end, q → 1, is
// the early end of the next sample.
GridCandidate BestInSample(const TailSums& sums, int k0, double time_constant,
                           double r, double max_delay) {
  const double max_q =
      std::min(1.0, std::exp(-(k0 - max_delay) / time_constant));
  double q = r;
  GridCandidate best = BestGain(sums, r);
  const double determinant = sums.n * sums.ee - sums.e * sums.e;
  const double gain = sums.ee * sums.y - sums.e * sums.ye;
  const double c = sums.e * sums.y - sums.n * sums.ye;
  if (determinant > 0.0 && gain != 0.0) {
    const double inner = c / gain;
    if (inner > r && inner <= max_q) {
      const GridCandidate candidate = BestGain(sums, inner);
      if (candidate.explained > best.explained) {
        best = candidate;
        q = inner;
      }
    }
  }
  best.parameters.time_constant = time_constant;
  best.parameters.delay =
      std::clamp(k0 + time_constant * std::log(q), k0 - 1.0, max_delay);
  return best;
}

// The best gain and dead time at one time constant.
GridCandidate BestAtTimeConstant(
    const Eigen::Ref<const Eigen::VectorXd>& response, double time_constant,
    double max_delay) {
  const int samples = static_cast<int>(response.size());
  const double r = std::exp(-1.0 / time_constant);
  const int last_k0 = std::min(samples - 3, 1 + static_cast<int>(max_delay));
  GridCandidate best;
  TailSums sums;
  for (int k = samples - 1; k >= 1; --k) {
    // One step earlier every weight is r times its former one.
    sums.n += 1.0;
    sums.e = 1.0 + r * sums.e;
    sums.ee = 1.0 + r * r * sums.ee;
    sums.y += response(k);
    sums.ye = response(k) + r * sums.ye;
    if (k > last_k0 || k - 1 > max_delay) continue;
    const GridCandidate candidate =
        BestInSample(sums, k, time_constant, r, max_delay);
    if (candidate.explained > best.explained) best = candidate;
  }
  return best;
}

// The best on a logarithmic grid of time constants.
std::vector<GridCandidate> SearchGrid(
    const Eigen::Ref<const Eigen::VectorXd>& response,
    const FopdtBounds& bounds) {
  const double log_min = std::log(bounds.min_time_constant);
  const double log_range = std::log(bounds.max_time_constant) - log_min;
  const int points =
      2 + static_cast<int>(std::ceil(log_range / std::log(kGridRatio)));
  std::vector<GridCandidate> grid(points);
  for (int i = 0; i < points; ++i) {
    const double time_constant =
        std::clamp(std::exp(log_min + log_range * i / (points - 1)),
                   bounds.min_time_constant, bounds.max_time_constant);
    grid[i] = BestAtTimeConstant(response, time_constant, bounds.max_delay);
  }
  return grid;
}

// The best between two time constants.
GridCandidate SearchDelayBetween(
    const Eigen::Ref<const Eigen::VectorXd>& response, double low_time,
    double high_time, double max_delay) {
  GridCandidate best;
  SearchLeast(std::log(low_time), std::log(high_time), kTimeBits,
              [&](double log_time) {
                const GridCandidate candidate =
                    BestAtTimeConstant(response, std::exp(log_time), max_delay);
                if (candidate.explained > best.explained) best = candidate;
                return -candidate.explained;
              });
  return best;
}

}  // namespace

FopdtParameters FindFopdtStart(
    const Eigen::Ref<const Eigen::VectorXd>& response,
    const FopdtBounds& bounds, int num_minima) {
  CHECK_GE(response.size(), 5);
  CHECK_GT(bounds.min_time_constant, 0.0);
  CHECK_GE(bounds.max_time_constant, bounds.min_time_constant);
  const std::vector<GridCandidate> grid = SearchGrid(response, bounds);
  const int points = static_cast<int>(grid.size());
  std::vector<int> minima;
  for (int i = 0; i < points; ++i) {
    const bool beats_left = i == 0 || grid[i].explained > grid[i - 1].explained;
    const bool beats_right =
        i + 1 == points || grid[i].explained >= grid[i + 1].explained;
    if (beats_left && beats_right) minima.push_back(i);
  }
  std::sort(minima.begin(), minima.end(), [&grid](int a, int b) {
    return grid[a].explained > grid[b].explained;
  });
  if (static_cast<int>(minima.size()) > num_minima) minima.resize(num_minima);

  GridCandidate best;
  for (const int i : minima) {
    const GridCandidate refined = SearchDelayBetween(
        response, grid[std::max(i - 1, 0)].parameters.time_constant,
        grid[std::min(i + 1, points - 1)].parameters.time_constant,
        bounds.max_delay);
    for (const GridCandidate& candidate : {grid[i], refined}) {
      if (candidate.explained > best.explained) best = candidate;
    }
  }
  return best.parameters;
}

}  // namespace mle
