// Lives as lines of a journal (apps/experiment/journal.h), so that an
// interrupted run can be resumed: the whole life of one policy, what it was
// worth in physical terms and no prices, so that other prices need no new
// simulation.
//
//   output_error:3,1,2,0123456789abcdef,{"ended": "", "rows": […]}
//
// The line begins with the policy, the rate of ageing, the seed and the first
// 16 digits of the SHA-256 of the settings.

#ifndef APPS_LIFECYCLE_STORE_H_
#define APPS_LIFECYCLE_STORE_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/lifecycle/life.h"

namespace mle::lifecycle {

// Names and values of all that a life depends on, but for these three:
using Settings = std::map<std::string, std::string>;

struct LifeKey {
  std::string policy;
  double ageing_rate = 1.0;
  std::uint64_t seed = 1;

  // What the line of the life begins with.
  std::string LineStart(const Settings& settings) const;
};

std::string FormatLife(const std::string& line_start, const Life& life);

// The life in a line. DataLoss for another text.
absl::StatusOr<Life> ParseLife(std::string_view line);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_STORE_H_
