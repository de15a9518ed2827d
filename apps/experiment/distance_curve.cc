#include "apps/experiment/distance_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace mle::experiment {
namespace {

constexpr double kSpacing = 1.01;

}  // namespace

double DistanceOrInfinity(const StepResponse& truth,
                          const StepResponse& response) {
  const double distance = SquaredDistance(truth, response);
  return std::isfinite(distance) ? distance
                                 : std::numeric_limits<double>::infinity();
}

DistanceCurve::DistanceCurve(const Correction& correction,
                             const Eigen::VectorXd& lambdas,
                             const StepResponse& truth)
    : correction_(correction),
      lambdas_(lambdas),
      truth_(truth),
      model_(correction.initial()) {}

double DistanceCurve::operator()(Eigen::Index i) {
  correction_.Model(Eigen::VectorXd::Constant(model_.num_outputs, lambdas_(i)),
                    model_);
  return DistanceOrInfinity(truth_,
                            model_.ComputeStepResponse(truth_.samples()));
}

Eigen::VectorXd DistanceCurve::Whole() {
  Eigen::VectorXd distances(lambdas_.size());
  for (Eigen::Index i = 0; i < distances.size(); ++i) {
    distances(i) = (*this)(i);
  }
  return distances;
}

Eigen::Index DistanceCurve::Best() {
  std::vector<Eigen::Index> coarse = {0};
  for (Eigen::Index i = 1; i < lambdas_.size(); ++i) {
    if (lambdas_(i) >= kSpacing * lambdas_(coarse.back())) {
      coarse.push_back(i);
    }
  }
  std::size_t best = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < coarse.size(); ++n) {
    const double distance = (*this)(coarse[n]);
    if (distance < smallest) {
      smallest = distance;
      best = n;
    }
  }
  Eigen::Index found = coarse[best];
  const Eigen::Index first = coarse[best > 0 ? best - 1 : 0];
  const Eigen::Index last = coarse[std::min(best + 1, coarse.size() - 1)];
  for (Eigen::Index i = first; i <= last; ++i) {
    const double distance = (*this)(i);
    if (distance < smallest) {
      smallest = distance;
      found = i;
    }
  }
  return found;
}

}  // namespace mle::experiment
