// The runs of a campaign by number, and the units of work they are dealt in.
//
// A run's number is (scenario · methods + method) · seeds + seed, the
// scenario's own digits being model, noise, ablation, drift, effects,
// controller, windows and mismatch: the runs of a cell of the grid, which
// differ in nothing but the seed, follow one another.
//
// A unit is one seed with a few scenarios that share the
// conversion of the initial model, and all methods on them: what they have in
// common is computed once. Units follow one another seed by seed, so that a
// campaign that is cut short has seen every cell. Nothing is kept in memory:
// both orders are arithmetic.

#ifndef APPS_EXPERIMENT_GRID_H_
#define APPS_EXPERIMENT_GRID_H_

#include <cstdint>
#include <vector>

#include "apps/experiment/campaign.h"

namespace mle::experiment {

struct Coordinates {
  Scenario scenario;
  int method = 0;
  int seed = 0;  // index
};

class Grid {
 public:
  static constexpr int kUnitScenarios = 4;

  // Units of up to `unit_scenarios` ≥ 1 scenarios.
  explicit Grid(const Campaign& campaign, int unit_scenarios = kUnitScenarios);

  std::int64_t num_runs() const { return num_cells() * seeds_; }
  std::int64_t num_cells() const { return scenarios_ * methods_; }
  std::int64_t num_units() const { return conversions_ * blocks_ * seeds_; }
  int seeds() const { return seeds_; }

  // False where the campaign has more runs than can be counted.
  bool IsCountable() const { return countable_; }

  Coordinates At(std::int64_t run) const;
  std::int64_t CellOf(std::int64_t run) const { return run / seeds_; }

  // The runs of a unit: scenario by scenario, method by method.
  std::vector<std::int64_t> RunsOf(std::int64_t unit) const;

 private:
  int models_, noises_, ablations_, drifts_, effects_, controllers_, windows_;
  int mismatches_, methods_, seeds_;
  int unit_scenarios_;
  std::int64_t conversions_;  // models × noises × ablations
  std::int64_t shared_;       // scenarios that share a conversion
  std::int64_t blocks_;       // units they make
  std::int64_t scenarios_;
  bool countable_;
};

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_GRID_H_
