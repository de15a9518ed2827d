// A transform of a channel: a static, strictly increasing curve between its
// engineering value x and the variable z in which the elements of a model are
// linear (of inputs a Hammerstein, of outputs a Wiener model),
//
//   z = T(x) = a + (f(x) − f(a)) / f'(a).
//
// At the operating point a, z is x and the slope is 1: the elements are the
// model at a, gains in engineering units. f is
//
//   exponential         e^{c x}, c ≠ 0
//   equal percentage    the same, c = ln R / (h − l): a valve of rangeability
//                       R > 1 whose input is l closed and h open
//   logarithm           ln|x − x₀|, x and a on the same side of x₀
//   power               |x − x₀|^n, n ≠ 0, x and a on the same side of x₀
//   quick opening       the same, n = 1/2, x₀ = l: a valve closed at l
//   sinh                sinh c (x − a), c > 0; arsinh c (x − a), c < 0
//   tanh                artanh c (x − a), c > 0 and |x − a| < 1/c;
//                       tanh c (x − a), c < 0
//   piecewise linear    through points, straight on beyond the first and last
//
// Source: Hammerstein and Wiener models: Haber and Unbehauen, Automatica 26,
// 1990; characteristics of valves: IEC 60534-2-4.

#ifndef MLE_MODEL_TRANSFORM_H_
#define MLE_MODEL_TRANSFORM_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace mle {

enum class TransformKind {
  kNone,
  kExponential,
  kEqualPercentage,
  kLogarithm,
  kPower,
  kQuickOpening,
  kSinh,
  kTanh,
  kPiecewiseLinear,
};

struct Transform {
  TransformKind kind = TransformKind::kNone;
  double at = 0.0;            // a
  double curvature = 0.0;     // c, in 1/unit
  double rangeability = 0.0;  // R
  double low = 0.0;           // l
  double high = 0.0;          // h
  double zero = 0.0;          // x₀, of logarithms and powers
  double exponent = 0.0;      // n
  std::vector<std::pair<double, double>> points = {};  // (x, f), both rising

  bool IsNone() const { return kind == TransformKind::kNone; }
  // The constraint that is broken.
  absl::Status Validate() const;

  // z of x; NaN where x has none.
  double Linear(double x) const;
  // x of z; NaN where z has none.
  double Engineering(double z) const;
  // dz/dx at x > 0; NaN where x has no z.
  double Slope(double x) const;
  // Whether x has a z.
  bool Holds(double x) const;

  // "equal percentage, rangeability 50", for reports.
  std::string Description() const;

  bool operator==(const Transform& other) const = default;
};

}  // namespace mle

#endif  // MLE_MODEL_TRANSFORM_H_
