// The runs of one unit of a campaign (grid.h). What they have in common is
// computed once: the conversion for the unit, records for a scenario, paths for
// a solver.

#ifndef APPS_EXPERIMENT_UNIT_H_
#define APPS_EXPERIMENT_UNIT_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/status.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/experiment.h"
#include "apps/experiment/grid.h"

namespace mle::experiment {

// How a run went. What is pointed to lives until the callback returns.
struct Outcome {
  std::int64_t run = 0;
  Coordinates at;
  absl::Status status;
  Experiment* experiment = nullptr;        // null where there were no records
  const Evaluation* evaluation = nullptr;  // null unless `status` is good
  // Processor time; work that runs share counts for the first that needs it.
  double seconds = 0.0;
};

// `runs` are some of the runs of one unit, in the order of Grid::RunsOf(). Each
// is given to `emit` as soon as it is done, also where it failed; none is
// started once `stop` is set. An outcome depends on nothing but the campaign
// and the run's number, but for its seconds.
void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Outcome&)>& emit);

// The figures of merit of an outcome.
Row RowOf(const Outcome& outcome);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_UNIT_H_
