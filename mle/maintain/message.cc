#include "mle/maintain/message.h"

#include <algorithm>

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
    case MessageCode::kCompressed:
      return "compressed";
    case MessageCode::kInputSpikes:
      return "input_spikes";
    case MessageCode::kStuckOutput:
      return "stuck_output";
    case MessageCode::kInputLimits:
      return "input_limits";
    case MessageCode::kSplitMoves:
      return "split_moves";
    case MessageCode::kSampling:
      return "sampling";
    case MessageCode::kManyMoves:
      return "many_set_point_moves";
    case MessageCode::kClock:
      return "clock";
    case MessageCode::kMistake:
      return "mistake";
    case MessageCode::kSticking:
      return "sticking_input";
    case MessageCode::kOptimumLoose:
      return "optimum_loose";
    case MessageCode::kAtBound:
      return "at_bound";
    case MessageCode::kRankDeficient:
      return "rank_deficient";
    case MessageCode::kPoorFopdt:
      return "poor_fopdt";
    case MessageCode::kArxInexact:
      return "arx_inexact";
    case MessageCode::kNoStateSpace:
      return "no_state_space";
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
    case MessageCode::kNotBetter:
      return "not_better";
    case MessageCode::kNothingHeldOut:
      return "nothing_held_out";
    case MessageCode::kWindowsDisagree:
      return "windows_disagree";
    case MessageCode::kStructureDoubtful:
      return "structure_doubtful";
    case MessageCode::kExplained:
      return "explained";
    case MessageCode::kCurved:
      return "curved";
    case MessageCode::kMissingExplanation:
      return "missing_explanation";
    case MessageCode::kNotConfirmed:
      return "not_confirmed";
    case MessageCode::kSetPointsAgree:
      return "set_points_agree";
    case MessageCode::kChangeTooSmall:
      return "change_too_small";
    case MessageCode::kNotExcited:
      return "not_excited";
  }
  return "";
}

std::string_view NameOf(Consequence consequence) {
  switch (consequence) {
    case Consequence::kNote:
      return "note";
    case Consequence::kRepair:
      return "repair";
    case Consequence::kDoubts:
      return "doubts";
    case Consequence::kBlocks:
      return "blocks";
  }
  return "";
}

const Finding* FirstBlocking(const std::vector<Finding>& findings) {
  const auto found = std::find_if(
      findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.consequence == Consequence::kBlocks;
      });
  return found == findings.end() ? nullptr : &*found;
}

}  // namespace mle
