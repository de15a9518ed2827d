// Transforms of channels, for tests.

#ifndef TESTS_MLE_MODEL_TRANSFORMS_H_
#define TESTS_MLE_MODEL_TRANSFORMS_H_

#include "mle/model/transform.h"

namespace mle {

// A valve from 0 to 100 %.
inline Transform EqualPercentage(double rangeability, double at) {
  Transform valve;
  valve.kind = TransformKind::kEqualPercentage;
  valve.rangeability = rangeability;
  valve.low = 0.0;
  valve.high = 100.0;
  valve.at = at;
  return valve;
}

inline Transform Root(double at) {
  Transform root;
  root.kind = TransformKind::kPower;
  root.exponent = 0.5;
  root.at = at;
  return root;
}

inline Transform Logarithm(double at) {
  Transform logarithm;
  logarithm.kind = TransformKind::kLogarithm;
  logarithm.at = at;
  return logarithm;
}

inline Transform Exponential(double curvature, double at = 0.0) {
  Transform exponential;
  exponential.kind = TransformKind::kExponential;
  exponential.curvature = curvature;
  exponential.at = at;
  return exponential;
}

}  // namespace mle

#endif  // TESTS_MLE_MODEL_TRANSFORMS_H_
