#include "mle/maintain/message.h"

namespace mle {

std::string_view NameOf(MessageCode code) {
  switch (code) {
    case MessageCode::kImport:
      return "import";
    case MessageCode::kChannel:
      return "channel";
    case MessageCode::kSamplesMarked:
      return "samples_marked";
    case MessageCode::kWindows:
      return "windows";
    case MessageCode::kWindowDropped:
      return "window_dropped";
    case MessageCode::kWindowCut:
      return "window_cut";
    case MessageCode::kWindowNotAtRest:
      return "window_not_at_rest";
    case MessageCode::kUnmeasured:
      return "unmeasured_disturbance";
    case MessageCode::kOptimumLoose:
      return "optimum_loose";
    case MessageCode::kAtBound:
      return "at_bound";
    case MessageCode::kRankDeficient:
      return "rank_deficient";
    case MessageCode::kPoorFopdt:
      return "poor_fopdt";
    case MessageCode::kHoldOutMissing:
      return "hold_out_missing";
    case MessageCode::kFitFailed:
      return "fit_failed";
    case MessageCode::kNotExact:
      return "not_exact";
    case MessageCode::kUnstable:
      return "unstable";
    case MessageCode::kNoChangeFound:
      return "no_change_found";
    case MessageCode::kChangeProved:
      return "change_proved";
    case MessageCode::kPredictsBetter:
      return "predicts_better";
    case MessageCode::kPredictsWorse:
      return "predicts_worse";
    case MessageCode::kNothingHeldOut:
      return "nothing_held_out";
  }
  return "";
}

}  // namespace mle
