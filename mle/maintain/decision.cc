#include "mle/maintain/decision.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace mle {

std::string_view NameOf(Decision decision) {
  switch (decision) {
    case Decision::kNoChange:
      return "no_change";
    case Decision::kCorrected:
      return "corrected";
    case Decision::kRefused:
      return "refused";
  }
  return "";
}

absl::Status DecisionOptions::Validate() const {
  if (!(least_gain >= 0.0) || !std::isfinite(least_gain)) {
    return absl::InvalidArgumentError(
        absl::StrCat("decision.least_gain = ", least_gain,
                     ": it must be finite and not negative"));
  }
  return absl::OkStatus();
}

Verdict Decide(const Evidence& evidence, const DecisionOptions& options) {
  Verdict verdict;
  const std::string p =
      absl::StrFormat("p = %.2g for no change", evidence.p_value);
  if (!evidence.change_proposed) {
    verdict.reasons.push_back({MessageCode::kNoChangeFound,
                               "",
                               absl::StrCat("The records do not contradict the "
                                            "model (",
                                            p, ")."),
                               {}});
    return verdict;
  }
  verdict.reasons.push_back(
      {MessageCode::kChangeProved,
       "",
       absl::StrCat("The records contradict the model (", p, ")."),
       {}});
  if (!evidence.held_out_gain.has_value()) {
    verdict.decision =
        options.require_hold_out ? Decision::kRefused : Decision::kCorrected;
    verdict.reasons.push_back(
        {MessageCode::kNothingHeldOut,
         "",
         "No data could be held out to validate the correction.",
         {}});
    return verdict;
  }
  const double gain = *evidence.held_out_gain;
  const bool better = gain > options.least_gain;
  verdict.decision = better ? Decision::kCorrected : Decision::kRefused;
  verdict.reasons.push_back(
      {better ? MessageCode::kPredictsBetter : MessageCode::kPredictsWorse,
       "",
       absl::StrFormat(
           "Where records were held out the corrected model changes "
           "the log-likelihood by %.4g; more than %.4g is asked "
           "for.",
           gain, options.least_gain),
       {}});
  return verdict;
}

}  // namespace mle
