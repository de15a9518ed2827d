// Whether a record has changed, not the plant: levels of several channels that
// jump from one sample to the next, as where two records are joined, or a unit,
// a range or a tag is exchanged. Internal to mle/monitor.
//
// An output jumps at sample k if what the model leaves of it, e = y − Σ g u,
// does: with the medians of five known samples on either side, and s its
// deviation (1.4826 median |Δe| / √2, `least` at least),
//
//   |e_k − e_k−1| > 8 s and |median after − median before| > 8 s.
//
// Single outliers return. The record has changed where all of two outputs jump
// at one sample, or half of more; a single output where an input moves at the
// very sample, which can act later only.

#ifndef MLE_MONITOR_RECORD_JUMP_H_
#define MLE_MONITOR_RECORD_JUMP_H_

#include <optional>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// The first sample after the first such jump. `least` (p) > 0. Errors as of
// SimulateResponse().
absl::StatusOr<std::optional<int>> FindRecordJump(const ProcessModel& model,
                                                  const Record& record,
                                                  const Eigen::VectorXd& least);

}  // namespace mle

#endif  // MLE_MONITOR_RECORD_JUMP_H_
