#include "mle/nonlinear/robust_loss.h"

#include <cmath>
#include <vector>

#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

constexpr double kHuber = 1.345;
constexpr double kCauchy = 2.3849;
constexpr double kGaussian = 1.4826;

}  // namespace

double RobustWeight(RobustLoss loss, double x) {
  switch (loss) {
    case RobustLoss::kNone:
      break;
    case RobustLoss::kHuber:
      return std::abs(x) > kHuber ? kHuber / std::abs(x) : 1.0;
    case RobustLoss::kCauchy:
      return 1.0 / (1.0 + (x / kCauchy) * (x / kCauchy));
  }
  return 1.0;
}

double RobustCurvature(RobustLoss loss, double x) {
  switch (loss) {
    case RobustLoss::kNone:
      break;
    case RobustLoss::kHuber:
      return std::abs(x) > kHuber ? 0.0 : 1.0;
    case RobustLoss::kCauchy: {
      const double w = RobustWeight(loss, x);
      return w * w * (1.0 - (x / kCauchy) * (x / kCauchy));
    }
  }
  return 1.0;
}

RobustWeights ComputeRobustWeights(RobustLoss loss,
                                   const Eigen::VectorXd& residuals) {
  RobustWeights result;
  result.weights = Eigen::VectorXd::Ones(residuals.size());
  if (loss == RobustLoss::kNone || residuals.size() == 0) return result;
  std::vector<double> sizes(residuals.size());
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    sizes[k] = std::abs(residuals(k));
  }
  result.scale = kGaussian * MedianInPlace(sizes);
  if (!(result.scale > 0.0)) return result;
  double weight = 0.0;
  double slope = 0.0;      // ψ′
  double influence = 0.0;  // ψ²
  double product = 0.0;    // ψx
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const double x = residuals(k) / result.scale;
    const double w = RobustWeight(loss, x);
    result.weights(k) = w;
    weight += w;
    slope += RobustCurvature(loss, x);
    influence += w * x * w * x;
    product += w * x * x;
  }
  if (slope > 0.0 && product > 0.0) {
    result.variance_factor = influence * static_cast<double>(residuals.size()) /
                             (slope * slope) * weight / product;
  }
  return result;
}

}  // namespace mle
