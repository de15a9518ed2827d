// The decision: whether the model in the controller is to be replaced, output
// by output.
//
//   evidence about an output                            what is taken of it
// where set points or other instruments judge it:
//   the proposal explains as much, and holds            kProposal
//   ageing wins, and predicts held-out blocks better    kExplained
//   ageing wins, but predicts no better                 kNothing, doubtful
//   ageing wins, another explanation does as well       kNothing, doubtful
//   another explanation wins alone                      kNothing, doubtful
//   nothing wins, the proposal is not confirmed         kNothing, doubtful
//   the same, and it would have shown                   kNothing
//   nothing wins, much is left                          kNothing, doubtful
//
// elsewhere:
//   nothing proposed                                    kNothing
//   a finding forbids it (`doubts`)                     kNothing
//   proposed, nothing held out                          kNothing, doubtful
//   a score falls by more than chance                   kNothing, doubtful
//   a score of one window does                          kNothing, doubtful
//   no score gains by more than chance                  kNothing, doubtful
//   simulates worse than a constant                     kNothing, doubtful
//   one gains, none falls                               kProposal
//
//   evidence about the plant                            decision
//   the data forbid it (`obstacles`)                    kCannotTell
//   something is taken of some output                   kCorrected
//   some output is doubtful, or there are `doubts`      kCannotTell
//   the change proved is below `least_change`           kNoChange
//   nothing proposed, no pair informed                  kCannotTell
//   nothing proposed                                    kNoChange
//
// "By more than chance" is `deviations` standard errors (validation.h); of
// single windows it is what has the same probability in any of them
// (Bonferroni). One function decides, for every estimator, command and study.

#ifndef MLE_MAINTAIN_DECISION_H_
#define MLE_MAINTAIN_DECISION_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "mle/maintain/message.h"
#include "mle/maintain/validation.h"

namespace mle {

enum class Decision {
  kNoChange,    // the records agree with the model
  kCorrected,   // they do not, and the correction is validated
  kCannotTell,  // a disturbance, the data or too little excitation: see reasons
};

// "no_change", "corrected", "cannot_tell".
std::string_view NameOf(Decision decision);

struct DecisionOptions {
  // Standard errors that a score must gain, and may not fall, > 0.
  double deviations = 2.0;
  // A change of an element's step response, relative to its norm, up to which
  // it is not worth making, in [0, 1).
  double least_change = 0.02;
  // A correction that no data could be held out from is doubtful. If not, it is
  // taken as it is.
  bool require_hold_out = true;
  // By how much the time stamps of a tag may be late or early, in s, ≥ 0: a
  // change of dead time that all elements of a row or column share may be a
  // clock's up to this, or up to five samples, as scans and averages make them
  // late; beyond, the dead times have changed. 0: clocks are right.
  double clock_error = 120.0;

  absl::Status Validate() const;
};

enum class Acceptance {
  kNothing,
  kProposal,
  kExplained,  // gains, time constants and dead times by the instruments
};

// The result of the competition of explanations (mle/explain/competition.h) for
// an output, where there is a judge.
struct InstrumentEvidence {
  // If not, inputs stand for set points, which do not move.
  bool by_set_points = true;
  // Where inputs do: of the test that none of them answers the output.
  std::optional<double> feedback_p_value = std::nullopt;
  // Gains, time constants or dead times won.
  bool ageing = false;
  // Whole sentences on what else won, and on what would win as well; or empty.
  std::string other;
  std::string tie;
  MessageCode code = MessageCode::kExplained;  // of `other`
  // The estimate by likelihood explains what set points drive as well as what
  // won, and names the same elements or decides between those that tie.
  bool confirms_proposal = false;
  // It explains as much as what won; it is taken where it predicts better.
  bool allows_proposal = false;
  // The proposal would have shown in what set points drive, and has not.
  bool refutes_proposal = false;
  // On blocks held out: no error of a horizon grew beyond chance, and one fell;
  // with the errors in words.
  bool predicts_better = false;
  // The model in use is not the process model: the scores have to hold, too.
  bool another_in_use = false;
  std::string errors;
  // Of what won: the error of free simulation of blocks held out over that of
  // the model as it was.
  double simulated = 1.0;
  // E/N of what is left.
  double left = 0.0;
};

struct OutputEvidence {
  std::string name;
  bool proposed = false;
  // Where the output has a judge, it decides: nothing below counts but the
  // scores.
  std::optional<InstrumentEvidence> instruments;
  // One of Evidence::doubts is about it: nothing else counts.
  bool undecidable = false;
  // Nothing where nothing was held out.
  std::optional<OutputScores> scores;
  std::vector<OutputScores> windows;  // the same of each window
};

struct Evidence {
  bool change_proved = false;  // by the test of no change
  double p_value = 1.0;        // of it
  // Why the records determine no gain, and what would settle it; or empty.
  std::string uninformed;
  // The smallest change that they would have shown, in words; or empty.
  std::string detectable;
  std::string nothing_held_out;  // why
  std::vector<OutputEvidence> outputs;
  // Reasons in the data that forbid a correction of the undecidable outputs.
  std::vector<Message> doubts;
  // Reasons in the data that forbid any correction.
  std::vector<Message> obstacles;
};

struct Verdict {
  Decision decision = Decision::kNoChange;
  std::vector<Acceptance> outputs;  // as of the evidence
  // The one that decided first; then those about single outputs.
  std::vector<Message> reasons;
};

// By which no error of a horizon may grow.
inline constexpr double kWorse = 1.2;

// Whether errors on what was held out, over those of the model as it was, fall
// together (their geometric mean) and none of them grows to `worse` times.
bool FallTogether(const std::vector<double>& ratios, double worse = kWorse);

Verdict Decide(const Evidence& evidence, const DecisionOptions& options);

}  // namespace mle

#endif  // MLE_MAINTAIN_DECISION_H_
