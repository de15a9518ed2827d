#include "mle/model/transform.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Beyond these double precision holds no curve.
constexpr double kMostExponent = 100.0;
constexpr double kMostRangeability = 1e6;
constexpr double kMostSlope = 1e100;  // of f, or curvature; least: 1/it

bool IsValue(double x) { return std::abs(x) <= kLargestSample; }

bool IsSlope(double x) {
  return std::abs(x) >= 1.0 / kMostSlope && std::abs(x) <= kMostSlope;
}

absl::Status CheckValue(const char* name, double x) {
  if (IsValue(x)) return absl::OkStatus();
  return InvalidArgument(name, " = ", x, " is beyond ±", kLargestSample);
}

// c of the two kinds that are exponentials.
double CurvatureOf(const Transform& transform) {
  return transform.kind == TransformKind::kExponential
             ? transform.curvature
             : std::log(transform.rangeability) /
                   (transform.high - transform.low);
}

double ExponentOf(const Transform& transform) {
  return transform.kind == TransformKind::kQuickOpening ? 0.5
                                                        : transform.exponent;
}

// x₀ of logarithms and powers.
double ZeroOf(const Transform& transform) {
  return transform.kind == TransformKind::kQuickOpening ? transform.low
                                                        : transform.zero;
}

// The functions of the S shapes, for c > 0 and below.
double Sinh(double c, double cx) {
  return c > 0.0 ? std::sinh(cx) : std::asinh(cx);
}
double Tanh(double c, double cx) {
  return c > 0.0 ? std::atanh(cx) : std::tanh(cx);
}

// The segment that holds `value` (of x: first, of f: second), the outer ones
// beyond the ends; at a knot the one to the right.
template <double std::pair<double, double>::*kField>
std::size_t SegmentOf(const std::vector<std::pair<double, double>>& points,
                      double value) {
  std::size_t segment = 0;
  while (segment + 2 < points.size() && value >= points[segment + 1].*kField) {
    ++segment;
  }
  return segment;
}

double SlopeOf(const std::vector<std::pair<double, double>>& points,
               std::size_t segment) {
  return (points[segment + 1].second - points[segment].second) /
         (points[segment + 1].first - points[segment].first);
}

// f(x) of a piecewise-linear transform.
double Interpolated(const std::vector<std::pair<double, double>>& points,
                    double x) {
  const std::size_t s = SegmentOf<&std::pair<double, double>::first>(points, x);
  return points[s].second + SlopeOf(points, s) * (x - points[s].first);
}

double SlopeAt(const std::vector<std::pair<double, double>>& points, double x) {
  return SlopeOf(points,
                 SegmentOf<&std::pair<double, double>::first>(points, x));
}

absl::Status CheckPoints(const Transform& transform) {
  const auto& points = transform.points;
  if (points.size() < 2) {
    return InvalidArgument("points has ", points.size(),
                           ", a curve needs at least 2");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!IsValue(points[i].first) || !IsValue(points[i].second)) {
      return InvalidArgument("points[", i, "] is beyond ±", kLargestSample);
    }
    if (i == 0) continue;
    const auto& [x, f] = points[i];
    const auto& [x_before, f_before] = points[i - 1];
    if (!(x > x_before) || !(f > f_before)) {
      return InvalidArgument(
          "points[", i, "] = [", x, ", ", f, "] after [", x_before, ", ",
          f_before,
          "]: both numbers must rise from point to point (a curve "
          "that falls is a negative gain of the elements)");
    }
    if (!IsSlope(SlopeOf(points, i - 1))) {
      return InvalidArgument("points[", i, "] = [", x, ", ", f, "] after [",
                             x_before, ", ", f_before,
                             "]: too steep or too flat to compute with");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckCharacteristic(const Transform& transform) {
  if (!(transform.high > transform.low) || !IsValue(transform.high) ||
      !IsValue(transform.low)) {
    return InvalidArgument(
        "closed at ", transform.low, " and open at ", transform.high,
        ": open must be above closed, both within ±", kLargestSample);
  }
  if (transform.kind != TransformKind::kEqualPercentage) {
    return absl::OkStatus();
  }
  if (!(transform.rangeability > 1.0) ||
      transform.rangeability > kMostRangeability) {
    return InvalidArgument("rangeability = ", transform.rangeability,
                           ": it must be above 1, ", kMostRangeability,
                           " at most");
  }
  if (!IsSlope(CurvatureOf(transform))) {
    return InvalidArgument("closed at ", transform.low, " and open at ",
                           transform.high, ": too near to compute with");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Transform::Validate() const {
  if (IsNone()) return absl::OkStatus();
  MLE_RETURN_IF_ERROR(CheckValue("at", at));
  MLE_RETURN_IF_ERROR(CheckValue("zero", zero));
  switch (kind) {
    case TransformKind::kExponential:
    case TransformKind::kSinh:
    case TransformKind::kTanh:
      if (!IsSlope(curvature)) {
        return InvalidArgument("curvature = ", curvature,
                               ": it must not be 0, from ", 1.0 / kMostSlope,
                               " to ", kMostSlope, " or as much below 0");
      }
      break;
    case TransformKind::kEqualPercentage:
    case TransformKind::kQuickOpening:
      MLE_RETURN_IF_ERROR(CheckCharacteristic(*this));
      break;
    case TransformKind::kPower:
      if (!(std::abs(exponent) <= kMostExponent) || !IsSlope(exponent)) {
        return InvalidArgument("exponent = ", exponent,
                               ": it must not be 0, and from -", kMostExponent,
                               " to ", kMostExponent);
      }
      break;
    case TransformKind::kPiecewiseLinear:
      return CheckPoints(*this);
    default:
      break;
  }
  if (!Holds(at)) {
    return InvalidArgument("at = ", at, ": it must not be at ", ZeroOf(*this),
                           ", where the transform has no value");
  }
  if (kind == TransformKind::kQuickOpening && !(at > low)) {
    return InvalidArgument("at = ", at, ": it must be above ", low,
                           ", where the valve is closed");
  }
  return absl::OkStatus();
}

bool Transform::Holds(double x) const {
  switch (kind) {
    case TransformKind::kLogarithm:
    case TransformKind::kPower:
    case TransformKind::kQuickOpening:
      return (x - ZeroOf(*this)) / (at - ZeroOf(*this)) > 0.0;
    case TransformKind::kTanh:
      return curvature < 0.0 ? !std::isnan(x)
                             : std::abs(curvature * (x - at)) < 1.0;
    default:
      return !std::isnan(x);
  }
}

double Transform::Linear(double x) const {
  if (!Holds(x)) return kNaN;
  switch (kind) {
    case TransformKind::kNone:
      return x;
    case TransformKind::kExponential:
    case TransformKind::kEqualPercentage: {
      const double c = CurvatureOf(*this);
      return at + std::expm1(c * (x - at)) / c;
    }
    case TransformKind::kLogarithm: {
      const double distance = at - zero;
      return at + distance * std::log1p((x - at) / distance);
    }
    case TransformKind::kPower:
    case TransformKind::kQuickOpening: {
      const double distance = at - ZeroOf(*this);
      const double n = ExponentOf(*this);
      return at +
             distance / n * std::expm1(n * std::log1p((x - at) / distance));
    }
    case TransformKind::kSinh:
      return at + Sinh(curvature, curvature * (x - at)) / curvature;
    case TransformKind::kTanh:
      return at + Tanh(curvature, curvature * (x - at)) / curvature;
    case TransformKind::kPiecewiseLinear:
      return at + (Interpolated(points, x) - Interpolated(points, at)) /
                      SlopeAt(points, at);
  }
  return kNaN;
}

double Transform::Engineering(double z) const {
  switch (kind) {
    case TransformKind::kNone:
      return z;
    case TransformKind::kExponential:
    case TransformKind::kEqualPercentage: {
      const double c = CurvatureOf(*this);
      return at + std::log1p(c * (z - at)) / c;
    }
    case TransformKind::kLogarithm: {
      const double distance = at - zero;
      return at + distance * std::expm1((z - at) / distance);
    }
    case TransformKind::kPower:
    case TransformKind::kQuickOpening: {
      const double distance = at - ZeroOf(*this);
      const double n = ExponentOf(*this);
      return at +
             distance * std::expm1(std::log1p(n * (z - at) / distance) / n);
    }
    // Their inverses have the other sign of c.
    case TransformKind::kSinh:
      return at + Sinh(-curvature, curvature * (z - at)) / curvature;
    case TransformKind::kTanh:
      return at + Tanh(-curvature, curvature * (z - at)) / curvature;
    case TransformKind::kPiecewiseLinear: {
      const double f =
          Interpolated(points, at) + (z - at) * SlopeAt(points, at);
      const std::size_t s =
          SegmentOf<&std::pair<double, double>::second>(points, f);
      return points[s].first + (f - points[s].second) / SlopeOf(points, s);
    }
  }
  return kNaN;
}

double Transform::Slope(double x) const {
  if (!Holds(x)) return kNaN;
  switch (kind) {
    case TransformKind::kNone:
      return 1.0;
    case TransformKind::kExponential:
    case TransformKind::kEqualPercentage:
      return std::exp(CurvatureOf(*this) * (x - at));
    case TransformKind::kLogarithm:
      return (at - zero) / (x - zero);
    case TransformKind::kPower:
    case TransformKind::kQuickOpening:
      return std::pow((x - ZeroOf(*this)) / (at - ZeroOf(*this)),
                      ExponentOf(*this) - 1.0);
    case TransformKind::kSinh: {
      const double cx = curvature * (x - at);
      return curvature > 0.0 ? std::cosh(cx) : 1.0 / std::sqrt(1.0 + cx * cx);
    }
    case TransformKind::kTanh: {
      const double cx = curvature * (x - at);
      const double tanh = std::tanh(cx);
      return curvature > 0.0 ? 1.0 / (1.0 - cx * cx) : 1.0 - tanh * tanh;
    }
    case TransformKind::kPiecewiseLinear:
      return SlopeAt(points, x) / SlopeAt(points, at);
  }
  return kNaN;
}

std::string Transform::Description() const {
  switch (kind) {
    case TransformKind::kNone:
      return "none";
    case TransformKind::kExponential:
      return absl::StrFormat("exponential, curvature %.4g", curvature);
    case TransformKind::kEqualPercentage:
      return absl::StrFormat("equal percentage, rangeability %.4g",
                             rangeability);
    case TransformKind::kLogarithm:
      return zero == 0.0 ? std::string("logarithm")
                         : absl::StrFormat("logarithm from %.4g", zero);
    case TransformKind::kPower:
      return zero == 0.0
                 ? absl::StrFormat("power %.4g", exponent)
                 : absl::StrFormat("power %.4g from %.4g", exponent, zero);
    case TransformKind::kQuickOpening:
      return absl::StrFormat("quick opening from %.4g", low);
    case TransformKind::kSinh:
      return absl::StrFormat("sinh, curvature %.4g", curvature);
    case TransformKind::kTanh:
      return absl::StrFormat("tanh, curvature %.4g", curvature);
    case TransformKind::kPiecewiseLinear:
      return absl::StrCat("piecewise linear, ", points.size(), " points");
  }
  return "";
}

}  // namespace mle
