#include "mle/nonlinear/smoothed_lasso.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/nonlinear/smoothed_stage.h"

namespace mle {
namespace {

using Eigen::VectorXd;

// ε begins at this share of the largest coefficient a regressor could have by
// itself, and after a start that is given, of its largest coefficient.
constexpr double kFirstSmoothing = 0.1;
constexpr double kFirstSmoothingAfterStart = 1e-2;
// A start at zero goes by larger λ, each this share of the one before, and
// solves for them with this relative gap.
constexpr double kApproach = 0.4;
constexpr double kApproachTolerance = 1e-2;
// With this share of all coefficients among the unknowns there is little left
// to choose: the rest joins at once, and no larger λ is solved first.
constexpr double kManyShare = 0.5;
// max_x x (1 − x/√(1 + x²)): what ε leaves in the gap, for each λw.
constexpr double kSmoothingGap = 0.3003;
// ε falls until that is at most this share of the gap allowed, and further
// where more is needed, down to the second.
constexpr double kGapShare = 0.3;
constexpr double kSmallestShare = 1e-6;
// A stage on the way ends when a step lowers the objective by less than this
// share of that.
constexpr double kStageTolerance = 3e-3;
constexpr double kTrustRadius = 1e9;
// At most this many unknowns or, if that is more, this share of those in use
// join at a time: the most wanted need others less than these themselves (but
// see kManyShare).
constexpr int kMinJoin = 20;
constexpr double kJoinShare = 0.2;
// c_j beyond λw_j by this share of it counts as outside.
constexpr double kOutside = 1e-9;
// An unknown leaves when |c_j| is below this share of λw_j.
constexpr double kFarInside = 0.7;
// |β_j| below these multiples of ε are tried as zero, one after the other.
constexpr double kZeroMultiples[] = {1e4, 1e2, 3.0};
// ε while the others are solved once more, as a share of the last.
constexpr double kPolishShare = 1e-2;
constexpr double kPolishTrustRadius = 1e16;
// ε, as a share of the largest coefficient, for a start nearby.
constexpr double kContinuationSmoothing = 1e-14;
// While they are solved, a coefficient below the first multiple of ε has
// vanished; one that joins starts at the second, where ε does not hold it.
constexpr double kVanished = 1e2;
constexpr double kJoining = 1e3;
constexpr int kMaxPolishes = 12;  // for each multiple

class SmoothedLasso {
 public:
  SmoothedLasso(const LassoObjective& objective, double lambda,
                const SmoothedLassoOptions& options)
      : objective_(objective), lambda_(lambda), options_(options) {}

  SmoothedLassoSummary Solve(const VectorXd& start) {
    beta_ = start.size() > 0 ? start : VectorXd::Zero(objective_.size());
    for (int j = 0; j < objective_.size(); ++j) {
      if (!std::isfinite(objective_.weights(j))) beta_(j) = 0.0;
    }
    smoothing_ = FirstSmoothing();
    if (smoothing_ > 0.0) {
      if (!Continue()) {
        if (beta_.isZero()) Approach();
        Descend(options_.tolerance);
        if (Going()) RemoveSmoothing();
      }
    } else {
      summary_.message = "nothing correlates with the response";
    }
    summary_.beta = beta_;
    summary_.gap = ComputeDualityGap(objective_, lambda_, beta_);
    summary_.smoothing = smoothing_;
    summary_.num_nonzero = static_cast<int>((beta_.array() != 0.0).count());
    if (summary_.termination != SmoothedLassoTermination::kFailed) {
      summary_.termination = summary_.gap.Relative() <= options_.tolerance
                                 ? SmoothedLassoTermination::kConverged
                                 : SmoothedLassoTermination::kStageLimit;
    }
    return std::move(summary_);
  }

 private:
  double Penalty(int j) const { return lambda_ * objective_.weights(j); }

  bool Going() const {
    return summary_.termination != SmoothedLassoTermination::kFailed &&
           summary_.solves < options_.max_stages;
  }

  double FirstSmoothing() const {
    const double largest = beta_.cwiseAbs().maxCoeff();
    if (largest > 0.0) return kFirstSmoothingAfterStart * largest;
    double size = 0.0;
    for (int j = 0; j < objective_.size(); ++j) {
      const double square = (*objective_.gram)(j, j);
      if (square > 0.0 && std::isfinite(objective_.weights(j))) {
        size = std::max(size, std::abs(objective_.correlation(j)) / square);
      }
    }
    return kFirstSmoothing * size;
  }

  // Whether it is enough to take the coefficients of the start and solve for
  // them, as where λ has moved a little.
  bool Continue() {
    if (beta_.isZero()) return false;
    const VectorXd start = beta_;
    if (Polish(kContinuationSmoothing * beta_.cwiseAbs().maxCoeff())) {
      return true;
    }
    beta_ = start;
    return false;
  }

  // From zero, by larger λ on the way, where fewer coefficients are needed.
  void Approach() {
    const double last = lambda_;
    std::vector<double> larger;
    double largest = 0.0;
    for (int j = 0; j < objective_.size(); ++j) {
      const double weight = objective_.weights(j);
      if (weight > 0.0 && std::isfinite(weight)) {
        largest =
            std::max(largest, std::abs(objective_.correlation(j)) / weight);
      }
    }
    for (lambda_ = kApproach * largest; lambda_ > 1.5 * last && Going();
         lambda_ *= kApproach) {
      Descend(kApproachTolerance);
      if (static_cast<double>((beta_.array() != 0.0).count()) >
          kManyShare * objective_.size()) {
        break;
      }
    }
    lambda_ = last;
  }

  VectorXd Gradient() const {
    VectorXd c = objective_.correlation;
    for (int j = 0; j < beta_.size(); ++j) {
      if (beta_(j) != 0.0) c -= beta_(j) * objective_.gram->col(j);
    }
    return c;
  }

  // One Ceres solve for `unknowns` from β; the first at `warm` smoothing.
  void SolveStage(const std::vector<int>& unknowns, double smoothing,
                  const VectorXd& c, double cost_tolerance,
                  double trust_radius) {
    SmoothedStage stage;
    stage.gram = (*objective_.gram)(unknowns, unknowns);
    stage.gradient = c(unknowns);
    stage.penalty = lambda_ * objective_.weights(unknowns);
    stage.beta = beta_(unknowns);
    stage.smoothing = smoothing;
    stage.cost_tolerance = cost_tolerance;
    stage.trust_radius = trust_radius;
    stage.max_iterations = options_.max_iterations;
    const StageResult result = SolveSmoothedStage(stage);
    ++summary_.solves;
    summary_.iterations += result.iterations;
    summary_.max_unknowns =
        std::max(summary_.max_unknowns, static_cast<int>(unknowns.size()));
    summary_.message = result.message;
    if (!result.usable) {
      summary_.termination = SmoothedLassoTermination::kFailed;
      return;
    }
    stage_converged_ = result.converged;
    beta_(unknowns) = result.beta;
    smoothing_ = smoothing;
  }

  // Adds to `unknowns` what asks to join, the most wanted first; whether any
  // did.
  bool Join(const VectorXd& c, std::vector<int>& unknowns) const {
    std::vector<bool> known(objective_.size(), false);
    for (const int j : unknowns) known[j] = true;
    std::vector<std::pair<double, int>> outside;
    for (int j = 0; j < objective_.size(); ++j) {
      if (known[j] || !std::isfinite(objective_.weights(j)) ||
          !((*objective_.gram)(j, j) > 0.0)) {
        continue;
      }
      if (std::abs(c(j)) > Penalty(j) * (1.0 + kOutside)) {
        outside.emplace_back(Penalty(j) - std::abs(c(j)), j);
      }
    }
    std::sort(outside.begin(), outside.end());
    const bool many =
        kManyShare * objective_.size() < static_cast<double>(unknowns.size());
    const auto limit =
        many ? outside.size()
             : std::max<std::size_t>(
                   kMinJoin,
                   static_cast<std::size_t>(
                       kJoinShare * static_cast<double>(unknowns.size())));
    if (outside.size() > limit) outside.resize(limit);
    for (const auto& [excess, j] : outside) unknowns.push_back(j);
    std::sort(unknowns.begin(), unknowns.end());
    return !outside.empty();
  }

  // Sets to zero and removes unknowns that are far inside; each once only, so
  // that none comes and goes for ever.
  void Leave(const VectorXd& c, std::vector<bool>& has_left,
             std::vector<int>& unknowns) {
    std::erase_if(unknowns, [&](int j) {
      const bool leaves = !has_left[j] &&
                          std::abs(c(j)) < kFarInside * Penalty(j) &&
                          std::abs(beta_(j)) < 3.0 * smoothing_;
      if (leaves) {
        beta_(j) = 0.0;
        has_left[j] = true;
      }
      return leaves;
    });
  }

  // The gap that ε alone may leave among the unknowns.
  double SmoothingGap(const std::vector<int>& unknowns,
                      double smoothing) const {
    return kSmoothingGap * smoothing * lambda_ *
           objective_.weights(unknowns).sum();
  }

  // Lets ε fall until the relative gap is at most `tolerance` for all
  // coefficients.
  void Descend(double tolerance) {
    std::vector<int> unknowns;
    for (int j = 0; j < objective_.size(); ++j) {
      if (beta_(j) != 0.0 ||
          (objective_.weights(j) == 0.0 && (*objective_.gram)(j, j) > 0.0)) {
        unknowns.push_back(j);
      }
    }
    std::vector<bool> has_left(objective_.size(), false);
    VectorXd c = Gradient();
    Join(c, unknowns);
    double smoothing = FirstSmoothing();
    double share = kGapShare;
    while (Going() && !unknowns.empty()) {
      SolveStage(unknowns, smoothing, c,
                 kStageTolerance * SmoothingGap(unknowns, smoothing),
                 kTrustRadius);
      if (!Going()) return;
      c = Gradient();
      const DualityGap gap = ComputeDualityGap(objective_, lambda_, beta_);
      if (gap.Relative() <= tolerance) return;
      if (!stage_converged_) continue;
      if (SmoothingGap(unknowns, smoothing) > share * tolerance * gap.primal) {
        smoothing *= options_.smoothing_decrease;
        continue;
      }
      Leave(c, has_left, unknowns);
      if (Join(c, unknowns)) {
        smoothing = std::max(smoothing, FirstSmoothing());
      } else {
        // Only accuracy is missing.
        share *= options_.smoothing_decrease;
        smoothing *= options_.smoothing_decrease;
        if (share < kSmallestShare) return;
      }
    }
  }

  // Solves for the coefficients that are not zero alone, taking out those that
  // change sign and in those that ask to join, until nothing moves.
  bool Polish(double smoothing) {
    std::vector<int> unknowns;
    for (int j = 0; j < objective_.size(); ++j) {
      if (beta_(j) != 0.0) unknowns.push_back(j);
    }
    const double cost_tolerance =
        kGapShare * options_.tolerance *
        ComputeDualityGap(objective_, lambda_, beta_).primal;
    for (int i = 0; i < kMaxPolishes && Going(); ++i) {
      if (unknowns.empty()) break;
      VectorXd c = Gradient();
      for (const int j : unknowns) {
        if (beta_(j) == 0.0)
          beta_(j) = std::copysign(kJoining * smoothing, c(j));
      }
      const VectorXd before = beta_;
      SolveStage(unknowns, smoothing, Gradient(), cost_tolerance,
                 kPolishTrustRadius);
      if (!Going()) return false;
      std::erase_if(unknowns, [&](int j) {
        const bool vanished = objective_.weights(j) > 0.0 &&
                              (std::abs(beta_(j)) < kVanished * smoothing ||
                               before(j) * beta_(j) < 0.0);
        if (vanished) beta_(j) = 0.0;
        return vanished;
      });
      const bool joined = Join(Gradient(), unknowns);
      if (ComputeDualityGap(objective_, lambda_, beta_).Relative() <=
              options_.tolerance ||
          (!joined && beta_ == before)) {
        break;
      }
    }
    return ComputeDualityGap(objective_, lambda_, beta_).Relative() <=
           options_.tolerance;
  }

  // Coefficients that only ε keeps from zero are set to zero.
  void RemoveSmoothing() {
    const VectorXd smooth = beta_;
    const double smoothing = smoothing_;
    VectorXd best = beta_;
    double best_gap = ComputeDualityGap(objective_, lambda_, beta_).Relative();
    for (const double multiple : kZeroMultiples) {
      beta_ = smooth;
      for (int j = 0; j < beta_.size(); ++j) {
        if (objective_.weights(j) > 0.0 &&
            std::abs(beta_(j)) < multiple * smoothing) {
          beta_(j) = 0.0;
        }
      }
      if (Polish(kPolishShare * smoothing)) return;
      const double gap =
          ComputeDualityGap(objective_, lambda_, beta_).Relative();
      if (gap < best_gap) {
        best = beta_;
        best_gap = gap;
      }
      if (!Going()) break;
    }
    beta_ = best;
  }

  const LassoObjective& objective_;
  double lambda_;
  const SmoothedLassoOptions& options_;
  VectorXd beta_;
  double smoothing_ = 0.0;
  bool stage_converged_ = false;
  SmoothedLassoSummary summary_;
};

}  // namespace

absl::StatusOr<SmoothedLassoSummary> SolveSmoothedLasso(
    const LassoObjective& objective, double lambda, const VectorXd& start,
    const SmoothedLassoOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(objective.Validate());
  if (!(lambda >= 0.0) || !std::isfinite(lambda)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "smoothed lasso: λ is ", lambda, ", must be finite and not negative"));
  }
  if (start.size() > 0 && start.size() != objective.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("smoothed lasso: the start has ", start.size(),
                     " coefficients, the problem ", objective.size()));
  }
  if (start.size() > 0 && !start.allFinite()) {
    return absl::InvalidArgumentError(
        "smoothed lasso: a coefficient of the start is not finite");
  }
  if (lambda > 0.0) {
    return SmoothedLasso(objective, lambda, options).Solve(start);
  }
  SmoothedLassoSummary summary;
  summary.beta = MinimumNormLeastSquares(objective);
  summary.gap = ComputeDualityGap(objective, 0.0, summary.beta);
  summary.smoothing = 0.0;
  summary.num_nonzero = static_cast<int>((summary.beta.array() != 0.0).count());
  summary.termination = SmoothedLassoTermination::kConverged;
  summary.message = "λ is 0: least squares, by eigenvalues";
  return summary;
}

}  // namespace mle
