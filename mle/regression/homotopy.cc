#include "mle/regression/homotopy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/regression/active_set.h"
#include "mle/regression/path_certificate.h"

namespace mle {
namespace {

using State = ActiveSet::State;

// Below this part they are looked at twice: a twin's c_j follows the bound at a
// relative rate below kFollows.
constexpr double kNearlyDependent = 1e-9;
constexpr double kFollows = 1e-7;
// The path counts as ended at this part of λ_max, or at kSeveralRoundings
// times the rounding of c.
constexpr double kFloor = 1e-13;
// Where rounding of β at a knot changes c by more than the first part of λ, the
// next knot is no farther than at the second.
constexpr double kBlurs = 1e-9;
constexpr double kFarthest = 0.1;

struct Event {
  enum class Kind { kEnd, kEnter, kLeave, kKnot } kind = Kind::kEnd;
  double step = 0.0;
  int variable = -1;
  double sign = 0.0;    // of an entering variable's c_j
  double lambda = 0.0;  // where no variable moves
};

class Homotopy {
 public:
  Homotopy(const LassoObjective& objective, const HomotopyOptions& options)
      : objective_(objective),
        options_(options),
        active_(objective),
        certificate_(options.certify_at) {
    summary_.path = LassoPath(objective.size());
  }

  HomotopySummary Run();

 private:
  void Start();
  // Whether c_j is beyond its bound by more than rounding.
  bool IsBeyond(int j) const;
  Event NextEvent() const;
  void Consider(Event::Kind kind, int variable, double slack, double rate,
                double sign, Event& best) const;
  void Advance(const Event& event);
  void Handle(const Event& event);
  void Enter(const Event& event);
  void Leave(int variable);
  HomotopySummary Finish();

  const LassoObjective& objective_;
  const HomotopyOptions& options_;
  ActiveSet active_;
  PathCertificate certificate_;
  double lambda_ = 0.0;
  double floor_ = 0.0;
  // The variable that moved last and the bound it moved at: barred one step.
  int last_moved_ = -1;
  double last_sign_ = 0.0;
  int zero_steps_ = 0;
  HomotopySummary summary_;
};

HomotopySummary Homotopy::Run() {
  Start();
  while (summary_.termination == HomotopyTermination::kNotRun) {
    if (!active_.Solve(lambda_)) {
      summary_.termination = HomotopyTermination::kIllConditioned;
      break;
    }
    Event event = NextEvent();
    if (event.kind == Event::Kind::kLeave &&
        active_.IsBlurred(event.variable, lambda_)) {
      active_.RefineSharply(lambda_);
      event = NextEvent();
    }
    Advance(event);
    Handle(event);
    if (zero_steps_ > 4 * objective_.size() + 100) {
      summary_.termination = HomotopyTermination::kStalled;
    }
    summary_.max_active = std::max(summary_.max_active, active_.size());
  }
  return Finish();
}

void Homotopy::Start() {
  const double lambda_max =
      active_.c().cwiseAbs().cwiseProduct(active_.inverse_weights()).maxCoeff();
  floor_ = std::max(options_.lambda_min, kFloor * active_.scale());
  lambda_ = lambda_max;
  if (lambda_max <= std::max(floor_, kSeveralRoundings * active_.Rounding())) {
    summary_.termination = HomotopyTermination::kReachedLambdaMin;
    lambda_ = options_.lambda_min;
  }
  // Above λ_max only the unpenalised coefficients differ from zero.
  if (active_.size() > 0) {
    summary_.path.Append(std::numeric_limits<double>::max(), lambda_,
                         active_.columns(), active_.betas(), active_.slopes());
  }
  certificate_.Start(active_, lambda_max, lambda_);
}

HomotopySummary Homotopy::Finish() {
  certificate_.Finish(objective_, summary_.path);
  summary_.relative_gap = certificate_.relative_gap();
  summary_.refined = active_.refined();
  summary_.refactored = active_.refactored();
  summary_.reciprocal_condition_bound =
      active_.cholesky().ReciprocalConditionBound();
  return std::move(summary_);
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

bool Homotopy::IsBeyond(int j) const {
  return std::abs(active_.c()(j)) * active_.inverse_weights()(j) >
         lambda_ * (1.0 + 1e-11) + kSeveralRoundings * active_.Rounding();
}

Event Homotopy::NextEvent() const {
  Event best;
  const double rounding = kSeveralRoundings * active_.Rounding();
  const double end = std::max(floor_, rounding);
  if (const double blurred =
          std::min(kFarthest * lambda_, active_.Rounding() / kBlurs);
      blurred > end) {
    best = {.kind = Event::Kind::kKnot,
            .step = lambda_ - blurred,
            .lambda = blurred};
  } else {
    // The rest below the end is rounding.
    best = {.step = std::max(lambda_ - end, 0.0),
            .lambda = options_.lambda_min};
  }
  // A waiting column is tried again only if it really is beyond the bound:
  // two of them there by rounding would be tried in turn for ever.
  for (int i = 0; i < active_.size(); ++i) {
    const int j = active_.columns()[i];
    if (active_.target(i) == 0.0 || j == last_moved_) continue;
    const double sign = active_.target(i) > 0.0 ? 1.0 : -1.0;
    Consider(Event::Kind::kLeave, j, sign * active_.beta(i),
             -sign * active_.slope(i), sign, best);
  }
  for (int j = 0; j < objective_.size(); ++j) {
    const bool candidate = active_.state(j) == State::kInactive ||
                           (active_.state(j) == State::kWaiting && IsBeyond(j));
    if (!candidate) continue;
    const double w = objective_.weights(j);
    for (const double sign : {1.0, -1.0}) {
      if (j == last_moved_ && sign == last_sign_) continue;
      Consider(Event::Kind::kEnter, j, lambda_ * w - sign * active_.c()(j),
               w - sign * active_.b()(j), sign, best);
    }
  }
  return best;
}

// Goes to the event; c is left to the next solve.
void Homotopy::Advance(const Event& event) {
  const double end = event.variable < 0 ? event.lambda : lambda_ - event.step;
  const double step = lambda_ - end;
  certificate_.Continue(active_, lambda_, end, event.kind == Event::Kind::kEnd);
  if (step > 0.0) {
    summary_.path.Append(lambda_, end, active_.columns(), active_.betas(),
                         active_.slopes());
  }
  zero_steps_ = step <= 1e-15 * lambda_ ? zero_steps_ + 1 : 0;
  active_.Move(step);
  lambda_ = end;
}

void Homotopy::Handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::kEnd:
      summary_.termination = HomotopyTermination::kReachedLambdaMin;
      break;
    case Event::Kind::kEnter:
      if (active_.size() >= options_.max_active) {
        summary_.termination = HomotopyTermination::kReachedMaxActive;
      } else {
        Enter(event);
      }
      break;
    case Event::Kind::kLeave:
      Leave(event.variable);
      break;
    case Event::Kind::kKnot:
      last_moved_ = -1;
      break;
  }
}

void Homotopy::Enter(const Event& event) {
  const int j = event.variable;
  const double rate = 1.0 - event.sign * active_.b()(j) / objective_.weights(j);
  // A twin that waited and is beyond the bound by more than rounding takes the
  // other's place: to try it again would be to wait for ever.
  const bool follows =
      rate < std::max(kFollows, kSeveralRoundings * active_.SlopeRounding(j)) &&
      !(active_.state(j) == State::kWaiting && IsBeyond(j));
  const double tolerance = follows ? kNearlyDependent : kDependentPivot;
  const double square = (*objective_.gram)(j, j);
  last_moved_ = j;
  last_sign_ = event.sign;
  if (active_.Append(j, event.sign, tolerance) > tolerance * square) {
    ++summary_.entered;
    return;
  }
  if (!follows) {
    const ActiveSet::Exchanged exchanged = active_.Exchange(j, event.sign);
    if (exchanged.left >= 0) {
      ++summary_.left;
      last_moved_ = exchanged.left;
      last_sign_ = exchanged.sign;
    }
    if (exchanged.entered) {
      ++summary_.exchanged;
      ++zero_steps_;
      return;
    }
  }
  active_.Wait(j);
}

void Homotopy::Leave(int variable) {
  last_moved_ = variable;
  last_sign_ = active_.target(active_.PositionOf(variable)) > 0.0 ? 1.0 : -1.0;
  active_.Remove(variable);
  ++summary_.left;
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
