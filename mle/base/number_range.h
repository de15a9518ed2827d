// The range of a number that comes from outside: a flag, a key of a file.
//
//   constexpr NumberRange kProbability{.min = 0.0, .max = 1.0,
//                                      .open_min = true, .open_max = true};
//   kProbability.Contains(1.0)   // false
//   kProbability.Describe()      // "in (0, 1)"

#ifndef MLE_BASE_NUMBER_RANGE_H_
#define MLE_BASE_NUMBER_RANGE_H_

#include <limits>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace mle {

// Bounds are inclusive unless marked open.
struct NumberRange {
  double min = std::numeric_limits<double>::lowest();
  double max = std::numeric_limits<double>::max();
  bool open_min = false;
  bool open_max = false;
  bool infinite = false;  // ∞ belongs to it, where there is no upper bound

  // False for what is not a number.
  bool Contains(double value) const;
  // "> 0", "≥ 1", "≤ 5", "in (0, 1]"; empty where every number will do.
  std::string Describe() const;
};

inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{.min = 0.0, .open_min = true};
inline constexpr NumberRange kNotNegative{.min = 0.0};

constexpr NumberRange AtLeast(double min) { return {.min = min}; }
constexpr NumberRange Between(double min, double max) {
  return {.min = min, .max = max};
}

// Times between samples: beyond, one over them would be no number.
inline constexpr NumberRange kSampleTime = Between(1e-300, 1e300);

// InvalidArgument for what is not among them: "`name` is 0, must be positive".
absl::Status ValidateSampleTime(std::string_view name, double sample_time);

}  // namespace mle

#endif  // MLE_BASE_NUMBER_RANGE_H_
