// What a run says to its caller.
//
// Messages are data: the subject (code), the place (an output, a pair, a
// window, a file), the text, and the options that would change it. A command
// prints the options as its own flags. Findings are messages about records.
// Progress is passed to a callback, which may end the run.

#ifndef MLE_MAINTAIN_MESSAGE_H_
#define MLE_MAINTAIN_MESSAGE_H_

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace mle {

enum class MessageCode {
  // Records.
  kImport,           // what the import reports of the files
  kChannel,          // frozen, saturated, outlying, constant or quantised
  kSamplesMarked,    // samples taken as bad
  kWindows,          // how windows were found
  kWindowDropped,    // inputs are missing around the set-point change
  kWindowCut,        // to its longest part without missing inputs
  kWindowNotAtRest,  // a drift or a step where there should be none
  kUnmeasured,       // a burst too long to be outliers
  // Records, examined before a fit (examine_records.h).
  kCompressed,   // interpolated or held by the historian
  kInputSpikes,  // single samples that no controller asked for
  kStuckOutput,  // a dead, clipped or frozen sensor
  kInputLimits,  // time at the limits of an input
  kSplitMoves,   // moves of an input between samples
  kSampling,     // samples per time constant
  kManyMoves,    // of a set point, by an optimiser
  kClock,        // time stamps of a tag that are early or late
  kMistake,      // of an operator: tags, signs, units
  kSticking,     // an input that the plant does not follow where it turns back
  // Fits.
  kOptimumLoose,   // the gradient at the optimum is not small
  kAtBound,        // a parameter lies at the bound of what is searched
  kRankDeficient,  // the records do not determine every parameter
  kPoorFopdt,      // a first-order element with dead time describes it badly
  kArxInexact,     // the ARX model is not what the process model is
  kNoStateSpace,   // no state-space model is near enough
  // The result is not usable.
  kFitFailed,
  kNotExact,  // a duality gap above the accepted one
  kUnstable,
  // Reasons of a decision.
  kNoChangeFound,       // the records do not contradict the model
  kChangeProved,        // they do
  kPredictsBetter,      // the corrected model, where records were held out
  kPredictsWorse,       // the same
  kNotBetter,           // neither by more than chance
  kNothingHeldOut,      // the correction could not be validated
  kWindowsDisagree,     // parts of the records want different gains
  kStructureDoubtful,   // it does not explain the records
  kCurved,              // a gain follows the position of an input, or a level
  kExplained,           // something else than ageing explains the records
  kMissingExplanation,  // set points drive what nothing known explains
  kNotConfirmed,        // a change that set points do not confirm
  kSetPointsAgree,      // what set points drive shows no change
  kChangeTooSmall,      // a change is proved, but not worth making
  kNotExcited,          // the records determine no gain
};

// "at_bound", as in result.json.
std::string_view NameOf(MessageCode code);

struct Message {
  MessageCode code;
  std::string place;                 // empty: the whole run
  std::string text;                  // a whole sentence
  std::vector<std::string> options;  // names of fields that would change it
};

enum class Consequence {
  kNote,    // of none
  kRepair,  // the samples concerned are marked as bad, or replaced
  kDoubts,  // nothing can be said of some outputs
  kBlocks,  // nothing can be said of the plant from these records
};

// "note", "repair", "doubts", "blocks".
std::string_view NameOf(Consequence consequence);

struct Finding {
  Message message;  // place: the tag, or empty
  Consequence consequence = Consequence::kNote;
  // Times of the first and the last sample concerned.
  double from = 0.0;
  double to = 0.0;
  // The size of the finding: a share, a factor, a time, a width, a number of
  // samples.
  double value = 0.0;
  // kDoubts: of which nothing can be said.
  std::vector<int> outputs;
};

// Null if none blocks.
const Finding* FirstBlocking(const std::vector<Finding>& findings);

struct RunProgress {
  std::string stage;      // "fitting 4 windows"
  double fraction = 0.0;  // of the stage, in [0, 1]
};

// Called at the begin of each stage (fraction 0) and, where it has several
// parts, after each of them; one call at a time, on any thread. False ends the
// run with absl::CancelledError. May be empty.
using ProgressCallback = std::function<bool(const RunProgress& progress)>;

}  // namespace mle

#endif  // MLE_MAINTAIN_MESSAGE_H_
