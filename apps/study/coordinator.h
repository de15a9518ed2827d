// Who runs what. Process 0 deals the units of a campaign to its own threads and
// to the other processes, each getting more when it has done what it had, and
// is the only one to write the journal.

#ifndef APPS_STUDY_COORDINATOR_H_
#define APPS_STUDY_COORDINATOR_H_

#include <functional>

#include "absl/status/status.h"
#include "apps/common/progress.h"
#include "apps/experiment/grid.h"
#include "apps/study/campaign.h"
#include "apps/study/journal.h"
#include "apps/study/processes.h"
#include "apps/study/worker_pool.h"

namespace mle::study {

// Process 0: until every run is in the journal, or `stopped` says so (then the
// runs under way are still waited for). `told` is called with the runs done and
// all of them, in the beginning and several times a second.
absl::Status Coordinate(const experiment::Grid& grid, Processes& processes,
                        WorkerPool& pool, Journal& journal,
                        const std::function<bool()>& stopped,
                        const ProgressFunction& told);

// The other processes: until process 0 has nothing more to do, or `stopped`.
void Serve(Processes& processes, WorkerPool& pool,
           const std::function<bool()>& stopped);

}  // namespace mle::study

#endif  // APPS_STUDY_COORDINATOR_H_
