#include "apps/lifecycle/policy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/did_you_mean.h"
#include "mle/base/status.h"

namespace mle::lifecycle {
namespace {

constexpr double kMaxChanges = 1e6;

absl::Status WrongPart(const std::string& part, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("'", part, "': ", why));
}

// What follows the colon; `none` where there is no colon.
absl::StatusOr<double> Argument(const std::string& part, double none) {
  const std::size_t colon = part.find(':');
  if (colon == std::string::npos) return none;
  double value = 0.0;
  if (!absl::SimpleAtod(part.substr(colon + 1), &value) ||
      !std::isfinite(value)) {
    return WrongPart(
        part, absl::StrCat("'", part.substr(colon + 1), "' is not a number"));
  }
  return value;
}

absl::StatusOr<Policy> ParseCorrection(const std::string& part,
                                       Estimator estimator) {
  Policy policy;
  policy.kind = Policy::Kind::kCorrection;
  policy.estimator = estimator;
  MLE_ASSIGN_OR_RETURN(const double every, Argument(part, 1.0));
  if (!(every >= 1.0) || every > kMaxChanges || every != std::floor(every)) {
    return WrongPart(part,
                     "after the colon a whole number of set-point changes "
                     "≥ 1 is needed");
  }
  policy.every = static_cast<int>(every);
  policy.name = absl::StrCat(std::string(NameOf(estimator)), ":", policy.every);
  return policy;
}

absl::StatusOr<Policy> ParsePolicy(const std::string& part) {
  const std::string kind = part.substr(0, part.find(':'));
  for (const auto estimator :
       {Estimator::kOutputError, Estimator::kCombined, Estimator::kArx}) {
    if (kind == NameOf(estimator)) {
      return ParseCorrection(part, estimator);
    }
  }
  Policy policy;
  policy.name = part;
  if (kind == "never" || kind == "perfect") {
    if (kind != part) return WrongPart(part, "takes no number");
    policy.kind =
        kind == "never" ? Policy::Kind::kNever : Policy::Kind::kPerfect;
    return policy;
  }
  if (kind == "test") {
    policy.kind = Policy::Kind::kTest;
    MLE_ASSIGN_OR_RETURN(policy.months, Argument(part, 0.0));
    if (policy.months > 0.0) return policy;
    return WrongPart(part,
                     "after a colon the months from test to test are needed, "
                     "> 0: test:12");
  }
  if (kind == "on_demand") {
    policy.kind = Policy::Kind::kOnDemand;
    MLE_ASSIGN_OR_RETURN(policy.threshold, Argument(part, 0.0));
    if (policy.threshold > 0.0 && policy.threshold < 1.0) return policy;
    return WrongPart(part,
                     "after a colon a threshold of the performance index "
                     "between 0 and 1 is needed: on_demand:0.7");
  }
  return WrongPart(
      part, absl::StrCat(
                DidYouMean(kind, {"never", "perfect", "output_error",
                                  "combined", "arx", "test", "on_demand"}),
                "known are never, perfect, output_error:N, combined:N, arx:N, "
                "test:MONTHS and on_demand:THRESHOLD"));
}

}  // namespace

absl::StatusOr<std::vector<Policy>> ParsePolicies(std::string_view text) {
  std::vector<Policy> policies;
  for (const std::string& part : ParseList(text)) {
    MLE_ASSIGN_OR_RETURN(Policy policy, ParsePolicy(part));
    const bool known =
        std::any_of(policies.begin(), policies.end(),
                    [&](const Policy& p) { return p.name == policy.name; });
    if (known) return WrongPart(part, "stands twice");
    policies.push_back(std::move(policy));
  }
  if (policies.empty()) {
    return absl::InvalidArgumentError("names no policy");
  }
  return policies;
}

}  // namespace mle::lifecycle
