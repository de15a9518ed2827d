// The runs of one unit of a campaign (grid.h): the experiment, judged against
// the plant. What the runs have in common is computed once: the conversion for
// the unit, records for a scenario, paths for a solver.

#ifndef APPS_STUDY_UNIT_H_
#define APPS_STUDY_UNIT_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "apps/study/campaign.h"
#include "apps/study/grid.h"
#include "apps/study/row.h"

namespace mle::study {

// `runs` are runs of one unit, in the order of Grid::RunsOf(). Each is given to
// `emit` as soon as it is done, also where it failed; none is started once
// `stop` is set. A row depends on nothing but the campaign and its number, but
// for its seconds.
void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Row&)>& emit);

}  // namespace mle::study

#endif  // APPS_STUDY_UNIT_H_
