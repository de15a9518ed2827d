// Records of a noise, drawn as its equations say.

#ifndef TESTS_MLE_FILTER_NOISE_RECORDS_H_
#define TESTS_MLE_FILTER_NOISE_RECORDS_H_

#include <cmath>

#include "Eigen/Core"
#include "mle/base/random.h"
#include "mle/nonlinear/colour.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

inline Eigen::VectorXd DrawNoise(const NoiseEstimate& noise, int samples,
                                 std::uint64_t seed) {
  GaussianNoise walk(seed, kRunStream, kDriftDisturbance);
  GaussianNoise coloured(seed, kRunStream, kColouredDisturbance);
  GaussianNoise white(seed, kRunStream, kMeasurementNoise);
  const bool has_colour = noise.colour_ratio > 0.0;
  ColourSignal colour(Colour(has_colour ? noise.colour_pole : 0.0,
                             has_colour ? noise.colour_damping : 0.0),
                      has_colour ? noise.colour_ratio * noise.variance : 1.0,
                      coloured);
  Eigen::VectorXd values(samples);
  double level = 0.0;
  for (double& value : values) {
    value = level + white.Draw(std::sqrt(noise.variance));
    if (has_colour) value += colour.value();
    colour.Advance();
    level += walk.Draw(std::sqrt(noise.increment_variance()));
  }
  return values;
}

}  // namespace mle

#endif  // TESTS_MLE_FILTER_NOISE_RECORDS_H_
