#include "apps/experiment/grid.h"

#include <algorithm>

namespace mle::experiment {
namespace {

template <typename List>
int Count(const List& list) {
  return static_cast<int>(list.size());
}

// The last digit of `number` in base `base`, which is taken off.
int Digit(std::int64_t& number, int base) {
  const auto digit = static_cast<int>(number % base);
  number /= base;
  return digit;
}

}  // namespace

Grid::Grid(const Campaign& campaign, int unit_scenarios)
    : models_(Count(campaign.models)),
      noises_(Count(campaign.noise_variances)),
      ablations_(Count(campaign.ablations)),
      drifts_(Count(campaign.drift_variances)),
      effects_(Count(campaign.effects)),
      controllers_(Count(campaign.controllers)),
      windows_(Count(campaign.windows)),
      mismatches_(Count(campaign.mismatches)),
      methods_(Count(campaign.methods)),
      seeds_(Count(campaign.seeds)),
      unit_scenarios_(unit_scenarios) {
  constexpr double kMostRuns = 1e9;
  double runs = 1.0;
  for (const int count :
       {models_, noises_, ablations_, drifts_, effects_, controllers_, windows_,
        mismatches_, methods_, seeds_}) {
    runs *= count;
  }
  countable_ = runs <= kMostRuns;
  conversions_ = static_cast<std::int64_t>(models_) * noises_ * ablations_;
  shared_ = countable_ ? static_cast<std::int64_t>(drifts_) * effects_ *
                             controllers_ * windows_ * mismatches_
                       : 1;
  blocks_ = (shared_ + unit_scenarios_ - 1) / unit_scenarios_;
  scenarios_ = countable_ ? conversions_ * shared_ : 1;
}

Coordinates Grid::At(std::int64_t run) const {
  Coordinates at;
  at.seed = Digit(run, seeds_);
  at.method = Digit(run, methods_);
  at.scenario.mismatch = Digit(run, mismatches_);
  at.scenario.windows = Digit(run, windows_);
  at.scenario.controller = Digit(run, controllers_);
  at.scenario.effects = Digit(run, effects_);
  at.scenario.drift = Digit(run, drifts_);
  at.scenario.ablation = Digit(run, ablations_);
  at.scenario.noise = Digit(run, noises_);
  at.scenario.model = static_cast<int>(run);
  return at;
}

std::vector<std::int64_t> Grid::RunsOf(std::int64_t unit) const {
  const std::int64_t block = unit % blocks_;
  const std::int64_t conversion = unit / blocks_ % conversions_;
  const std::int64_t seed = unit / blocks_ / conversions_;
  const std::int64_t first = conversion * shared_ + block * unit_scenarios_;
  const std::int64_t count = std::min<std::int64_t>(
      unit_scenarios_, shared_ - block * unit_scenarios_);
  std::vector<std::int64_t> runs;
  runs.reserve(static_cast<std::size_t>(count * methods_));
  for (std::int64_t s = first; s < first + count; ++s) {
    for (std::int64_t m = 0; m < methods_; ++m) {
      runs.push_back((s * methods_ + m) * seeds_ + seed);
    }
  }
  return runs;
}

}  // namespace mle::experiment
