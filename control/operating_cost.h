// The cost of operation: integrals over a segment of it, and their prices.
//
//   squared error   ∫ (y_i − r_i)² dt
//   absolute error  ∫ |y_i − r_i| dt
//   violation       ∫ max(0, y_i − y_max,i, y_min,i − y_i) dt
//   movement        Σ |u_j(k) − u_j(k−1)|
//
// where y is what the plant really does, disturbances included and measurement
// noise not: the product's quality, not its reading. Times are in the process
// model's unit, prices in money of the user's choice for real hours.
//
//   const Cost cost = CostOf(SumsOf(y, r, u, 0, y.cols(), 1.0, limits), prices,
//                            /*hours_per_unit=*/1.0 / 60.0);

#ifndef CONTROL_OPERATING_COST_H_
#define CONTROL_OPERATING_COST_H_

#include "Eigen/Core"

namespace mle::control {

// Limits of the outputs for the violation; p values, infinite for none.
struct OutputLimits {
  Eigen::VectorXd min;
  Eigen::VectorXd max;
};

struct OperationSums {
  double time = 0.0;               // length of the stretch
  Eigen::VectorXd squared_error;   // p
  Eigen::VectorXd absolute_error;  // p
  Eigen::VectorXd violation;       // p
  Eigen::VectorXd movement;        // m

  // All zero.
  static OperationSums Zero(int num_outputs, int num_inputs);
  // Adds `factor` times all of `other`.
  void Add(const OperationSums& other, double factor = 1.0);
};

// Sums over samples first … end − 1, each held for Δt: `outputs` (p × N)
// without noise, `set_points` (p × N), `inputs` (m × N).
OperationSums SumsOf(const Eigen::MatrixXd& outputs,
                     const Eigen::MatrixXd& set_points,
                     const Eigen::MatrixXd& inputs, int first, int end,
                     double sample_time, const OutputLimits& limits);

struct Prices {
  Eigen::VectorXd squared_error;   // p, per squared unit of the output and hour
  Eigen::VectorXd absolute_error;  // p, per unit and hour
  Eigen::VectorXd violation;       // p, per unit beyond a limit and hour
  Eigen::VectorXd movement;        // m, per unit that an input moves
  double test_hour = 100.0;        // of a step test, besides its product
  double engineer_hour = 100.0;
  double hours_per_update = 1.0;  // of an engineer: a correction to be approved
  double hours_per_test = 16.0;   // of an engineer, for a step test
};

// Parts of a cost.
struct Cost {
  double product = 0.0;  // errors
  double violation = 0.0;
  double movement = 0.0;
  double test_hours = 0.0;  // the tests' hours, at their price
  double engineering = 0.0;

  double total() const {
    return product + violation + movement + test_hours + engineering;
  }
  void Add(const Cost& other);
};

// The cost of the segment itself: no tests, no engineering. `hours_per_unit`:
// hours in a unit of time.
Cost CostOf(const OperationSums& sums, const Prices& prices,
            double hours_per_unit);

}  // namespace mle::control

#endif  // CONTROL_OPERATING_COST_H_
