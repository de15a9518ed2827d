#include "sim/coloured_noise.h"

#include <cmath>

namespace mle::sim {

Eigen::MatrixXd DrawColouredNoise(GaussianNoise& source,
                                  const Eigen::VectorXd& deviations,
                                  double time_constant, double sample_time,
                                  int samples) {
  const double memory = std::exp(-sample_time / time_constant);
  const double fresh =
      std::sqrt(-std::expm1(-2.0 * sample_time / time_constant));
  const int rows = static_cast<int>(deviations.size());
  Eigen::MatrixXd noise = source.DrawMatrix(rows, samples, 1.0);
  for (int k = 1; k < samples; ++k) {
    noise.col(k) = memory * noise.col(k - 1) + fresh * noise.col(k);
  }
  return deviations.asDiagonal() * noise;
}

}  // namespace mle::sim
