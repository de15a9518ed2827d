// The decision: whether the model in the controller is to be replaced.
//
//   evidence                                              decision
//   no change proposed                                    kNoChange
//   a change, no data could be held out                   kRefused
//   a change, log-likelihood gain ≤ least_gain somewhere  kRefused
//   a change, a larger gain in every way of holding out   kCorrected
//
// One function decides, for every estimator, command and study.

#ifndef MLE_MAINTAIN_DECISION_H_
#define MLE_MAINTAIN_DECISION_H_

#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "mle/maintain/message.h"

namespace mle {

enum class Decision {
  kNoChange,   // the records do not contradict the model
  kCorrected,  // they do, and the correction is what was written
  kRefused,    // they do, but the correction is not validated: initial model
};

// "no_change", "corrected", "refused".
std::string_view NameOf(Decision decision);

struct DecisionOptions {
  // A correction must raise the log-likelihood of what is held out by more
  // than this, in every way of holding out that is possible; ≥ 0.
  double least_gain = 0.0;
  // A correction that no data could be held out from is refused. If not, it is
  // taken as it is.
  bool require_hold_out = true;

  absl::Status Validate() const;
};

struct Evidence {
  bool change_proposed = false;
  double p_value = 1.0;  // of no change
  // The least gain in log-likelihood of all ways of holding out; nothing where
  // none was possible (hold_out.h).
  std::optional<double> held_out_gain;
};

struct Verdict {
  Decision decision = Decision::kNoChange;
  std::vector<Message> reasons;  // the one that decided last
};

Verdict Decide(const Evidence& evidence, const DecisionOptions& options);

}  // namespace mle

#endif  // MLE_MAINTAIN_DECISION_H_
