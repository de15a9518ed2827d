#include "mle/nonlinear/innovations_filter.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Entries of the filter's state: w, a and b.
constexpr Index kStates = 3;
// Numbers of a block of rows: 32 KiB.
constexpr Index kBlock = 4096;
constexpr Index kFewestRows = 16;
// Lanes of the widest vectors; columns of products made at once.
constexpr Index kMostLanes = 8;

Index RowsOfBlock(Index width) {
  return std::max(kBlock / std::max<Index>(width, 1), kFewestRows);
}

Index InWholeVectors(Index width) {
  return (width + kMostLanes - 1) / kMostLanes * kMostLanes;
}

// Rows of which the same columns are made.
struct Section {
  Index end = 0;  // the row after its last
  std::vector<Index> live;
  std::vector<Index> ended;
  Index states = 0;  // columns that stand for all that have ended

  Index live_columns() const { return static_cast<Index>(live.size()); }
  Index columns() const { return live_columns() + states; }
};

// From row `first` to where there are fewer vectors of columns, or to the last
// of `samples`. `states`: numbers of the filter's state.
Section SectionFrom(Index first, Index samples, Index width, Index states,
                    const std::vector<Index>& ends) {
  Section section;
  section.end = samples;
  for (Index c = 0; c < width; ++c) {
    (ends.empty() || ends[c] > first ? section.live : section.ended)
        .push_back(c);
  }
  if (!section.ended.empty()) section.states = states;
  std::vector<Index> later;
  for (const Index c : section.live) {
    if (!ends.empty() && ends[c] < samples) later.push_back(ends[c]);
  }
  std::sort(later.begin(), later.end());
  for (std::size_t i = 0; i < later.size(); ++i) {
    const Index left =
        section.live_columns() - static_cast<Index>(i) - 1 + states;
    if (InWholeVectors(left) < InWholeVectors(section.columns())) {
      section.end = later[i];
      break;
    }
  }
  return section;
}

// Adds those of a section's live columns and then its states' to the products
// of all columns: what has ended are combinations of the latter.
void AddProductsOf(const Section& section, const MatrixXd& of_section,
                   const MatrixXd& combinations, MatrixXd& products) {
  const Index live = section.live_columns();
  products(section.live, section.live) += of_section.topLeftCorner(live, live);
  if (section.states == 0) return;
  const MatrixXd cross =
      combinations * of_section.bottomLeftCorner(section.states, live);
  products(section.ended, section.live) += cross;
  products(section.live, section.ended) += cross.transpose();
  products(section.ended, section.ended) +=
      combinations *
      of_section.bottomRightCorner(section.states, section.states) *
      combinations.transpose();
}

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

double WhiteVariance(const VectorXd& weights, std::size_t k) {
  return weights.size() > 0 ? 1.0 / weights(static_cast<Index>(k)) : 1.0;
}

}  // namespace

InnovationsFilter::InnovationsFilter(const std::vector<int>& times,
                                     const NoiseShape& shape,
                                     const VectorXd& weights)
    : gains_(times.size()),
      inverse_roots_(times.size()),
      smoothing_(shape.has_ar() ? 0 : times.size(), 1.0),
      offset_(shape.offset) {
  CHECK_GE(shape.ratio, 0.0);
  CHECK_GE(shape.ar_ratio, 0.0);
  CHECK(shape.offset || shape.ratio == 0.0);
  CHECK(weights.size() == 0 ||
        weights.size() == static_cast<Index>(times.size()));
  if (times.empty()) return;
  // The first sample sets the level.
  if (shape.offset) gains_[0] = 1.0;
  if (shape.has_ar() && shape.ar_damping > 0.0) {
    SetUpAr<2>(times, shape, weights);
  } else if (shape.has_ar()) {
    SetUpAr<1>(times, shape, weights);
  } else if (shape.offset) {
    SetUpWalk(times, shape.ratio, weights);
  } else {
    SetUpWhite(weights);
  }
}

void InnovationsFilter::SetUpWhite(const VectorXd& weights) {
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    const double white = WhiteVariance(weights, k);
    inverse_roots_[k] = 1.0 / std::sqrt(white);
    if (weights.size() > 0) log_determinant_ += std::log(white);
  }
}

void InnovationsFilter::SetUpWalk(const std::vector<int>& times, double ratio,
                                  const VectorXd& weights) {
  // Variance of ŵ once the first sample has set it.
  double filtered = WhiteVariance(weights, 0);
  double variance = 0.0;
  bool steady = false;  // the step before changed nothing: so will this
  LogProduct product;
  for (std::size_t k = 1; k < times.size(); ++k) {
    const int steps = times[k] - times[k - 1];
    if (steady && steps == 1) {
      smoothing_[k - 1] = smoothing_[k - 2];
      gains_[k] = gains_[k - 1];
      inverse_roots_[k] = inverse_roots_[k - 1];
      product.Multiply(variance);
      continue;
    }
    const double white = WhiteVariance(weights, k);
    const double former = filtered;
    const double predicted = filtered + ratio * steps;
    variance = predicted + white;
    smoothing_[k - 1] = filtered / predicted;
    filtered = predicted * white / variance;
    steady = weights.size() == 0 && steps == 1 && filtered == former;
    gains_[k] = predicted / variance;
    inverse_roots_[k] = 1.0 / std::sqrt(variance);
    product.Multiply(variance);
  }
  log_determinant_ = product.log();
}

namespace {

// Covariance of the errors of the state (w, a, b); for first order b and its
// entries are 0.
struct StateCovariance {
  double ww = 0.0, wa = 0.0, wb = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;

  bool operator==(const StateCovariance& other) const = default;
};

// P becomes T P Tᵀ + Q. Of (a, b) this is Π + F (P − Π) Fᵀ with the stationary
// Π, whatever the number of samples.
template <int kOrder>
void Predict(const ArComponent::Power& power, double spread, double walk,
             const ArComponent::Covariance& stationary, StateCovariance& P) {
  const double m = power.own;
  P.ww += walk;
  if constexpr (kOrder == 1) {
    P.wa *= m;
    P.aa = stationary.aa + m * m * (P.aa - stationary.aa);
    return;
  }
  const double c = power.cross;
  const double d = spread * c;
  const double wa = m * P.wa + c * P.wb;
  P.wb = d * P.wa + m * P.wb;
  P.wa = wa;
  const double aa = P.aa - stationary.aa;
  const double ab = P.ab - stationary.ab;
  const double bb = P.bb - stationary.bb;
  P.aa = stationary.aa + m * m * aa + 2.0 * m * c * ab + c * c * bb;
  P.ab = stationary.ab + m * d * aa + (m * m + c * d) * ab + m * c * bb;
  P.bb = stationary.bb + d * d * aa + 2.0 * m * d * ab + m * m * bb;
}

}  // namespace

// A diffuse w takes the first sample whole: w = n_0 − a_0 − e_0.
template <int kOrder>
void InnovationsFilter::SetUpAr(const std::vector<int>& times,
                                const NoiseShape& shape,
                                const VectorXd& weights) {
  const std::size_t n = times.size();
  const ArComponent ar = shape.ar();
  spread_ = ar.spread();
  ar_.resize(n);
  white_.resize(n);
  ArComponent::Covariance stationary = ar.Stationary();
  stationary.aa *= shape.ar_ratio;
  stationary.ab *= shape.ar_ratio;
  stationary.bb *= shape.ar_ratio;
  const ArComponent::Power one = ar.After(1);
  StateCovariance P = {
      .aa = stationary.aa, .ab = stationary.ab, .bb = stationary.bb};
  LogProduct product;
  double total = 0.0;
  bool steady = false;  // the step before changed nothing: so will this
  for (std::size_t k = 0; k < n; ++k) {
    if (steady && k + 1 < n && times[k + 1] - times[k] == 1) {
      white_[k] = white_[k - 1];
      gains_[k] = gains_[k - 1];
      inverse_roots_[k] = inverse_roots_[k - 1];
      ar_[k] = ar_[k - 1];
      product.Multiply(total);
      continue;
    }
    const StateCovariance former = P;
    const double white = white_[k] = WhiteVariance(weights, k);
    double gain_a = 0.0;
    double gain_b = 0.0;
    if (k == 0 && shape.offset) {
      P.ww = stationary.aa + white;
      P.wa = -stationary.aa;
      P.wb = -stationary.ab;
    } else {
      const double of_w = P.ww + P.wa;
      const double of_a = P.wa + P.aa;
      const double of_b = P.wb + P.ab;
      total = of_w + of_a + white;
      gains_[k] = of_w / total;
      gain_a = of_a / total;
      gain_b = of_b / total;
      inverse_roots_[k] = 1.0 / std::sqrt(total);
      product.Multiply(total);
      P.ww = std::max(P.ww - of_w * gains_[k], 0.0);
      P.wa -= of_w * gain_a;
      P.wb -= of_w * gain_b;
      P.aa = std::max(P.aa - of_a * gain_a, 0.0);
      P.ab -= of_a * gain_b;
      P.bb = std::max(P.bb - of_b * gain_b, 0.0);
    }
    if (k + 1 == n) break;
    const int steps = times[k + 1] - times[k];
    const ArComponent::Power power = steps == 1 ? one : ar.After(steps);
    ar_[k] = {.power = power,
              .gain_a = power.own * gain_a + power.cross * gain_b,
              .gain_b = spread_ * power.cross * gain_a + power.own * gain_b};
    Predict<kOrder>(power, spread_, shape.ratio * steps, stationary, P);
    steady = weights.size() == 0 && k > 0 && steps == 1 && P == former;
  }
  log_determinant_ = product.log();
}

void InnovationsFilter::FilterRows(Index first, Index count, double* rows,
                                   Index width, MatrixXd& state) const {
  const FilterSteps steps = {
      .gains = gains_.data() + first,
      .inverse_roots = inverse_roots_.data() + first,
      .ar = ar_.empty() ? nullptr : &ar_[first].power.own,
      .spread = spread_};
  VectorKernels().filter_rows(steps, count, rows, width, width, state.data());
}

void InnovationsFilter::Apply(Eigen::Ref<MatrixXd> columns) const {
  CHECK_EQ(columns.rows(), static_cast<Index>(gains_.size()));
  const Index width = columns.cols();
  const Index most = RowsOfBlock(width);
  MatrixXd state = MatrixXd::Zero(width, kStates);
  RowMajorMatrix block;
  for (Index first = 0; first < columns.rows(); first += most) {
    const Index rows = std::min(most, columns.rows() - first);
    block = columns.middleRows(first, rows);
    FilterRows(first, rows, block.data(), width, state);
    columns.middleRows(first, rows) = block;
  }
}

MatrixXd InnovationsFilter::WhitenedProducts(
    const RowMajorMatrix& columns, const std::vector<Index>& ends) const {
  CHECK_EQ(columns.rows(), static_cast<Index>(gains_.size()));
  const auto copy = [&columns](Index first, Index count,
                               const std::vector<Index>& live, double* rows,
                               Index stride) {
    for (Index k = 0; k < count; ++k, rows += stride) {
      const double* row = columns.data() + (first + k) * columns.cols();
      // Runs of neighbours are copied together.
      for (std::size_t c = 0; c < live.size();) {
        std::size_t end = c + 1;
        while (end < live.size() && live[end] == live[end - 1] + 1) ++end;
        std::copy_n(row + live[c], end - c, rows + c);
        c = end;
      }
    }
  };
  return WhitenedProducts(columns.cols(), copy, ends);
}

MatrixXd InnovationsFilter::WhitenedProducts(
    Index width, const RowSource& source,
    const std::vector<Index>& ends) const {
  CHECK(ends.empty() || std::ssize(ends) == width);
  const auto samples = static_cast<Index>(gains_.size());
  // For white noise without an offset the state stays zero.
  const Index num_states = !ar_.empty() ? kStates : (offset_ ? 1 : 0);
  MatrixXd products = MatrixXd::Zero(width, width);
  MatrixXd states = MatrixXd::Zero(width, kStates);
  RowMajorMatrix block;
  for (Index first = 0; first < samples;) {
    const Section section =
        SectionFrom(first, samples, width, num_states, ends);
    const Index live = section.live_columns();
    // Whole vectors are filtered faster than single columns: the rest are
    // zeros.
    const Index padded = InWholeVectors(section.columns());
    MatrixXd state = MatrixXd::Zero(padded, kStates);
    state.topRows(live) = states(section.live, Eigen::all);
    state.middleRows(live, section.states)
        .leftCols(section.states)
        .setIdentity();
    MatrixXd of_section = MatrixXd::Zero(padded, padded);
    const Index most = RowsOfBlock(padded);
    for (; first < section.end; first += block.rows()) {
      const Index count = std::min(most, section.end - first);
      block.resize(count, padded);
      block.rightCols(padded - live).setZero();
      source(first, count, section.live, block.data(), padded);
      FilterRows(first, count, block.data(), padded, state);
      // The lower triangle, and what of the upper its panels hold.
      for (Index c = 0; c < padded; c += kMostLanes) {
        VectorKernels().add_products({.x = block.data() + c,
                                      .x_stride = padded,
                                      .rows = padded - c,
                                      .w = block.data() + c,
                                      .w_stride = padded,
                                      .columns = kMostLanes,
                                      .count = count},
                                     &of_section(c, c), padded);
      }
    }
    const MatrixXd combinations =
        states(section.ended, Eigen::all).leftCols(section.states);
    AddProductsOf(section,
                  of_section.topLeftCorner(section.columns(), section.columns())
                      .selfadjointView<Eigen::Lower>(),
                  combinations, products);
    states(section.live, Eigen::all) = state.topRows(live);
    states(section.ended, Eigen::all) =
        combinations * state.middleRows(live, section.states);
  }
  return products.selfadjointView<Eigen::Lower>();
}

// Disturbance smoother: e_k = (ν_k/F_k − Kᵀ_k r_k)/ω_k, backwards with
// r_{k−1} = (1, 1, 0)ᵀ ω_k e_k + Tᵀ_k r_k (Durbin and Koopman, section 4.5).
VectorXd InnovationsFilter::PartWithoutAr(const VectorXd& disturbance) const {
  VectorXd white = disturbance;
  Apply(white);
  double of_w = 0.0;  // r_k
  double of_a = 0.0;
  double of_b = 0.0;
  for (Index k = white.size() - 1; k >= 0; --k) {
    const ArStep& step = ar_[k];
    const double smoothed = white(k) * inverse_roots_[k] - gains_[k] * of_w -
                            step.gain_a * of_a - step.gain_b * of_b;
    const double next =
        step.power.own * of_a + spread_ * step.power.cross * of_b;
    of_b = step.power.cross * of_a + step.power.own * of_b;
    of_a = next + smoothed;
    of_w += smoothed;
    white(k) = white_[k] * smoothed;
  }
  return white;
}

VectorXd InnovationsFilter::WhitePart(const VectorXd& disturbance) const {
  CHECK_EQ(disturbance.size(), static_cast<Index>(gains_.size()));
  if (disturbance.size() == 0) return disturbance;
  if (!ar_.empty()) return PartWithoutAr(disturbance);
  if (!offset_) return disturbance;
  VectorXd level(disturbance.size());
  level(0) = disturbance(0);
  for (Index k = 1; k < level.size(); ++k) {
    level(k) = level(k - 1) + gains_[k] * (disturbance(k) - level(k - 1));
  }
  for (Index k = level.size() - 2; k >= 0; --k) {
    level(k) += smoothing_[k] * (level(k + 1) - level(k));
  }
  return disturbance - level;
}

}  // namespace mle
