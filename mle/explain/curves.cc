#include "mle/explain/curves.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"

namespace mle {
namespace {

// Points of a curve that no transform of its own has; between them it is
// straight.
constexpr int kPoints = 65;
// Beyond this, in x c, curves are straight to rounding.
constexpr double kStraight = 1e-9;

// Whether an inverse has the same shape, and the other sign of c.
bool IsOdd(CurveShape shape) {
  return shape == CurveShape::kSinh || shape == CurveShape::kTanh;
}

CurveShape InverseShape(CurveShape shape) {
  switch (shape) {
    case CurveShape::kExponential:
      return CurveShape::kLogarithm;
    case CurveShape::kLogarithm:
      return CurveShape::kExponential;
    case CurveShape::kQuadratic:
      return CurveShape::kRoot;
    case CurveShape::kRoot:
      return CurveShape::kQuadratic;
    default:
      return shape;
  }
}

// Of the second derivative at 0, of S shapes of the third, by c or c².
double BendOf(CurveShape shape) {
  switch (shape) {
    case CurveShape::kLogarithm:
    case CurveShape::kRoot:
      return -1.0;
    case CurveShape::kTanh:
      return 2.0;
    default:
      return 1.0;
  }
}

Transform Points(CurveShape shape, double c, const FoundCurve& curve) {
  Transform transform;
  transform.kind = TransformKind::kPiecewiseLinear;
  for (int i = 0; i < kPoints; ++i) {
    const double x = curve.low + (curve.high - curve.low) * i / (kPoints - 1.0);
    transform.points.emplace_back(x, curve.at + Bend(shape, c, x - curve.at));
  }
  return transform;
}

}  // namespace

double ShapeCost(int part) {
  return IsOdd(static_cast<CurveShape>(part)) ? 3.0 : 0.0;
}

CurveShape ShapeOf(const Explanation& explanation) {
  return static_cast<CurveShape>(explanation.part);
}

std::vector<int> ShapesOf(ExplanationKind kind) {
  const bool is_output = kind == ExplanationKind::kCurvedOutput;
  std::vector<int> shapes;
  for (const CurveShape shape :
       {CurveShape::kExponential, CurveShape::kSinh, CurveShape::kLogarithm,
        CurveShape::kQuadratic, CurveShape::kRoot, CurveShape::kTanh}) {
    if (is_output || !IsOdd(shape)) shapes.push_back(static_cast<int>(shape));
  }
  return shapes;
}

std::vector<Explanation> InShape(Explanation curve, int part) {
  constexpr double kBent = 1.0;  // θ of a curve of another family
  const CurveShape before = ShapeOf(curve);
  curve.part = part;
  const CurveShape after = ShapeOf(curve);
  if (IsOdd(before) != IsOdd(after)) {
    Explanation other = curve;
    curve.value = kBent;
    other.value = -kBent;
    return {curve, other};
  }
  const double ratio = BendOf(before) / BendOf(after);
  curve.value *= IsOdd(after) ? std::sqrt(ratio) : ratio;
  return {curve};
}

double Bend(CurveShape shape, double c, double x) {
  const double cx = c * x;
  if (std::abs(cx) < kStraight) return x;
  switch (shape) {
    case CurveShape::kExponential:
      return std::expm1(cx) / c;
    case CurveShape::kLogarithm:
      return std::log1p(cx) / c;
    case CurveShape::kQuadratic:
      return cx > -1.0 ? x * (1.0 + 0.5 * cx) : kNaN;
    case CurveShape::kRoot:
      return 2.0 * x / (1.0 + std::sqrt(1.0 + 2.0 * cx));
    case CurveShape::kSinh:
      return (c > 0.0 ? std::sinh(cx) : std::asinh(cx)) / c;
    case CurveShape::kTanh:
      return (c > 0.0 ? std::atanh(cx) : std::tanh(cx)) / c;
  }
  return kNaN;
}

double Straighten(CurveShape shape, double c, double y) {
  return Bend(InverseShape(shape), IsOdd(shape) ? -c : c, y);
}

double SlopeOf(CurveShape shape, double c, double x) {
  const double cx = c * x;
  switch (shape) {
    case CurveShape::kExponential:
      return std::exp(cx);
    case CurveShape::kLogarithm:
      return 1.0 / (1.0 + cx);
    case CurveShape::kQuadratic:
      return 1.0 + cx;
    case CurveShape::kRoot:
      return 1.0 / std::sqrt(1.0 + 2.0 * cx);
    case CurveShape::kSinh:
      return c > 0.0 ? std::cosh(cx) : 1.0 / std::sqrt(1.0 + cx * cx);
    case CurveShape::kTanh: {
      const double tanh = std::tanh(cx);
      return c > 0.0 ? 1.0 / (1.0 - cx * cx) : 1.0 - tanh * tanh;
    }
  }
  return kNaN;
}

Transform FoundCurve::AsTransform() const {
  // An output's transform straightens what its curve bends.
  const CurveShape own = is_output ? InverseShape(shape) : shape;
  const double own_c = is_output && IsOdd(shape) ? -curvature : curvature;
  Transform transform;
  transform.at = at;
  switch (own) {
    case CurveShape::kExponential:
      transform.kind = TransformKind::kExponential;
      transform.curvature = own_c;
      break;
    case CurveShape::kLogarithm:
      transform.kind = TransformKind::kLogarithm;
      transform.zero = at - 1.0 / own_c;
      break;
    case CurveShape::kQuadratic:
      transform.kind = TransformKind::kPower;
      transform.exponent = 2.0;
      transform.zero = at - 1.0 / own_c;
      break;
    case CurveShape::kRoot:
      transform.kind = TransformKind::kPower;
      transform.exponent = 0.5;
      transform.zero = at - 0.5 / own_c;
      break;
    case CurveShape::kSinh:
    case CurveShape::kTanh:
      transform = Points(own, own_c, *this);
      transform.at = at;
      break;
  }
  return transform;
}

FoundCurve::Gain FoundCurve::GainAt(double value) const {
  constexpr double kNormal = 1.959963984540054;  // of 95 %
  const auto gain_of = [&](CurveShape its_shape, double c) {
    const double x = value - at;
    return SlopeOf(its_shape, c, is_output ? Straighten(its_shape, c, x) : x);
  };
  Gain gain;
  gain.value = gain_of(shape, curvature);
  gain.lower = gain.value;
  gain.upper = gain.value;
  std::vector<Alternative> all = alternatives;
  all.push_back({shape, curvature});
  const double relative = standard_error / std::abs(curvature);
  for (const Alternative& one : all) {
    for (const double sign : {-1.0, 1.0}) {
      const double other =
          gain_of(one.shape, one.curvature * (1.0 + sign * kNormal * relative));
      gain.lower = std::min(gain.lower, other);
      gain.upper = std::max(gain.upper, other);
    }
  }
  const double linear = AsTransform().Linear(value);
  for (const FoundCurve& other : upon) {
    const Gain more = other.GainAt(linear);
    gain.value *= more.value;
    gain.lower *= more.lower;
    gain.upper *= more.upper;
  }
  return gain;
}

}  // namespace mle
