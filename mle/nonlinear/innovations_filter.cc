#include "mle/nonlinear/innovations_filter.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"

namespace mle {
namespace {

// Columns filtered at once: each sample waits for the one before, and
// recurrences that do not need each other fill the time.
constexpr Eigen::Index kTogether = 4;

// A product of F_k beyond this is exchanged for its logarithm: far from
// overflow, and one logarithm serves many samples.
constexpr double kLargeProduct = 1e100;

// The product of many factors as the sum of their logarithms.
class LogProduct {
 public:
  void Multiply(double factor) {
    product_ *= factor;
    if (product_ > kLargeProduct) {
      sum_ += std::log(product_);
      product_ = 1.0;
    }
  }
  double log() const { return sum_ + std::log(product_); }

 private:
  double product_ = 1.0;
  double sum_ = 0.0;
};

double WhiteVariance(const Eigen::VectorXd& weights, std::size_t k) {
  return weights.size() > 0 ? 1.0 / weights(static_cast<Eigen::Index>(k)) : 1.0;
}

}  // namespace

InnovationsFilter::InnovationsFilter(const std::vector<int>& times,
                                     const NoiseShape& shape,
                                     const Eigen::VectorXd& weights)
    : gains_(times.size()),
      inverse_roots_(times.size()),
      smoothing_(shape.coloured() ? 0 : times.size(), 1.0),
      offset_(shape.offset) {
  CHECK_GE(shape.ratio, 0.0);
  CHECK_GE(shape.colour_ratio, 0.0);
  CHECK(shape.colour_pole >= 0.0 && shape.colour_pole < 1.0);
  CHECK(shape.offset || shape.ratio == 0.0);
  CHECK(weights.size() == 0 ||
        weights.size() == static_cast<Eigen::Index>(times.size()));
  if (times.empty()) return;
  if (shape.coloured()) {
    SetUpColour(times, shape, weights);
  } else if (shape.offset) {
    SetUpWalk(times, shape.ratio, weights);
  } else {
    SetUpWhite(weights);
  }
}

void InnovationsFilter::SetUpWhite(const Eigen::VectorXd& weights) {
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    const double white = WhiteVariance(weights, k);
    inverse_roots_[k] = 1.0 / std::sqrt(white);
    if (weights.size() > 0) log_determinant_ += std::log(white);
  }
}

void InnovationsFilter::SetUpWalk(const std::vector<int>& times, double ratio,
                                  const Eigen::VectorXd& weights) {
  // Variance of ŵ once the first sample has set it.
  double filtered = WhiteVariance(weights, 0);
  LogProduct product;
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double white = WhiteVariance(weights, k);
    const double predicted = filtered + ratio * (times[k] - times[k - 1]);
    const double variance = predicted + white;
    smoothing_[k - 1] = filtered / predicted;
    filtered = predicted * white / variance;
    gains_[k] = predicted / variance;
    inverse_roots_[k] = 1.0 / std::sqrt(variance);
    product.Multiply(variance);
  }
  log_determinant_ = product.log();
}

void InnovationsFilter::SetUpColour(const std::vector<int>& times,
                                    const NoiseShape& shape,
                                    const Eigen::VectorXd& weights) {
  const std::size_t n = times.size();
  colour_gains_.resize(n);
  decays_.assign(n, shape.colour_pole);
  white_.resize(n);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const int steps = times[k + 1] - times[k];
    if (steps > 1) decays_[k] = std::pow(shape.colour_pole, steps);
  }
  const double stationary =
      shape.colour_ratio / (1.0 - shape.colour_pole * shape.colour_pole);
  // Covariance of (w, a) before sample k. A diffuse w takes the first sample
  // whole: w = n_0 − a_0 − e_0.
  double ww = 0.0;
  double wa = 0.0;
  double aa = stationary;
  LogProduct product;
  for (std::size_t k = 0; k < n; ++k) {
    const double white = white_[k] = WhiteVariance(weights, k);
    if (k == 0 && shape.offset) {
      gains_[0] = 1.0;
      ww = stationary + white;
      wa = -stationary;
    } else {
      const double of_w = ww + wa;
      const double of_a = wa + aa;
      const double total = of_w + of_a + white;
      gains_[k] = of_w / total;
      colour_gains_[k] = decays_[k] * (of_a / total);
      inverse_roots_[k] = 1.0 / std::sqrt(total);
      ww = std::max(ww - of_w * gains_[k], 0.0);
      wa -= of_w * (of_a / total);
      aa = std::max(aa - of_a * (of_a / total), 0.0);
      product.Multiply(total);
    }
    if (k + 1 == n) break;
    ww += shape.ratio * (times[k + 1] - times[k]);
    wa *= decays_[k];
    aa = stationary + decays_[k] * decays_[k] * (aa - stationary);
  }
  log_determinant_ = product.log();
}

void InnovationsFilter::Apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), static_cast<Eigen::Index>(gains_.size()));
  if (gains_.empty()) return;
  const bool coloured = !decays_.empty();
  Eigen::Index c = 0;
  for (; c + kTogether <= columns.cols(); c += kTogether) {
    auto block = columns.middleCols<kTogether>(c);
    coloured ? ApplyColour<kTogether>(block) : ApplyTo<kTogether>(block);
  }
  for (; c < columns.cols(); ++c) {
    auto column = columns.middleCols<1>(c);
    coloured ? ApplyColour<1>(column) : ApplyTo<1>(column);
  }
}

template <int kColumns, typename Columns>
void InnovationsFilter::ApplyTo(Columns&& columns) const {
  // With an offset the first sample sets the level.
  double level[kColumns];
  for (int c = 0; c < kColumns; ++c) level[c] = offset_ ? columns(0, c) : 0.0;
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    for (int c = 0; c < kColumns; ++c) {
      const double innovation = columns(k, c) - level[c];
      level[c] += gains_[k] * innovation;
      columns(k, c) = innovation * inverse_roots_[k];
    }
  }
}

template <int kColumns, typename Columns>
void InnovationsFilter::ApplyColour(Columns&& columns) const {
  double level[kColumns] = {};
  double colour[kColumns] = {};
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    for (int c = 0; c < kColumns; ++c) {
      const double innovation = columns(k, c) - (level[c] + colour[c]);
      level[c] += gains_[k] * innovation;
      colour[c] = decays_[k] * colour[c] + colour_gains_[k] * innovation;
      columns(k, c) = innovation * inverse_roots_[k];
    }
  }
}

// Disturbance smoother: e_k = (ν_k/F_k − Kᵀ_k r_k)/ω_k, backwards with
// r_{k−1} = (1, 1)ᵀ ω_k e_k + Tᵀ_k r_k (Durbin and Koopman, section 4.5).
Eigen::VectorXd InnovationsFilter::ColourlessPart(
    const Eigen::VectorXd& disturbance) const {
  Eigen::VectorXd white = disturbance;
  ApplyColour<1>(white);
  double of_w = 0.0;  // r_k
  double of_a = 0.0;
  for (Eigen::Index k = white.size() - 1; k >= 0; --k) {
    const double smoothed = white(k) * inverse_roots_[k] - gains_[k] * of_w -
                            colour_gains_[k] * of_a;
    of_w += smoothed;
    of_a = decays_[k] * of_a + smoothed;
    white(k) = white_[k] * smoothed;
  }
  return white;
}

Eigen::VectorXd InnovationsFilter::WhitePart(
    const Eigen::VectorXd& disturbance) const {
  CHECK_EQ(disturbance.size(), static_cast<Eigen::Index>(gains_.size()));
  if (disturbance.size() == 0) return disturbance;
  if (!decays_.empty()) return ColourlessPart(disturbance);
  if (!offset_) return disturbance;
  Eigen::VectorXd level(disturbance.size());
  level(0) = disturbance(0);
  for (Eigen::Index k = 1; k < level.size(); ++k) {
    level(k) = level(k - 1) + gains_[k] * (disturbance(k) - level(k - 1));
  }
  for (Eigen::Index k = level.size() - 2; k >= 0; --k) {
    level(k) += smoothing_[k] * (level(k + 1) - level(k));
  }
  return disturbance - level;
}

}  // namespace mle
