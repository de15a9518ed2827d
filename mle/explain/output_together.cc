// The fit of all elements of an output at once (several_steps.h), and when it
// takes the place of what won one by one.

#include <algorithm>
#include <utility>
#include <vector>

#include "mle/explain/output_competition.h"
#include "mle/explain/several_steps.h"

namespace mle {
namespace {

// By which errors held out have to fall at every horizon for a fit of all
// elements at once, and in place of fewer changes that won.
constexpr double kFarBetter = 0.7;
constexpr double kHalf = 0.5;

// Whether errors held out are smaller at every horizon, by this factor, than
// without what explains them and than by `others`, which may be none.
bool AllFall(const std::vector<HorizonErrors>& errors,
             const std::vector<HorizonErrors>& others, double factor) {
  for (std::size_t h = 0; h < errors.size(); ++h) {
    double before = errors[h].initial;
    if (h < others.size()) before = std::min(before, others[h].explained);
    if (!(errors[h].explained < factor * before)) return false;
  }
  return !errors.empty();
}

// Squares of errors held out several steps ahead, each as a share of those of
// the model as it is, summed over the horizons. A horizon without errors held
// out, or with larger ones than the model's, counts as one: no improvement.
double Squares(const std::vector<HorizonErrors>& held_out) {
  double sum = 0.0;
  for (std::size_t h = 0; h < kStepsAhead.size(); ++h) {
    const bool known = h < held_out.size() && held_out[h].horizon > 0.0;
    const double share =
        known ? held_out[h].explained / held_out[h].initial : 1.0;
    sum += std::min(1.0, share * share);
  }
  return sum;
}

}  // namespace

void OutputCompetition::FitTogether() {
  const bool answered = feedback_p_value_.has_value() && !OpenLoop();
  if (answered || (OpenLoop() && !(energy_ > kMuchLeft * chance_))) return;
  // Where nothing is answered any fall is enough.
  const double enough = OpenLoop() ? 1.0 : kFarBetter;
  const SeveralSteps several_steps(output_, instruments_);
  for (const bool second_lags : {true, false}) {
    SeveralStepsFit fit =
        several_steps.Best(second_lags, enough * enough * Squares(held_out_));
    const double energy = Energy(fit.explanations);
    const Chance chance = ChanceOf({fit.explanations}, directions_);
    const double evidence = EvidenceOf(energy_ - energy, chance.unit);
    const bool more = !OpenLoop() && !taken_.empty() &&
                      fit.explanations.size() > taken_.size();
    if (!(evidence > EvidenceOfOne()) ||
        !AllFall(fit.held_out, held_out_, more ? kHalf : enough)) {
      continue;
    }
    together_ = true;
    held_out_ = std::move(fit.held_out);
    covariance_together_ = std::move(fit.covariance);
    taken_.clear();
    ties_.clear();
    for (const Explanation& one : fit.explanations) {
      taken_.push_back({one, 0.0, evidence});
    }
    energy_ = energy;
    chance_ = chance.energy;
    unit_ = chance.unit;
    return;
  }
}

}  // namespace mle
