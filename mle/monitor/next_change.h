// The change of a set point from which a watch would learn most, where its
// evidence is short.
//
// An element is in question, with a change δ of one of its parameters a:
//
//   likely    of the output with the least health, below 0.9, what explains its
//             evidence best (ExplainEvidence()), unless an alarm has named an
//             element of that output;
//   unseen    without such an output, the element of which the least would be
//             known if its gain had changed by δ = 10 % 30 batches ago
//             (OwnInformation()), where that would have raised no alarm yet;
//   baseline  where too little is known of that element's gain from before, so
//             that no later evidence could tell a change from what the model
//             was off at the start: the same change, after the batches
//             proposed.
//
// A candidate is a batch in which the set point of output i moves by Δ, stays
// until the plant has settled, and comes back. The manipulated inputs are taken
// to go at once to where they hold the outputs there,
//
//   Δu = K⁺ e_i Δ,   K the model's static gains,
//
// which is what can be said of a controller whose tuning is not known: how
// fast it moves them matters little to gains, more to dead times. Δ is such
// that the output and every input move by the width of their usual range in the
// reference at most. Of the candidates that after which OwnInformation() of a
// is largest is proposed.
//
// The evidence expected after k such batches is computed by the watch itself:
// ln E of the element by ConfirmedEvidenceOf() after k more batches with the
// informations I of ModelWatch::ExpectedInformation() and, for scores, their
// means I (θ + δ e_a), θ as estimated before the change began (unseen: 0, and
// of the batches so far their means too; baseline: without δ, and then k more
// with it). `changes` is the least k that raises the element's alarm then; Δ is
// reduced, by half at most twice, as long as two batches suffice. It is an
// expectation: scores scatter about their means, and other changes of set
// points bring evidence too.
//
//   MLE_ASSIGN_OR_RETURN(const NextChange next,
//                        FindNextChange(watch, reference, scored, options));
//   if (next.state == NextChange::State::kPropose) …

#ifndef MLE_MONITOR_NEXT_CHANGE_H_
#define MLE_MONITOR_NEXT_CHANGE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/monitor/change_evidence.h"
#include "mle/monitor/model_watch.h"

namespace mle {

// The batches kept of an output, and the evidence after the last of them.
struct ScoredOutput {
  std::vector<ScoredBatch> batches;
  ChangeEvidence evidence;
};

struct NextChangeOptions {
  int last = 0;  // number of the last batch that was looked at, used or not
  // ε of the alarms, in (0, 1).
  double share_of_output = 0.025;
  double share_of_element = 0.025;
};

struct NextChange {
  enum class State {
    kEnough,    // no element is in question
    kNamed,     // an alarm has named an element
    kPropose,   // see what follows
    kNoneTells  // no change of one set point tells of the element in question
  };
  enum class Question { kLikely, kUnseen, kBaseline };
  State state = State::kEnough;
  // In question.
  Question question = Question::kUnseen;
  int output = 0;
  int element = 0;      // of those present in the row
  int parameter = 0;    // 0: gain, 1: time constant, 2: dead time
  double change = 0.0;  // δ: relative, or in units of s (ModelWatch::units())
  double log_evidence = 0.0;  // ln E of the element, now
  double log_alarm = 0.0;     // that raises its alarm
  // Proposed.
  int set_point = 0;  // the output whose set point moves
  double size = 0.0;  // Δ > 0, up or down, in the output's unit
  int changes = 0;    // k, each there and back
  // ln E of the element expected after k, of a baseline after the change too.
  double log_expected = 0.0;
};

// `outputs`: p, with evidence of all elements present where there are batches.
// InvalidArgument where the reference does not fit the model.
absl::StatusOr<NextChange> FindNextChange(
    const ModelWatch& watch, const WatchReference& reference,
    const std::vector<ScoredOutput>& outputs, const NextChangeOptions& options);

}  // namespace mle

#endif  // MLE_MONITOR_NEXT_CHANGE_H_
