#include "mle/explain/explanation.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"

namespace mle {
namespace {

using Kind = ExplanationKind;
using Place = ExplanationPlace;

constexpr double kUsual = 0.0;
constexpr double kRarer = 0.6;
constexpr double kRare = 1.0;
constexpr double kRarest = 2.0;
// The standard deviation of θ of what has aged.
constexpr double kUsualAgeing = 0.6;

}  // namespace

const std::vector<ExplanationType>& ExplanationTable() {
  static const auto* const table = new std::vector<ExplanationType>{
      {Kind::kGain,
       "gain",
       Place::kElement,
       kUsual,
       {-1.2, -0.8, -0.4, -0.2, 0.2, 0.4, 0.8, 1.2},
       -2.3,
       2.3,
       "the gain of %s has changed",
       ""},
      {Kind::kTimeConstant,
       "time_constant",
       Place::kElement,
       kUsual,
       {-1.2, -0.8, -0.4, -0.2, 0.2, 0.4, 0.8, 1.2},
       -2.3,
       2.3,
       "the time constant of %s has changed",
       ""},
      {Kind::kDeadTime,
       "dead_time",
       Place::kElement,
       kUsual,
       {-0.6, -0.4, -0.2, -0.1, 0.1, 0.2, 0.4, 0.6, 0.9},
       -1.0,
       2.0,
       "the dead time of %s has changed",
       ""},
      {Kind::kHigherOrder,
       "higher_order",
       Place::kElement,
       kRarer,
       {0.1, 0.2, 0.4},
       0.0,
       0.8,
       "the response of %s has more than one lag",
       "A step test would show its shape."},
      {Kind::kLead,
       "lead",
       Place::kElement,
       kRarer,
       {-0.6, -0.3, 0.3, 0.6, 1.0},
       -2.0,
       3.0,
       "the response of %s has a lead, or begins the other way",
       "A step test would show its shape."},
      {Kind::kNewPath,
       "new_path",
       Place::kElement,
       kRare,
       {-0.5, 0.5},
       -3.0,
       3.0,
       "%s is a path that the model does not have",
       "A step of this input alone would settle it."},
      {Kind::kDirection,
       "direction",
       Place::kElement,
       kRarer,
       {-0.9, -0.6, -0.3, 0.3, 0.6, 0.9},
       -1.6,
       1.6,
       "%s responds at another speed downwards than upwards",
       "Set-point changes of the same size up and down would settle it."},
      {Kind::kReversed,
       "reversed",
       Place::kElement,
       kRare,
       {-0.7, 0.0, 0.7},
       -2.3,
       2.3,
       "%s acts in the opposite direction: compare the sign of its gain, or of "
       "its tags, with the controller's model",
       "The sign in the controller would settle it."},
      {Kind::kChangeDuringRecord,
       "change_during_record",
       Place::kElement,
       kRarer,
       {-0.6, -0.4, -0.2, 0.2, 0.4, 0.6},
       -1.5,
       3.0,
       "the gain of %s changed during the record",
       "A record from after the change would settle it."},
      {Kind::kOutputClock,
       "output_clock",
       Place::kOutput,
       kRarer,
       {-0.5, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.5},
       -2.0,
       2.0,
       "the time stamps of %s are early or late, or all its dead times have "
       "changed alike",
       "The clock and the averaging of its tag would settle it: declare its "
       "sampling (late_by, average) where they are known."},
      {Kind::kCurvedOutput,
       "curved_output",
       Place::kOutput,
       kRarer,
       {-1.5, -0.8, -0.4, 0.4, 0.8, 1.5},
       -8.0,
       4.0,
       "%s is not linear: its gains follow its own level",
       "Set-point changes around one level would settle it."},
      {Kind::kAveragedOutput,
       "averaged",
       Place::kOutput,
       kRarer,
       {0.1, 0.2, 0.4, 0.8},
       0.0,
       2.0,
       "the samples of %s are averages of faster ones",
       "Samples of the historian without averaging would settle it, or what "
       "they are means of: declare its sampling (average, stamp)."},
      {Kind::kCurvedInput,
       "curved_input",
       Place::kInput,
       kRarer,
       {-1.6, -0.8, -0.4, 0.4, 0.8, 1.6},
       -4.0,
       4.0,
       "the effect of %s is not linear: its gain follows its position",
       "Set-point changes around one position would settle it."},
      {Kind::kRateLimit,
       "rate_limit",
       Place::kInput,
       kRarer,
       {-2.0, -1.0, -0.3, 0.3, 1.0, 1.7, 2.4, 3.1},
       -3.0,
       5.0,
       "%s moves at a limited rate",
       "The measured position in place of the one asked for would settle it."},
      {Kind::kBacklash,
       "backlash",
       Place::kInput,
       kRarer,
       {0.05, 0.1, 0.2},
       0.0,
       0.5,
       "%s sticks or has backlash where it turns back",
       "The measured position in place of the one asked for would settle it."},
      {Kind::kSaturation,
       "saturation",
       Place::kInput,
       kRarer,
       {-0.9, -0.75, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.75, 0.9},
       -0.98,
       0.98,
       "%s reaches a limit that the record does not show",
       "The measured position in place of the one asked for would settle it."},
      {Kind::kInputClock,
       "input_clock",
       Place::kInput,
       kRarer,
       {-0.5, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.5},
       -2.0,
       2.0,
       "the time stamps of %s are early or late",
       "The clock of its tag would settle it: declare its sampling (late_by) "
       "where it is known."},
      {Kind::kLoadWithSetPoints,
       "load_with_set_points",
       Place::kInput,
       kRarest,
       {-1.0, 1.0},  // the response is linear in θ
       -3.0,
       3.0,
       "something that no record shows acts as %s does, whenever set points "
       "are moved",
       "A measurement of what was moved with the set points would settle it."},
  };
  return *table;
}

const ExplanationType& TypeOf(ExplanationKind kind) {
  for (const ExplanationType& type : ExplanationTable()) {
    if (type.kind == kind) return type;
  }
  LOG(FATAL) << "an explanation without a row in the table";
}

bool IsAgeing(ExplanationKind kind) {
  return kind == Kind::kGain || kind == Kind::kTimeConstant ||
         kind == Kind::kDeadTime;
}

bool IsShape(ExplanationKind kind) {
  return kind == Kind::kHigherOrder || kind == Kind::kLead ||
         kind == Kind::kNewPath;
}

bool IsCurve(ExplanationKind kind) {
  return kind == Kind::kCurvedOutput || kind == Kind::kCurvedInput;
}

bool IsHeld(ExplanationKind kind) { return IsAgeing(kind) || IsShape(kind); }

double ShareOfChange(int part, double at) {
  if (part == 0) return at;
  const double quarter = std::min(std::floor(4.0 * at), 3.0);
  if (part <= 4) return quarter == part - 1.0 ? 1.0 : 0.0;
  return quarter >= part - 4.0 ? 1.0 : 0.0;
}

bool Contains(const std::vector<Explanation>& explanations,
              const Explanation& one) {
  return std::any_of(explanations.begin(), explanations.end(),
                     [&](const Explanation& e) { return e.SameAs(one); });
}

double ValueOf(const std::vector<Explanation>& explanations,
               ExplanationKind kind, int index, bool* found, int* part) {
  for (const Explanation& explanation : explanations) {
    if (explanation.kind != kind || explanation.index != index) continue;
    if (found != nullptr) *found = true;
    if (part != nullptr) *part = explanation.part;
    return explanation.value;
  }
  return 0.0;
}

double PriorCost(const Explanation& explanation) {
  if (!IsAgeing(explanation.kind)) return 0.0;
  const double deviations = explanation.value / kUsualAgeing;
  return std::max(0.0, 0.5 * (deviations * deviations - 1.0));
}

double GainAtEnd(const std::vector<Explanation>& explanations, int input) {
  for (const Explanation& one : explanations) {
    if (one.kind == Kind::kChangeDuringRecord && one.index == input) {
      return 1.0 + one.value * ShareOfChange(one.part, 1.0);
    }
  }
  return 1.0;
}

}  // namespace mle
