// All requested lives: every policy, at every rate of ageing, with
// every seed. Lives with the same rate and seed have set points, noise,
// disturbances and plant in common.

#ifndef APPS_LIFECYCLE_CAMPAIGN_H_
#define APPS_LIFECYCLE_CAMPAIGN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/experiment/run_folder.h"
#include "apps/lifecycle/life.h"
#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/scenario.h"
#include "apps/lifecycle/store.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"

namespace mle::lifecycle {

struct Campaign {
  ProcessModel model;
  ProcessModel plant;
  sim::AgeingSchedule ageing;  // at the rate 1
  SetPointOptions set_points;
  LifeOptions life;
  std::vector<Policy> policies;
  std::vector<double> rates;
  std::vector<std::uint64_t> seeds;
  Settings settings;
  std::string folder;
  Part part;
  int threads = 1;
};

// lives[rate][seed][policy].
using Lives = std::vector<std::vector<std::vector<Life>>>;

// The lives as work for a folder (run_folder.h), each a run and a unit of its
// own; the journal is journal.txt, and lives of other settings stay in it. The
// campaign must outlive it.
experiment::Work WorkOf(const Campaign& campaign);

// Of a folder that has them all.
absl::StatusOr<Lives> ReadLives(const Campaign& campaign,
                                const experiment::RunFolder& folder);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_CAMPAIGN_H_
