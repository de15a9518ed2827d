// What to do with the result: the controller's tuning, where more records are
// needed, and which inputs alone a step test would have to move.

#ifndef APPS_CORRECT_ADVICE_H_
#define APPS_CORRECT_ADVICE_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// How well the records determine the gain of a pair: of the fit with all
// elements free.
enum class PairInformation {
  kAbsent,  // zero in the model
  kNone,    // the input does not move
  kWeak,    // standard error of the gain above kWeakGainError of it
  kInformed,
};

inline constexpr double kWeakGainError = 0.2;
inline constexpr double kWantedGainError = 0.1;

std::string_view NameOf(PairInformation information);

// Standard error of the gain, relative to the larger of old and new gain;
// infinite where the records do not determine it.
double RelativeGainError(const ElementEstimate& estimate);
PairInformation InformationOf(const ElementEstimate& estimate);

// "overhead ← reflux"
std::string PairName(const ProcessModel& model, int output, int input);

// The controller's horizons, weights and stability; empty where nothing was
// corrected.
Tuning AdviseTuning(const Result& result);

// Items, most urgent first. `result` is complete but for advice.
std::vector<std::string> Advise(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_ADVICE_H_
