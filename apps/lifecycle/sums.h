// Integrals over a stretch of operation, before prices are applied.
//
//   squared error   ∫ (y_i − r_i)² dt
//   absolute error  ∫ |y_i − r_i| dt
//   violation       ∫ max(0, y_i − y_max,i, y_min,i − y_i) dt
//   movement        Σ |u_j(k) − u_j(k−1)|
//
// where y is what the plant really does, disturbances included and measurement
// noise not: the product's quality, not its reading. Times are in the process
// model's unit.

#ifndef APPS_LIFECYCLE_SUMS_H_
#define APPS_LIFECYCLE_SUMS_H_

#include "Eigen/Core"

namespace mle::lifecycle {

// Limits of the outputs for the violation; p values, infinite for none.
struct OutputLimits {
  Eigen::VectorXd min;
  Eigen::VectorXd max;
};

struct Sums {
  double time = 0.0;               // length of the stretch
  Eigen::VectorXd squared_error;   // p
  Eigen::VectorXd absolute_error;  // p
  Eigen::VectorXd violation;       // p
  Eigen::VectorXd movement;        // m

  // All zero.
  static Sums Zero(int num_outputs, int num_inputs);
  // Adds `factor` times all of `other`.
  void Add(const Sums& other, double factor = 1.0);
};

// Of samples first … end − 1, each held for Δt: `outputs` (p × N) without
// noise, `set_points` (p × N), `inputs` (m × N).
Sums SumsOf(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& set_points,
            const Eigen::MatrixXd& inputs, int first, int end,
            double sample_time, const OutputLimits& limits);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SUMS_H_
