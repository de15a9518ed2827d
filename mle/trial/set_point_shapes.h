// Shapes that responses to set points are made of: each set point through
// discrete Laguerre functions of pole a,
//
//   L_1(z) = √(1 − a²)/(1 − a z⁻¹),   L_{l+1}(z) = L_l(z) (z⁻¹ − a)/(1 − a
//   z⁻¹),
//
// with its level at the first row taken off. They depend on set points alone,
// whatever disturbs the plant. Internal to mle/trial.

#ifndef MLE_TRIAL_SET_POINT_SHAPES_H_
#define MLE_TRIAL_SET_POINT_SHAPES_H_

#include "Eigen/Core"

namespace mle {

inline constexpr int kShapesOfSetPoint = 5;

// `set_points`: p × n. Rows of the shapes are those of the first set point,
// then of the second (kShapesOfSetPoint p × n); 0 < pole < 1.
Eigen::MatrixXd SetPointShapes(const Eigen::MatrixXd& set_points, double pole);

}  // namespace mle

#endif  // MLE_TRIAL_SET_POINT_SHAPES_H_
