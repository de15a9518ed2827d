// The table of explanations: what may have happened to plant, model or record
// where measurements and the controller's model differ.
//
// Each explanation changes one thing by one parameter θ. They compete
// (competition.h), and the one that wins is what a user is told. To add one:
// its row in explanation.cc, what it does to a response in explained_output.cc,
// and its test.

#ifndef MLE_EXPLAIN_EXPLANATION_H_
#define MLE_EXPLAIN_EXPLANATION_H_

#include <vector>

namespace mle {

enum class ExplanationKind {
  // Ageing of an element.
  kGain,          // K e^θ
  kTimeConstant,  // T e^θ
  kDeadTime,      // L + θ (T + L)
  // Another structure of an element.
  kHigherOrder,  // a second lag θ (T + L); T and L lose half of it each
  kLead,         // times 1 + θ (T + L) s, with a second lag of min(|θ|, 0.2)
                 // (T + L) where there is none
  kNewPath,    // of an input without an element: K = θ w / the input's range,
               // T = 3ᵖ⁻¹ τ, p as of Explanation::part, L = 0
  kDirection,  // time constant T e^θ where the response falls
  kReversed,   // −K e^θ
  kChangeDuringRecord,  // K (1 + θ s), s as of Explanation::part
  // Effects at an output; z is the model's output from where it began, w its
  // range.
  kOutputClock,     // every L + θ τ/2, τ the median of T + L in the row
  kCurvedOutput,    // h(z), c = θ/w (curves.h), its shape as of
                    // Explanation::part
  kAveragedOutput,  // the mean of z over θ τ before each sample
  // Effects at an input; v is the input from where it began, w its range.
  kCurvedInput,  // h(v), c = θ/max |v| (curves.h)
  kRateLimit,    // moves by w e^{−θ}/τ a time unit at most
  kBacklash,     // follows only beyond a gap θ w
  kSaturation,   // the highest (θ > 0) or lowest |θ| w are not reached
  kInputClock,   // every L of the input + θ τ/2; of several outputs together
  kLoadWithSetPoints,  // v + θ w s, s as of Explanation::part, behind all else
};

enum class ExplanationPlace { kElement, kOutput, kInput };

struct ExplanationType {
  ExplanationKind kind;
  // As in result.json.
  const char* code;
  ExplanationPlace place;
  // Improbability before the records: what it has to explain beyond a change of
  // a gain, as a share of what disturbances alone explain (competition.h), of
  // instruments that are not in parts.
  double improbability;
  // θ to begin from, and its bounds.
  std::vector<double> start;
  double lower;
  double upper;
  // Sentences for users: what happened to %s, and what would settle it.
  const char* sentence;
  const char* settled_by;
};

const std::vector<ExplanationType>& ExplanationTable();
const ExplanationType& TypeOf(ExplanationKind kind);

// Gain, time constant and dead time.
bool IsAgeing(ExplanationKind kind);
// Another order, a lead, a new path: of an element that has aged or not.
bool IsShape(ExplanationKind kind);
// An output or an input is curved.
bool IsCurve(ExplanationKind kind);
// What the elements of a corrected model can hold: ageing or another shape.
bool IsHeld(ExplanationKind kind);

// Shapes of a change during the record: 0, from 0 at the first sample to 1 at
// the last; 1 to 4, 1 in this quarter and 0 elsewhere; 5 to 7, 1 from the end
// of the first, second, third quarter on.
inline constexpr int kParts = 8;
// Time constants of a new path.
inline constexpr int kPathLags = 3;

// Of a change of this shape, what holds at a time (0: the first sample of the
// records, 1: the last), from 0 to 1.
double ShareOfChange(int part, double at);

// One of them, of an element (index: its input), an input, or the output.
struct Explanation {
  ExplanationKind kind = ExplanationKind::kGain;
  int index = 0;
  double value = 0.0;  // θ
  // Of kChangeDuringRecord, kNewPath, kCurvedOutput and kLoadWithSetPoints:
  // which of them.
  int part = 0;

  bool SameAs(const Explanation& other) const {
    return kind == other.kind && index == other.index;
  }
};

// Whether one of them is of the same kind and index.
bool Contains(const std::vector<Explanation>& explanations,
              const Explanation& one);

// θ of an explanation of this kind and index, 0 where there is none; whether it
// was `found`, and its `part`.
double ValueOf(const std::vector<Explanation>& explanations,
               ExplanationKind kind, int index, bool* found = nullptr,
               int* part = nullptr);

// −ln of how probable a change of this size is before the records, against one
// that is usual: of ageing (θ²/σ² − 1)/2 with σ = 0.6, at least 0 (a gain twice
// as large: 0.2; five times: 3.1); 0 of all else. That much more evidence is
// asked for.
double PriorCost(const Explanation& explanation);

// The factor by which the gain of an element has changed at the end of the
// records, beside any other; 1 where it did not change during them, or only for
// a time.
double GainAtEnd(const std::vector<Explanation>& explanations, int input);

}  // namespace mle

#endif  // MLE_EXPLAIN_EXPLANATION_H_
