// Seeded Gaussian noise.
//
// A generator belongs to a seed, a stream and a substream, so that the parts
// of an experiment (its runs, the excitation of the conversion, …) draw
// independently and none depends on how much another has drawn.

#ifndef SIM_NOISE_H_
#define SIM_NOISE_H_

#include <cstdint>
#include <random>

#include "Eigen/Core"

namespace mle::sim {

// What one run draws for different purposes, each from a generator of its own:
// switching one on leaves the draws of all others as they were.
enum Substream : std::uint32_t {
  kMeasurementNoise = 0,  // of a closed loop
  kExcitationInputs = 1,
  kExcitationNoise = 2,
  kColouredDisturbance = 10,
  kDriftDisturbance = 11,
  kStepTimes = 12,
  kStepSizes = 13,
  kInputDisturbance = 20,
  kOutliers = 30,
  kFrozenChannels = 31,
  kLostOutputs = 32,
  kLostInputs = 33,
};

std::mt19937_64 SeededEngine(std::uint64_t seed, std::uint64_t stream,
                             std::uint32_t substream);

// Uniform in [0, 1).
double DrawUniform(std::mt19937_64& engine);

class GaussianNoise {
 public:
  GaussianNoise(std::uint64_t seed, std::uint64_t stream,
                std::uint32_t substream = kMeasurementNoise);

  // One draw of mean 0 and the given standard deviation ≥ 0.
  double Draw(double standard_deviation);
  // rows × cols independent draws, column by column.
  Eigen::MatrixXd DrawMatrix(int rows, int cols, double standard_deviation);

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace mle::sim

#endif  // SIM_NOISE_H_
