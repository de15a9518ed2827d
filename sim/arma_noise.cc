#include "sim/arma_noise.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Eigenvalues"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLargestPole = 1.0 - 1e-4;
constexpr double kLargestZero = 1000.0;
constexpr std::size_t kMostRoots = 8;

// The coefficients of Π (1 − r q⁻¹), the first of them 1.
VectorXd Polynomial(const std::vector<std::complex<double>>& roots) {
  VectorXd product = VectorXd::Ones(1);
  const auto multiply = [&product](const VectorXd& factor) {
    VectorXd longer = VectorXd::Zero(product.size() + factor.size() - 1);
    for (Index i = 0; i < factor.size(); ++i) {
      longer.segment(i, product.size()) += factor[i] * product;
    }
    product = longer;
  };
  for (const std::complex<double>& root : roots) {
    if (root.imag() == 0.0) {
      multiply(Eigen::Vector2d(1.0, -root.real()));
    } else {
      multiply(Eigen::Vector3d(1.0, -2.0 * root.real(), std::norm(root)));
    }
  }
  return product;
}

// P = T P Tᵀ + R Rᵀ by doubling: after n rounds the sum of 2ⁿ terms.
MatrixXd StationaryCovariance(MatrixXd transition, const VectorXd& entry) {
  MatrixXd covariance = entry * entry.transpose();
  while (transition.cwiseAbs().maxCoeff() > 1e-20) {
    covariance += (transition * covariance * transition.transpose()).eval();
    transition = (transition * transition).eval();
  }
  return covariance;
}

}  // namespace

absl::Status ArmaOptions::Validate() const {
  if (poles.size() > kMostRoots || zeros.size() > kMostRoots) {
    return InvalidArgument("there are ", poles.size(), " poles and ",
                           zeros.size(), " zeros, but at most ", kMostRoots,
                           " of each may be");
  }
  for (const std::complex<double>& pole : poles) {
    if (std::abs(pole) <= kLargestPole) continue;
    return InvalidArgument("the pole ", pole.real(), " + ", pole.imag(),
                           "i is not inside a circle of radius ", kLargestPole);
  }
  for (const std::complex<double>& zero : zeros) {
    if (std::abs(zero) <= kLargestZero) continue;
    return InvalidArgument("the zero ", zero.real(), " + ", zero.imag(),
                           "i is not inside a circle of radius ", kLargestZero);
  }
  return CheckNotNegative("variance", variance);
}

Eigen::RowVectorXd DrawArmaNoise(GaussianNoise& source,
                                 const ArmaOptions& options, int samples) {
  const VectorXd a = Polynomial(options.poles);
  const VectorXd b = Polynomial(options.zeros);
  const Index n = std::max(a.size() - 1, b.size());
  MatrixXd transition = MatrixXd::Zero(n, n);
  transition.topRightCorner(n - 1, n - 1).setIdentity();
  transition.col(0).head(a.size() - 1) = -a.tail(a.size() - 1);
  VectorXd entry = VectorXd::Zero(n);
  entry.head(b.size()) = b;

  const MatrixXd covariance = StationaryCovariance(transition, entry);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(covariance);
  VectorXd state =
      spectrum.eigenvectors() *
      spectrum.eigenvalues().cwiseMax(0.0).cwiseSqrt().cwiseProduct(
          source.DrawMatrix(static_cast<int>(n), 1, 1.0).col(0));
  Eigen::RowVectorXd noise(samples);
  for (int k = 0; k < samples; ++k) {
    noise[k] = state[0];
    state = (transition * state + source.Draw(1.0) * entry).eval();
  }
  return std::sqrt(options.variance / covariance(0, 0)) * noise;
}

}  // namespace mle::sim
