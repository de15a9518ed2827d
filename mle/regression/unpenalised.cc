#include "mle/regression/unpenalised.h"

#include "Eigen/Core"
#include "glog/logging.h"

namespace mle {
namespace {

constexpr double kDependentColumn = 1e-12;

}  // namespace

std::vector<int> IndependentUnpenalised(const LassoObjective& objective,
                                        UpdatableCholesky& factor) {
  CHECK_EQ(factor.size(), 0);
  const Eigen::MatrixXd& gram = *objective.gram;
  std::vector<int> independent;
  for (int j = 0; j < objective.size(); ++j) {
    if (objective.weights(j) != 0.0) continue;
    const Eigen::VectorXd cross = gram.col(j)(independent);
    const double square = gram(j, j);
    if (factor.Append(cross, square, kDependentColumn) >
        kDependentColumn * square) {
      independent.push_back(j);
    }
  }
  return independent;
}

}  // namespace mle
