// Ways of keeping the model of a controller up to date.
//
//   never          the model of the commissioning for ever
//   perfect        the plant's own model at every change, a bound for this
//                  controller
//   output_error:N, arx:N
//                  corrected from routine records after every N-th set-point
//                  change (1 if not given) by that estimator
//   test:M         a step test every M months (a twelfth of a year)
//   on_demand:T    a step test whenever the performance index of a change
//                  (performance.h) is below T

#ifndef APPS_LIFECYCLE_POLICY_H_
#define APPS_LIFECYCLE_POLICY_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/maintain/estimation.h"

namespace mle::lifecycle {

struct Policy {
  enum class Kind { kNever, kPerfect, kCorrection, kTest, kOnDemand };
  Kind kind = Kind::kNever;
  Estimator estimator = Estimator::kOutputError;
  int every = 1;           // kCorrection: changes, ≥ 1
  double months = 0.0;     // kTest, > 0
  double threshold = 0.0;  // kOnDemand, in (0, 1)
  std::string name;        // as it is shown: "output_error:3"

  bool tests() const { return kind == Kind::kTest || kind == Kind::kOnDemand; }
  // "output_error", "test", …
  std::string family() const { return name.substr(0, name.find(':')); }
};

// A comma-separated list. InvalidArgument names the part that is wrong or
// is duplicated, and what is known.
absl::StatusOr<std::vector<Policy>> ParsePolicies(std::string_view text);

// The place of the first one of a kind, or the number of policies.
std::size_t PlaceOf(Policy::Kind kind, const std::vector<Policy>& policies);

// Policies in the words of those who run a plant.

// In tables and figures: "corrected every 3rd change".
std::string ShortName(const Policy& policy);

// As an instruction: "Correct the model after every 3rd set-point change".
std::string Instruction(const Policy& policy);

// Sentences that say what the policy does and when.
std::string Description(const Policy& policy);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_POLICY_H_
