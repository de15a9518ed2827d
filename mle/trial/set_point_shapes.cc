#include "mle/trial/set_point_shapes.h"

#include <cmath>

namespace mle {

Eigen::MatrixXd SetPointShapes(const Eigen::MatrixXd& set_points, double pole) {
  using Eigen::Index;
  const Index n = set_points.cols();
  Eigen::MatrixXd shapes =
      Eigen::MatrixXd::Zero(kShapesOfSetPoint * set_points.rows(), n);
  for (Index j = 0; j < set_points.rows(); ++j) {
    auto of = shapes.middleRows(j * kShapesOfSetPoint, kShapesOfSetPoint);
    for (Index k = 0; k < n; ++k) {
      const double level = set_points(j, k) - set_points(j, 0);
      const double before = k > 0 ? of(0, k - 1) : 0.0;
      of(0, k) = pole * before + std::sqrt(1.0 - pole * pole) * level;
      for (Index l = 1; l < kShapesOfSetPoint; ++l) {
        const double last = k > 0 ? of(l, k - 1) : 0.0;
        const double last_of_former = k > 0 ? of(l - 1, k - 1) : 0.0;
        of(l, k) = pole * last + last_of_former - pole * of(l - 1, k);
      }
    }
  }
  return shapes;
}

}  // namespace mle
