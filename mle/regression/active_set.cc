#include "mle/regression/active_set.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/regression/active_columns.h"
#include "mle/regression/kernels/kernels.h"
#include "mle/regression/unpenalised.h"

namespace mle {
namespace {

// A coefficient that shrinks more slowly than this on an exchange does not
// shrink.
constexpr double kShrinks = 1e-9;
// Violations of the optimality conditions, relative to λ: refined above the
// first, with c in twice the precision above the second, lost above the third.
constexpr double kRefine = 1e-13;
constexpr double kRefineSharply = 1e-9;
constexpr double kLost = 1e-6;
constexpr double kEntersAtOnce = 1e-4;
// Columns of the factor to begin with. Not a power of two: columns a multiple
// of 4 KiB apart share the same few places in the cache.
constexpr int kRoom = 1000;

}  // namespace

ActiveSet::ActiveSet(const LassoObjective& objective)
    : objective_(objective),
      gram_(*objective.gram),
      states_(objective.size(), State::kInactive),
      cholesky_(std::min(objective.size(), kRoom)),
      target_(objective.size()),
      half_(objective.size()),
      beta_(objective.size()),
      slope_(objective.size()),
      c_(objective.correlation),
      b_(Eigen::VectorXd::Zero(objective.size())),
      inverse_weights_(Eigen::VectorXd::Zero(objective.size())),
      root_diagonal_(gram_.diagonal().cwiseMax(0.0).cwiseSqrt()),
      work_(objective.size()) {
  for (int j = 0; j < objective_.size(); ++j) {
    const double w = objective_.weights(j);
    if (!std::isfinite(w) || !(gram_(j, j) > 0.0)) {
      states_[j] = State::kExcluded;
    } else if (w > 0.0) {
      inverse_weights_(j) = 1.0 / w;
    }
  }
  weighted_root_ = root_diagonal_.cwiseProduct(inverse_weights_).maxCoeff();
  greatest_inverse_ = inverse_weights_.maxCoeff();
  scale_ = c_.cwiseAbs().cwiseProduct(inverse_weights_).maxCoeff();
  AppendUnpenalised();
}

void ActiveSet::AppendUnpenalised() {
  columns_ = IndependentUnpenalised(objective_, cholesky_);
  columns_.reserve(objective_.size());
  for (int j = 0; j < objective_.size(); ++j) {
    if (objective_.weights(j) == 0.0) states_[j] = State::kExcluded;
  }
  for (const int j : columns_) states_[j] = State::kActive;
  target_.head(size()).setZero();
  half_.head(size()).setZero();
  num_unpenalised_ = size();
  slope_.head(size()).setZero();
  if (size() == 0) return;
  beta_.head(size()) = objective_.correlation(columns_);
  cholesky_.SolveInPlace(beta_.head(size()));
  Products();
}

int ActiveSet::PositionOf(int variable) const {
  return static_cast<int>(
      std::find(columns_.begin(), columns_.end(), variable) - columns_.begin());
}

int ActiveSet::Count(State state) const {
  return static_cast<int>(std::count(states_.begin(), states_.end(), state));
}

void ActiveSet::Products() {
  MultiplyActive(gram_, columns_, beta_.data(), slope_.data(), c_, b_);
  c_ = objective_.correlation - c_;
}

void ActiveSet::SharpC(double step, Eigen::VectorXd& c) const {
  const Eigen::VectorXd beta = betas() + step * slopes();
  Eigen::VectorXd low;
  SharpC(beta.data(), c, low);
  c += low;
}

void ActiveSet::SharpC(const double* beta, Eigen::VectorXd& high,
                       Eigen::VectorXd& low) const {
  high = objective_.correlation;
  low.setZero(high.size());
  VectorKernels().subtract_columns_twice(ActiveColumns(gram_, columns_), beta,
                                         high.size(), high.data(), low.data());
}

double ActiveSet::ActiveViolation(double lambda) const {
  double worst = 0.0;
  for (int i = 0; i < size(); ++i) {
    const int j = columns_[i];
    const double inverse_weight =
        target_(i) == 0.0 ? greatest_inverse_ : inverse_weights_(j);
    worst =
        std::max(worst, inverse_weight * std::abs(c_(j) - lambda * target_(i)));
  }
  return worst;
}

double ActiveSet::InactiveViolation(double lambda) const {
  return c_.cwiseAbs().cwiseProduct(inverse_weights_).maxCoeff() - lambda;
}

// c_j = C_j − Σ_i G_ji β_i: about ε (|C_j| + Σ_i |β_i| √(G_ii G_jj)).
double ActiveSet::Rounding() const {
  double sum = 0.0;
  for (int i = 0; i < size(); ++i) {
    sum += std::abs(beta_(i)) * root_diagonal_(columns_[i]);
  }
  return kEpsilon * (scale_ + weighted_root_ * sum);
}

// q solves its equations to about its own rounding.
double ActiveSet::SlopeRounding(int variable) const {
  double sum = 0.0;
  for (int i = 0; i < size(); ++i) {
    sum += std::abs(slope_(i)) * root_diagonal_(columns_[i]);
  }
  return kEpsilon * sum * root_diagonal_(variable) * inverse_weights_(variable);
}

void ActiveSet::Refine(double lambda) {
  const int k = size();
  work_.head(k) = c_(columns_) - lambda * target_.head(k);
  cholesky_.SolveInPlace(work_.head(k));
  beta_.head(k) += work_.head(k);
  Products();
}

// c_A right to its rounding e leaves c_j of a column x_j = X_A d + … uncertain
// by ‖d‖₁ e. From c_A in twice the working precision β comes out right to its
// last digit, and with it every c_j to about e.
void ActiveSet::RefineSharply(double lambda) {
  const int k = size();
  Eigen::VectorXd high;
  Eigen::VectorXd low;
  SharpC(beta_.data(), high, low);
  work_.head(k) = (high(columns_) - lambda * target_.head(k)) + low(columns_);
  cholesky_.SolveInPlace(work_.head(k));
  beta_.head(k) += work_.head(k);
  Products();
}

// By ‖d‖₁ e, with d from the column of G_AA⁻¹ that belongs to it.
bool ActiveSet::IsBlurred(int leaving, double lambda) const {
  const int position = PositionOf(leaving);
  Eigen::VectorXd column = Eigen::VectorXd::Unit(size(), position);
  cholesky_.SolveInPlace(column);
  return column.lpNorm<1>() * Rounding() >
         kRefineSharply * lambda * column(position);
}

bool ActiveSet::Solve(double lambda) {
  const double rounding = Rounding();
  const double lost = kLost * lambda + 10.0 * rounding;
  if (SolveOnce(lambda, rounding) <= lost) return true;
  if (!Refactor()) return false;
  // A column beyond its bound by no more than this enters at once, and the
  // conditions hold again from there.
  const double violation = SolveOnce(lambda, Rounding());
  return ActiveViolation(lambda) <= lost &&
         violation <= kEntersAtOnce * lambda + 10.0 * rounding;
}

// Returns how far the optimality conditions are violated.
double ActiveSet::SolveOnce(double lambda, double rounding) {
  const double enough = std::max(kRefine * lambda, rounding);
  slope_.head(size()) = half_.head(size());
  cholesky_.FinishInPlace(slope_.head(size()));
  Products();
  double violation = ActiveViolation(lambda);
  if (violation > enough) ++refined_;
  for (int pass = 0; pass < 3 && violation > enough; ++pass) {
    Refine(lambda);
    const double refined = ActiveViolation(lambda);
    const bool stagnates = refined > 0.5 * violation;
    violation = refined;
    if (stagnates) break;
  }
  violation = std::max(violation, InactiveViolation(lambda));
  if (violation > kRefineSharply * lambda + kSeveralRoundings * rounding) {
    RefineSharply(lambda);
    violation = std::max(ActiveViolation(lambda), InactiveViolation(lambda));
  }
  return violation;
}

bool ActiveSet::Refactor() {
  ++refactored_;
  cholesky_.Clear();
  for (int i = 0; i < size(); ++i) {
    const int j = columns_[i];
    for (int l = 0; l < i; ++l) work_(l) = gram_(columns_[l], j);
    if (cholesky_.Append(work_.head(i), gram_(j, j), 0.0) <= 0.0) return false;
  }
  half_.head(size()) = target_.head(size());
  cholesky_.HalfSolveInPlace(half_.head(size()));
  return true;
}

double ActiveSet::Append(int variable, double sign, double tolerance) {
  const int k = size();
  work_.head(k) = gram_.col(variable)(columns_);
  const double square = gram_(variable, variable);
  const double pivot = cholesky_.Append(work_.head(k), square, tolerance);
  if (pivot <= tolerance * square) return pivot;
  target_(k) = sign * objective_.weights(variable);
  half_(k) = cholesky_.LastOfHalf(half_.head(k), target_(k));
  beta_(k) = 0.0;
  slope_(k) = 0.0;
  columns_.push_back(variable);
  states_[variable] = State::kActive;
  return pivot;
}

void ActiveSet::Remove(int variable) {
  const int position = PositionOf(variable);
  CHECK_LT(position, size());
  cholesky_.Remove(position, half_.head(size()));
  columns_.erase(columns_.begin() + position);
  for (Eigen::VectorXd* values : {&target_, &beta_, &slope_}) {
    std::copy(values->data() + position + 1, values->data() + size() + 1,
              values->data() + position);
  }
  states_[variable] = State::kInactive;
  std::replace(states_.begin(), states_.end(), State::kWaiting,
               State::kInactive);
}

ActiveSet::Exchanged ActiveSet::Exchange(int entering, double sign) {
  Eigen::VectorXd d = gram_.col(entering)(columns_);
  cholesky_.SolveInPlace(d);
  Exchanged result;
  double step = kInfinity;
  for (int i = 0; i < size(); ++i) {
    const double target_sign = target_(i) > 0.0 ? 1.0 : -1.0;
    const double shrink = sign * d(i) * target_sign;
    if (target_(i) == 0.0 || !(shrink > kShrinks)) continue;
    const double candidate = std::abs(beta_(i)) / shrink;
    if (candidate < step) {
      step = candidate;
      result.left = columns_[i];
      result.sign = target_sign;
    }
  }
  if (result.left < 0) return result;
  beta_.head(size()) -= step * sign * d;
  Remove(result.left);
  result.entered = Append(entering, sign, kDependentPivot) >
                   kDependentPivot * gram_(entering, entering);
  if (result.entered) beta_(size() - 1) = step * sign;
  return result;
}

}  // namespace mle
