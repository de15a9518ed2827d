// Records of a noise, drawn as its equations say.

#ifndef TESTS_MLE_FILTER_NOISE_RECORDS_H_
#define TESTS_MLE_FILTER_NOISE_RECORDS_H_

#include <cmath>

#include "Eigen/Core"
#include "mle/base/random.h"
#include "mle/nonlinear/ar_component.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

inline Eigen::VectorXd DrawNoise(const NoiseEstimate& noise, int samples,
                                 std::uint64_t seed) {
  GaussianNoise walk(seed, kRunStream, kDriftDisturbance);
  GaussianNoise coloured(seed, kRunStream, kColouredDisturbance);
  GaussianNoise white(seed, kRunStream, kMeasurementNoise);
  const bool has_ar = noise.ar_ratio > 0.0;
  ArSignal ar(ArComponent(has_ar ? noise.ar_pole : 0.0,
                          has_ar ? noise.ar_damping : 0.0),
              has_ar ? noise.ar_ratio * noise.variance : 1.0, coloured);
  Eigen::VectorXd values(samples);
  double level = 0.0;
  for (double& value : values) {
    value = level + white.Draw(std::sqrt(noise.variance));
    if (has_ar) value += ar.value();
    ar.Advance();
    level += walk.Draw(std::sqrt(noise.increment_variance()));
  }
  return values;
}

}  // namespace mle

#endif  // TESTS_MLE_FILTER_NOISE_RECORDS_H_
