// The noise of one output, for a filter that predicts. Internal to mle/filter.
//
// Classes are a random walk, one behind a lag, and coloured noise of first and
// second order beside a walk, all with white noise; by likelihood, and by
// Akaike's criterion (IEEE Transactions on Automatic Control 19, 1974).
//
// Of a filter with given gains the mean squared error is linear in the
// variances, so that the gains best under what the records leave open are those
// of the mean variances. Of the walk that differs from the likeliest, which
// often is none, while a drift that is not followed costs without bound.

#ifndef MLE_FILTER_PREDICTION_NOISE_H_
#define MLE_FILTER_PREDICTION_NOISE_H_

#include <vector>

#include "Eigen/Core"
#include "mle/filter/disturbance_system.h"

namespace mle {

// Samples that a noise is estimated from, at least: it has four parameters and
// an offset.
inline constexpr int kLeastNoiseSamples = 50;

struct PredictionNoise {
  NoiseEstimate noise;
  double walk_lag = 0.0;  // of SystemOf()

  DisturbanceSystem Every(int samples) const {
    return SystemOf(noise, samples, walk_lag);
  }
};

// Of residuals, NaN where nothing is measured; none (r = 0) of too few samples.
PredictionNoise EstimatePredictionNoise(
    const std::vector<Eigen::VectorXd>& residuals, double sample_time);

}  // namespace mle

#endif  // MLE_FILTER_PREDICTION_NOISE_H_
