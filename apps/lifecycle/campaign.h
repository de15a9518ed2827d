// All requested lives: every policy, at every rate of ageing, with
// every seed. Lives with the same rate and seed have set points, noise,
// disturbances and plant in common.

#ifndef APPS_LIFECYCLE_CAMPAIGN_H_
#define APPS_LIFECYCLE_CAMPAIGN_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/common/progress.h"
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

// Makes the lives that the folder does not hold (run_folder.h), each a run of a
// unit of its own; its journal is journal.txt. Cancelled where `stop` says so:
// what is made is kept. `told` is called with the lives made and all of them.
// Both are called by the caller's thread. Of a part, the lives are none.
absl::StatusOr<Lives> RunCampaign(const Campaign& campaign,
                                  const std::function<bool()>& stop,
                                  const ProgressFunction& told);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_CAMPAIGN_H_
