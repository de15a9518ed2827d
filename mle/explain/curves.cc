#include "mle/explain/curves.h"

#include <algorithm>
#include <cmath>

#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

// k/w, upwards, then downwards.
constexpr double kKinksAt[kKinks] = {0.05,  0.25,  0.5,  0.75,
                                     -0.05, -0.25, -0.5, -0.75};

bool IsKink(CurveShape shape) { return shape >= CurveShape::kFirstKink; }

Transform KinkTransform(CurveShape shape, double c, double width) {
  const double at = width * kKinksAt[static_cast<int>(shape) -
                                     static_cast<int>(CurveShape::kFirstKink)];
  const double beyond = std::copysign(width, at);
  Transform curve;
  curve.kind = TransformKind::kPiecewiseLinear;
  curve.points = {{-beyond, -beyond},
                  {at, at},
                  {at + beyond, at + std::exp(c * width) * beyond}};
  if (at < 0.0) std::reverse(curve.points.begin(), curve.points.end());
  return curve;
}

// Whether an inverse has the same shape, and the other sign of c.
bool IsOdd(CurveShape shape) {
  return shape == CurveShape::kSinh || shape == CurveShape::kTanh;
}

// One-sided, S-shaped, kinks.
int FamilyOf(CurveShape shape) {
  return IsOdd(shape) ? 1 : IsKink(shape) ? 2 : 0;
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

}  // namespace

double ShapeCost(int part) {
  return FamilyOf(static_cast<CurveShape>(part)) == 0 ? 0.0 : kAsMuch;
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
  for (int kink = 0; kink < kKinks && !is_output; ++kink) {
    shapes.push_back(static_cast<int>(CurveShape::kFirstKink) + kink);
  }
  return shapes;
}

std::vector<int> CompetingShapes(ExplanationKind kind) {
  constexpr int kQuarter = static_cast<int>(CurveShape::kFirstKink) + 1;
  const int first = static_cast<int>(CurveShape::kExponential);
  if (kind == ExplanationKind::kCurvedInput) {
    return {first, kQuarter, kQuarter + kKinks / 2};
  }
  return {first, static_cast<int>(CurveShape::kSinh)};
}

std::vector<Explanation> InShape(Explanation curve, int part) {
  constexpr double kBent = 1.0;  // θ of a curve of another family
  const CurveShape before = ShapeOf(curve);
  curve.part = part;
  const CurveShape after = ShapeOf(curve);
  if (FamilyOf(before) != FamilyOf(after)) {
    Explanation other = curve;
    curve.value = kBent;
    other.value = -kBent;
    return {curve, other};
  }
  if (IsKink(after)) return {curve};
  const double ratio = BendOf(before) / BendOf(after);
  curve.value *= IsOdd(after) ? std::sqrt(ratio) : ratio;
  return {curve};
}

Transform CurveTransform(CurveShape shape, double c, double width) {
  Transform curve;
  if (c == 0.0) return curve;
  if (IsKink(shape)) return KinkTransform(shape, c, width);
  switch (shape) {
    case CurveShape::kExponential:
      curve.kind = TransformKind::kExponential;
      curve.curvature = c;
      break;
    case CurveShape::kLogarithm:
      curve.kind = TransformKind::kLogarithm;
      curve.zero = -1.0 / c;
      break;
    case CurveShape::kQuadratic:
      curve.kind = TransformKind::kPower;
      curve.exponent = 2.0;
      curve.zero = -1.0 / c;
      break;
    case CurveShape::kRoot:
      curve.kind = TransformKind::kPower;
      curve.exponent = 0.5;
      curve.zero = -0.5 / c;
      break;
    case CurveShape::kSinh:
    case CurveShape::kTanh:
      curve.kind = shape == CurveShape::kSinh ? TransformKind::kSinh
                                              : TransformKind::kTanh;
      curve.curvature = c;
      break;
    default:
      break;
  }
  return curve;
}

Transform FoundCurve::TransformIn(CurveShape other, double c) const {
  const double width = std::max(high - at, at - low);
  // An output's transform straightens what its curve bends.
  Transform transform = is_output ? CurveTransform(InverseShape(other),
                                                   IsOdd(other) ? -c : c, width)
                                  : CurveTransform(other, c, width);
  transform.at = at;
  transform.zero += at;
  for (auto& [x, f] : transform.points) {
    x += at;
    f += at;
  }
  return transform;
}

FoundCurve::Gain FoundCurve::GainAt(double value) const {
  const auto gain_of = [&](CurveShape other, double c) {
    const double slope = TransformIn(other, c).Slope(value);
    return is_output ? 1.0 / slope : slope;
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
      const double other = gain_of(
          one.shape, one.curvature * (1.0 + sign * kNormalQuantile * relative));
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
