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

class GaussianNoise {
 public:
  // `substream` tells apart what one run draws for different purposes: 0 is
  // the measurement noise of a closed loop, 1 and 2 are the inputs and the
  // measurement noise of an excitation.
  GaussianNoise(std::uint64_t seed, std::uint64_t stream,
                std::uint32_t substream = 0);

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
