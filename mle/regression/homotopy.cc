#include "mle/regression/homotopy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "absl/strings/str_format.h"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "mle/regression/active_columns.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/kernels/kernels.h"
#include "mle/regression/updatable_cholesky.h"

namespace mle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Pivots below this part of a column's square are rounding.
constexpr double kDependent = 4e-15;
// Below this part they are looked at twice: a twin's c_j follows the bound at a
// relative rate below kFollows.
constexpr double kNearlyDependent = 1e-9;
constexpr double kFollows = 1e-7;
// c_j = C_j − Σ_i G_ji β_i: its rounding is about ε (|C_j| + Σ_i |β_i| √(G_ii
// G_jj)).
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// A relative gap above this may be the rounding of c, which is then sharpened.
constexpr double kSharpen = 5e-11;
// Violations of the optimality conditions, relative to λ: refined above the
// first, with c in twice the precision above the second, lost above the third.
constexpr double kRefine = 1e-13;
constexpr double kRefineSharply = 1e-9;
constexpr double kLost = 1e-6;
// The path counts as ended at this part of λ_max, or at several times the
// rounding of c.
constexpr double kFloor = 1e-13;
constexpr double kSeveral = 8.0;

enum class State : std::uint8_t { kInactive, kActive, kWaiting, kExcluded };

struct Event {
  enum class Kind { kEnd, kEnter, kLeave } kind = Kind::kEnd;
  double step = 0.0;
  int variable = -1;
  double sign = 0.0;  // of an entering variable's c_j
};

class Homotopy {
 public:
  Homotopy(const LassoObjective& objective, const HomotopyOptions& options);

  HomotopySummary Run();

 private:
  void Start();
  void EnterUnpenalised();
  // Recomputes c and makes q and b at the present knot.
  bool ComputeDirection();
  void Products();
  void CompensatedProducts();
  double ActiveViolation() const;
  double InactiveViolation() const;
  double Rounding() const;
  double Violation() const;
  void Refine();
  void RefineSharply();
  bool IsBlurred(int leaving) const;
  bool Refactor();
  Event NextEvent() const;
  void Consider(Event::Kind kind, int variable, double slack, double rate,
                double sign, Event& best) const;
  void Advance(const Event& event);
  void Certify(double step);
  double RelativeGapAfter(double step) const;
  double LeastSquaresRelativeGap(double step) const;
  void Enter(const Event& event);
  void Leave(int variable);
  bool Exchange(int entering, double sign);
  double Append(int variable, double sign, double tolerance);

  Eigen::VectorXd Gather(const Eigen::VectorXd& values) const;

  const LassoObjective& objective_;
  const HomotopyOptions& options_;
  const Eigen::MatrixXd& gram_;
  const int n_;

  double lambda_ = 0.0;
  double floor_ = 0.0;
  double scale_ = 0.0;  // max_j |C_j| / w_j
  std::vector<State> state_;
  std::vector<int> active_;
  UpdatableCholesky cholesky_;
  Eigen::VectorXd target_;           // (s∘w)_A, first |A| entries
  Eigen::VectorXd beta_;             // β_A, first |A| entries
  Eigen::VectorXd slope_;            // q, first |A| entries
  Eigen::VectorXd c_;                // n
  Eigen::VectorXd b_;                // n, G_·A q
  Eigen::VectorXd inverse_weights_;  // n, 0 where not penalised or excluded
  Eigen::VectorXd root_diagonal_;    // n, √G_jj
  double weighted_root_ = 0.0;       // max_j √G_jj / w_j
  double greatest_inverse_ = 0.0;    // max_j 1 / w_j
  Eigen::VectorXd work_;
  // The variable that moved last and the bound it moved at: barred one step.
  int last_moved_ = -1;
  double last_sign_ = 0.0;
  int zero_steps_ = 0;
  bool compensated_ = false;            // c_ is in twice the working precision
  Eigen::Index next_certificate_ = -1;  // into certify_at, from its end
  HomotopySummary summary_;
};

Homotopy::Homotopy(const LassoObjective& objective,
                   const HomotopyOptions& options)
    : objective_(objective),
      options_(options),
      gram_(*objective.gram),
      n_(objective.size()),
      state_(n_, State::kInactive),
      cholesky_(std::min(n_, 256)),
      target_(n_),
      beta_(n_),
      slope_(n_),
      c_(objective.correlation),
      b_(Eigen::VectorXd::Zero(n_)),
      inverse_weights_(Eigen::VectorXd::Zero(n_)),
      root_diagonal_(gram_.diagonal().cwiseMax(0.0).cwiseSqrt()),
      work_(n_) {
  for (int j = 0; j < n_; ++j) {
    const double w = objective_.weights(j);
    if (!std::isfinite(w) || !(gram_(j, j) > 0.0)) {
      state_[j] = State::kExcluded;
    } else if (w > 0.0) {
      inverse_weights_(j) = 1.0 / w;
    }
  }
  weighted_root_ = root_diagonal_.cwiseProduct(inverse_weights_).maxCoeff();
  greatest_inverse_ = inverse_weights_.maxCoeff();
  active_.reserve(n_);
  summary_.path = LassoPath(n_);
  summary_.relative_gap.setConstant(options.certify_at.size(), kInfinity);
  next_certificate_ = options.certify_at.size() - 1;
}

HomotopySummary Homotopy::Run() {
  Start();
  while (summary_.termination == HomotopyTermination::kNotRun) {
    if (!ComputeDirection()) {
      summary_.termination = HomotopyTermination::kIllConditioned;
      break;
    }
    Event event = NextEvent();
    if (event.kind == Event::Kind::kLeave && IsBlurred(event.variable)) {
      RefineSharply();
      event = NextEvent();
    }
    Advance(event);
    switch (event.kind) {
      case Event::Kind::kEnd:
        summary_.termination = HomotopyTermination::kReachedLambdaMin;
        break;
      case Event::Kind::kEnter:
        if (static_cast<int>(active_.size()) >= options_.max_active) {
          summary_.termination = HomotopyTermination::kReachedMaxActive;
        } else {
          Enter(event);
        }
        break;
      case Event::Kind::kLeave:
        Leave(event.variable);
        break;
    }
    if (zero_steps_ > 4 * n_ + 100) {
      summary_.termination = HomotopyTermination::kStalled;
    }
    summary_.max_active =
        std::max(summary_.max_active, static_cast<int>(active_.size()));
  }
  summary_.reciprocal_condition_bound = cholesky_.ReciprocalConditionBound();
  return std::move(summary_);
}

void Homotopy::Start() {
  EnterUnpenalised();
  const auto k = static_cast<Eigen::Index>(active_.size());
  const double lambda_max =
      c_.cwiseAbs().cwiseProduct(inverse_weights_).maxCoeff();
  scale_ = objective_.correlation.cwiseAbs()
               .cwiseProduct(inverse_weights_)
               .maxCoeff();
  floor_ = std::max(options_.lambda_min, kFloor * scale_);
  lambda_ = lambda_max;
  if (lambda_max <= std::max(floor_, kSeveral * Rounding())) {
    summary_.termination = HomotopyTermination::kReachedLambdaMin;
    lambda_ = options_.lambda_min;
  }
  slope_.head(k).setZero();
  // Above λ_max only the unpenalised coefficients differ from zero.
  if (k > 0) {
    summary_.path.Append(std::numeric_limits<double>::max(), lambda_, active_,
                         beta_.head(k), slope_.head(k));
  }
  Eigen::VectorXd start = Eigen::VectorXd::Zero(n_);
  start(active_) = beta_.head(k);
  while (next_certificate_ >= 0 &&
         options_.certify_at(next_certificate_) >= lambda_) {
    const double lambda = options_.certify_at(next_certificate_);
    summary_.relative_gap(next_certificate_--) =
        k == 0 && lambda > 0.0 && lambda >= lambda_max
            ? 0.0
            : ComputeDualityGap(objective_, lambda, start).Relative();
  }
}

void Homotopy::EnterUnpenalised() {
  for (int j = 0; j < n_; ++j) {
    if (objective_.weights(j) != 0.0 || state_[j] != State::kInactive) continue;
    if (Append(j, 0.0, 1e-12) <= 1e-12 * gram_(j, j)) {
      state_[j] = State::kExcluded;  // spanned by the others without penalty
    }
  }
  if (active_.empty()) return;
  const auto k = static_cast<Eigen::Index>(active_.size());
  beta_.head(k) = Gather(objective_.correlation);
  cholesky_.SolveInPlace(beta_.head(k));
  slope_.head(k).setZero();
  Products();
}

Eigen::VectorXd Homotopy::Gather(const Eigen::VectorXd& values) const {
  return values(active_);
}

// c = C − G_·A β_A and b = G_·A q.
void Homotopy::Products() {
  MultiplyActive(gram_, active_, beta_.data(), slope_.data(), c_, b_);
  c_ = objective_.correlation - c_;
  compensated_ = false;
}

// c again, in twice the working precision.
void Homotopy::CompensatedProducts() {
  Products();
  compensated_ = true;
  c_ = objective_.correlation;
  work_.setZero();
  VectorKernels().subtract_columns_twice(ActiveColumns(gram_, active_),
                                         beta_.data(), nullptr, n_, c_.data(),
                                         work_.data());
  c_ += work_;
}

double Homotopy::ActiveViolation() const {
  double worst = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const double inverse_weight =
        target_(i) == 0.0 ? greatest_inverse_ : inverse_weights_(active_[i]);
    worst = std::max(worst, inverse_weight * std::abs(c_(active_[i]) -
                                                      lambda_ * target_(i)));
  }
  return worst;
}

double Homotopy::InactiveViolation() const {
  return c_.cwiseAbs().cwiseProduct(inverse_weights_).maxCoeff() - lambda_;
}

double Homotopy::Violation() const {
  return std::max(ActiveViolation(), InactiveViolation());
}

double Homotopy::Rounding() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    sum += std::abs(beta_(i)) * root_diagonal_(active_[i]);
  }
  return kEpsilon * (scale_ + weighted_root_ * sum);
}

void Homotopy::Refine() {
  const auto k = static_cast<Eigen::Index>(active_.size());
  work_.head(k) = Gather(c_) - lambda_ * target_.head(k);
  cholesky_.SolveInPlace(work_.head(k));
  beta_.head(k) += work_.head(k);
  work_.head(k) = target_.head(k) - Gather(b_);
  cholesky_.SolveInPlace(work_.head(k));
  slope_.head(k) += work_.head(k);
  Products();
}

// c_A right to its rounding e leaves c_j of a column x_j = X_A d + … uncertain
// by ‖d‖₁ e. From c_A in twice the working precision β comes out right to its
// last digit, and with it every c_j to about e.
void Homotopy::RefineSharply() {
  const auto k = static_cast<Eigen::Index>(active_.size());
  Eigen::VectorXd high = Gather(objective_.correlation);
  Eigen::VectorXd low = Eigen::VectorXd::Zero(k);
  VectorKernels().subtract_columns_twice(ActiveColumns(gram_, active_),
                                         beta_.data(), active_.data(), k,
                                         high.data(), low.data());
  work_.head(k) = (high - lambda_ * target_.head(k)) + low;
  cholesky_.SolveInPlace(work_.head(k));
  beta_.head(k) += work_.head(k);
  Products();
}

// Whether c_j of the variable that is about to leave may then miss its bound:
// by ‖d‖₁ e, with d from the column of G_AA⁻¹ that belongs to it.
bool Homotopy::IsBlurred(int leaving) const {
  const auto position =
      std::find(active_.begin(), active_.end(), leaving) - active_.begin();
  Eigen::VectorXd column = Eigen::VectorXd::Unit(
      static_cast<Eigen::Index>(active_.size()), position);
  cholesky_.SolveInPlace(column);
  return column.lpNorm<1>() * Rounding() >
         kRefineSharply * lambda_ * column(position);
}

bool Homotopy::ComputeDirection() {
  const auto k = static_cast<Eigen::Index>(active_.size());
  const double rounding = Rounding();
  const double refine = std::max(kRefine * lambda_, rounding);
  const double lost = kLost * lambda_ + 10.0 * rounding;
  const double sharp = kRefineSharply * lambda_ + kSeveral * rounding;
  const auto solve = [&] {
    slope_.head(k) = target_.head(k);
    cholesky_.SolveInPlace(slope_.head(k));
    Products();
    double violation = ActiveViolation();
    if (violation > refine) ++summary_.refined;
    for (int pass = 0; pass < 3 && violation > refine; ++pass) {
      Refine();
      const double refined = ActiveViolation();
      const bool stagnates = refined > 0.5 * violation;
      violation = refined;
      if (stagnates) break;
    }
    if (Violation() > sharp) RefineSharply();
    return Violation();
  };
  if (solve() <= lost) return true;
  return Refactor() && solve() <= lost;
}

bool Homotopy::Refactor() {
  ++summary_.refactored;
  const std::vector<int> columns = active_;
  cholesky_.Clear();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    work_.head(i) = gram_.col(columns[i])(
        std::vector<int>(columns.begin(), columns.begin() + i));
    const double square = gram_(columns[i], columns[i]);
    if (cholesky_.Append(work_.head(i), square, 0.0) <= 0.0) return false;
  }
  return true;
}

// `slack` ≥ 0 but for rounding shrinks at `rate` > 0 as λ falls.
void Homotopy::Consider(Event::Kind kind, int variable, double slack,
                        double rate, double sign, Event& best) const {
  if (!(rate > 0.0)) return;
  const double step = std::max(slack, 0.0) / rate;
  // Once steps of zero repeat the lowest number goes first (Bland's rule).
  const bool tie = zero_steps_ > 20 && best.variable >= 0 &&
                   std::abs(step - best.step) <= 1e-14 * lambda_;
  if (tie ? variable < best.variable : step < best.step) {
    best = {kind, step, variable, sign};
  }
}

Event Homotopy::NextEvent() const {
  Event best;
  const double rounding = kSeveral * Rounding();
  best.step = std::max(lambda_ - std::max(floor_, rounding), 0.0);
  // A waiting column is tried again only if it really is beyond the bound:
  // two of them there by rounding would be tried in turn for ever.
  const double beyond = lambda_ * (1.0 + 1e-11) + rounding;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if (target_(i) == 0.0 || active_[i] == last_moved_) continue;
    const double sign = target_(i) > 0.0 ? 1.0 : -1.0;
    Consider(Event::Kind::kLeave, active_[i], sign * beta_(i),
             -sign * slope_(i), sign, best);
  }
  for (int j = 0; j < n_; ++j) {
    const bool candidate = state_[j] == State::kInactive ||
                           (state_[j] == State::kWaiting &&
                            std::abs(c_(j)) * inverse_weights_(j) > beyond);
    if (!candidate) continue;
    const double w = objective_.weights(j);
    for (const double sign : {1.0, -1.0}) {
      if (j == last_moved_ && sign == last_sign_) continue;
      Consider(Event::Kind::kEnter, j, lambda_ * w - sign * c_(j),
               w - sign * b_(j), sign, best);
    }
  }
  return best;
}

// Goes to the event; c is left to the next ComputeDirection.
void Homotopy::Advance(const Event& event) {
  const auto k = static_cast<Eigen::Index>(active_.size());
  // What is left below the floor is rounding.
  const double step = event.kind == Event::Kind::kEnd
                          ? lambda_ - options_.lambda_min
                          : event.step;
  Certify(step);
  if (step > 0.0) {
    summary_.path.Append(lambda_, lambda_ - step, active_, beta_.head(k),
                         slope_.head(k));
  }
  zero_steps_ = step <= 1e-15 * lambda_ ? zero_steps_ + 1 : 0;
  beta_.head(k) += step * slope_.head(k);
  lambda_ -= step;
}

void Homotopy::Certify(double step) {
  while (next_certificate_ >= 0 &&
         options_.certify_at(next_certificate_) >= lambda_ - step) {
    const double lambda = options_.certify_at(next_certificate_);
    double gap = lambda > 0.0 ? RelativeGapAfter(lambda_ - lambda)
                              : LeastSquaresRelativeGap(lambda_);
    if (gap > kSharpen && lambda > 0.0 && !compensated_) {
      CompensatedProducts();
      gap = RelativeGapAfter(lambda_ - lambda);
    }
    summary_.relative_gap(next_certificate_--) = gap;
  }
}

// The formula of duality_gap.h on c − t b and β + t q.
double Homotopy::RelativeGapAfter(double step) const {
  const double lambda = lambda_ - step;
  const double ratio =
      ((c_ - step * b_).cwiseAbs().cwiseProduct(inverse_weights_)).maxCoeff() /
      lambda;
  const double alpha = 1.0 / std::max(ratio, 1.0);
  DualityGap result;
  result.response_square = objective_.response_square;
  double residual_square = objective_.response_square;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const int j = active_[i];
    const double beta = beta_(i) + step * slope_(i);
    const double c = c_(j) - step * b_(j);
    residual_square -= beta * (objective_.correlation(j) + c);
    result.primal += lambda * objective_.weights(j) * std::abs(beta);
    result.gap +=
        lambda * objective_.weights(j) * std::abs(beta) - alpha * beta * c;
  }
  residual_square = std::max(residual_square, 0.0);
  result.primal += 0.5 * residual_square;
  result.gap += 0.5 * (1.0 - alpha) * (1.0 - alpha) * residual_square;
  result.gap = std::abs(result.gap);
  return result.Relative();
}

double Homotopy::LeastSquaresRelativeGap(double step) const {
  const Eigen::VectorXd gradient = c_ - step * b_;
  double residual_square = objective_.response_square;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const int j = active_[i];
    residual_square -= (beta_(i) + step * slope_(i)) *
                       (objective_.correlation(j) + gradient(j));
  }
  const bool all_active =
      std::count(state_.begin(), state_.end(), State::kInactive) +
          std::count(state_.begin(), state_.end(), State::kWaiting) ==
      0;
  DualityGap result;
  result.response_square = objective_.response_square;
  result.primal = 0.5 * std::max(residual_square, 0.0);
  result.gap = all_active
                   ? 0.5 * cholesky_.InverseQuadraticForm(Gather(gradient))
                   : LeastSquaresGap(objective_, gradient);
  return result.Relative();
}

double Homotopy::Append(int variable, double sign, double tolerance) {
  const auto k = static_cast<Eigen::Index>(active_.size());
  work_.head(k) = gram_.col(variable)(active_);
  const double square = gram_(variable, variable);
  const double pivot = cholesky_.Append(work_.head(k), square, tolerance);
  if (pivot <= tolerance * square) return pivot;
  target_(k) = sign * objective_.weights(variable);
  beta_(k) = 0.0;
  active_.push_back(variable);
  state_[variable] = State::kActive;
  return pivot;
}

void Homotopy::Enter(const Event& event) {
  const int j = event.variable;
  const double w = objective_.weights(j);
  const double rate = (w - event.sign * b_(j)) / w;
  // q solves its equations to about its own rounding.
  double size = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    size += std::abs(slope_(i)) * root_diagonal_(active_[i]);
  }
  const bool follows = rate < std::max(kFollows, kSeveral * kEpsilon * size *
                                                     root_diagonal_(j) / w);
  const double tolerance = follows ? kNearlyDependent : kDependent;
  last_moved_ = j;
  last_sign_ = event.sign;
  if (Append(j, event.sign, tolerance) > tolerance * gram_(j, j)) {
    ++summary_.entered;
  } else if (follows || !Exchange(j, event.sign)) {
    state_[j] = State::kWaiting;
  }
}

void Homotopy::Leave(int variable) {
  const auto position = static_cast<int>(
      std::find(active_.begin(), active_.end(), variable) - active_.begin());
  const auto k = static_cast<Eigen::Index>(active_.size());
  last_moved_ = variable;
  last_sign_ = target_(position) > 0.0 ? 1.0 : -1.0;
  cholesky_.Remove(position);
  active_.erase(active_.begin() + position);
  for (Eigen::VectorXd* values : {&target_, &beta_}) {
    for (Eigen::Index i = position; i + 1 < k; ++i) {
      (*values)(i) = (*values)(i + 1);
    }
  }
  state_[variable] = State::kInactive;
  for (State& state : state_) {
    if (state == State::kWaiting) state = State::kInactive;
  }
  ++summary_.left;
}

// x_j = X_A d: moves along β_j += τ s, β_A −= τ s d until a coefficient is
// zero, which leaves in favour of j. False where none shrinks.
bool Homotopy::Exchange(int entering, double sign) {
  const auto k = static_cast<Eigen::Index>(active_.size());
  Eigen::VectorXd d = gram_.col(entering)(active_);
  cholesky_.SolveInPlace(d);
  double step = kInfinity;
  int leaving = -1;
  for (Eigen::Index i = 0; i < k; ++i) {
    const double shrink = sign * d(i) * (target_(i) > 0.0 ? 1.0 : -1.0);
    if (target_(i) == 0.0 || !(shrink > kNearlyDependent)) continue;
    const double candidate = std::abs(beta_(i)) / shrink;
    if (candidate < step) {
      step = candidate;
      leaving = active_[i];
    }
  }
  if (leaving < 0) return false;
  beta_.head(k) -= step * sign * d;
  Leave(leaving);
  if (Append(entering, sign, kDependent) <=
      kDependent * gram_(entering, entering)) {
    return false;
  }
  beta_(active_.size() - 1) = step * sign;
  ++summary_.exchanged;
  ++zero_steps_;
  return true;
}

}  // namespace

absl::Status HomotopyOptions::Validate() const {
  if (!(lambda_min >= 0.0) || !std::isfinite(lambda_min)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("lambda_min is %g; it must be ≥ 0", lambda_min));
  }
  if (max_active < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("max_active is %d; it must be ≥ 1", max_active));
  }
  for (Eigen::Index i = 0; i < certify_at.size(); ++i) {
    if (!(certify_at(i) >= 0.0) || !std::isfinite(certify_at(i)) ||
        (i > 0 && !(certify_at(i) >= certify_at(i - 1)))) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "certify_at[%d] is %g; the values must be ≥ 0 and ascending", i,
          certify_at(i)));
    }
  }
  return absl::OkStatus();
}

double HomotopySummary::MaxRelativeGap() const {
  return relative_gap.size() > 0 ? relative_gap.maxCoeff() : 0.0;
}

std::string HomotopySummary::BriefReport() const {
  const char* ending = "not run";
  switch (termination) {
    case HomotopyTermination::kNotRun:
      break;
    case HomotopyTermination::kReachedLambdaMin:
      ending = "complete";
      break;
    case HomotopyTermination::kReachedMaxActive:
      ending = "stopped at the largest active set allowed";
      break;
    case HomotopyTermination::kStalled:
      ending = "stalled in a tie";
      break;
    case HomotopyTermination::kIllConditioned:
      ending = "lost the optimality conditions";
      break;
  }
  return absl::StrFormat(
      "homotopy: %s at λ = %.3g, %d segments, %d entered, %d left, %d "
      "exchanged, at most %d active, relative gap ≤ %.2g",
      ending, path.lambda_end(), path.segments().size(), entered, left,
      exchanged, max_active, MaxRelativeGap());
}

absl::StatusOr<HomotopySummary> SolveHomotopy(const LassoObjective& objective,
                                              const HomotopyOptions& options) {
  MLE_RETURN_IF_ERROR(objective.Validate());
  MLE_RETURN_IF_ERROR(options.Validate());
  return Homotopy(objective, options).Run();
}

}  // namespace mle
