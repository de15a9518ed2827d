// All requested lives: every policy, at every rate of ageing, with every seed.
// Lives with the same rate and seed have set points, noise, disturbances and
// plant in common.

#ifndef APPS_LIFECYCLE_CAMPAIGN_H_
#define APPS_LIFECYCLE_CAMPAIGN_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/experiment/run_folder.h"
#include "apps/lifecycle/life.h"
#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/scenario.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"

namespace mle::lifecycle {

// Names and values of all that a life depends on, but for its policy, rate of
// ageing and seed.
using Settings = std::map<std::string, std::string>;

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

// `folder` has them all.
absl::StatusOr<Lives> ReadLives(const Campaign& campaign,
                                const experiment::RunFolder& folder);

// Lives as lines of a journal (apps/experiment/run_folder.h), so that an
// interrupted run can be resumed: the whole life of one policy, what it was
// worth in physical terms and no prices, so that other prices need no new
// simulation.
//
//   output_error:3,1,2,0123456789abcdef,{"ended": "", "rows": […]}
//
// The line begins with the policy, the rate of ageing, the seed and the first
// 16 digits of the SHA-256 of the settings.

struct LifeKey {
  std::string policy;
  double ageing_rate = 1.0;
  std::uint64_t seed = 1;

  // The start of the life's line.
  std::string LineStart(const Settings& settings) const;
};

std::string FormatLife(const std::string& line_start, const Life& life);

// The life in a line. DataLoss for another text.
absl::StatusOr<Life> ParseLife(std::string_view line);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_CAMPAIGN_H_
