#include "mle/model/held_input_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "glog/logging.h"

namespace mle {
namespace {

constexpr int kLargestNormExponent = -1;
// ½¹⁶/17! is below half a rounding error of φ.
constexpr int kTerms = 16;

double LargestColumnSum(const Eigen::MatrixXd& A) {
  return A.rows() == 0 ? 0.0 : A.cwiseAbs().colwise().sum().maxCoeff();
}

}  // namespace

HeldInputMap HeldInputMap::Over(double duration, const Eigen::MatrixXd& A,
                                const Eigen::VectorXd& B) {
  CHECK_GE(duration, 0.0);
  CHECK_EQ(A.rows(), A.cols());
  CHECK_EQ(A.rows(), B.size());
  const Eigen::Index r = A.rows();
  const double norm = LargestColumnSum(A);
  if (!std::isfinite(norm)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {Eigen::MatrixXd::Constant(r, r, nan),
            Eigen::VectorXd::Constant(r, nan)};
  }
  // By exponents: the product of the two may overflow.
  int doublings = 0;
  if (norm > 0.0 && duration > 0.0) {
    doublings = std::max(
        0, std::ilogb(norm) + std::ilogb(duration) - kLargestNormExponent + 2);
  }
  const double step = std::ldexp(duration, -doublings);

  const Eigen::MatrixXd X = step * A;
  Eigen::MatrixXd phi = Eigen::MatrixXd::Identity(r, r);
  for (int k = kTerms; k >= 2; --k) {
    phi = (X.lazyProduct(phi) / static_cast<double>(k)).eval();
    phi.diagonal().array() += 1.0;
  }
  HeldInputMap map{X.lazyProduct(phi), phi.lazyProduct(step * B)};
  for (int i = 0; i < doublings; ++i) map = map.Then(map);
  return map;
}

SampleMap SampleMap::Over(double sample_time, double fraction,
                          const Eigen::MatrixXd& A, const Eigen::VectorXd& B) {
  const HeldInputMap first = HeldInputMap::Over(fraction * sample_time, A, B);
  const HeldInputMap rest =
      HeldInputMap::Over((1.0 - fraction) * sample_time, A, B);
  return {first.E + rest.E + rest.E * first.E,
          first.gamma + rest.E * first.gamma, rest.gamma};
}

HeldInputMap HeldInputMap::Then(const HeldInputMap& next) const {
  return {E + next.E + next.E * E, gamma + next.gamma + next.E * gamma};
}

}  // namespace mle
