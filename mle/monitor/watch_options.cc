#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/monitor/change_evidence.h"

namespace mle {
namespace {

absl::Status Check(const char* name, double value, bool holds,
                   const char* wanted) {
  if (holds) return absl::OkStatus();
  return OptionError(name,
                     absl::StrCat(name, " = ", value, ": it must be ", wanted));
}

}  // namespace

absl::Status WatchOptions::Validate() const {
  absl::Status status =
      Check("level", level, level > 0.0 && level < 1.0, "in (0, 1)");
  status.Update(Check("life", life, life >= 64, "at least 64 batches"));
  status.Update(Check("least_change", least_change,
                      least_change >= 0.0 && least_change < 0.5,
                      "in [0, 0.5)"));
  status.Update(Check("model_error", model_error,
                      model_error > 0.0 && model_error <= 10.0, "in (0, 10]"));
  status.Update(Check("change_deviation", change_deviation,
                      change_deviation > 0.0 && change_deviation <= 10.0,
                      "in (0, 10]"));
  status.Update(
      Check("clip", clip, clip >= 2.0 && clip <= 1e6, "from 2 to 1e6"));
  status.Update(Check("disturbed", disturbed,
                      disturbed > 1.0 && disturbed <= 1e6, "in (1, 1e6]"));
  return status;
}

}  // namespace mle
