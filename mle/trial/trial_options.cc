#include "mle/trial/trial_options.h"

#include "mle/base/status.h"

namespace mle {

absl::Status TrialOptions::Validate() const {
  if (!(level > 0.0 && level < 1.0)) {
    return InvalidArgument("trial: level is ", level, "; it must be in (0, 1)");
  }
  if (!(left_share > 0.0)) {
    return InvalidArgument("trial: left_share is ", left_share,
                           "; it must be > 0");
  }
  if (least_changes < 2) {
    return InvalidArgument("trial: least_changes is ", least_changes,
                           "; it must be ≥ 2");
  }
  if (most_changes < least_changes) {
    return InvalidArgument("trial: most_changes is ", most_changes,
                           "; it must be ≥ least_changes (", least_changes,
                           ")");
  }
  return absl::OkStatus();
}

}  // namespace mle
