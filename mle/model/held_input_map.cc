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

// Over() of r states, a constant where r is small: then nothing is allocated
// but the result.
template <int kStates>
HeldInputMap OfSize(double duration,
                    const Eigen::Matrix<double, kStates, kStates>& A,
                    const Eigen::Matrix<double, kStates, 1>& B) {
  using Square = Eigen::Matrix<double, kStates, kStates>;
  using State = Eigen::Matrix<double, kStates, 1>;
  const Eigen::Index r = A.rows();
  const double norm = r == 0 ? 0.0 : A.cwiseAbs().colwise().sum().maxCoeff();
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

  const Square X = step * A;
  Square phi = Square::Identity(r, r);
  for (int k = kTerms; k >= 2; --k) {
    phi = (X.lazyProduct(phi) / static_cast<double>(k)).eval();
    phi.diagonal().array() += 1.0;
  }
  Square E = X.lazyProduct(phi);
  State gamma = phi.lazyProduct(step * B);
  for (int i = 0; i < doublings; ++i) {
    // The map after itself.
    gamma = (gamma + gamma + E * gamma).eval();
    E = (E + E + E * E).eval();
  }
  return {E, gamma};
}

}  // namespace

HeldInputMap HeldInputMap::Over(double duration, const Eigen::MatrixXd& A,
                                const Eigen::VectorXd& B) {
  CHECK_GE(duration, 0.0);
  CHECK_EQ(A.rows(), A.cols());
  CHECK_EQ(A.rows(), B.size());
  switch (A.rows()) {
    case 1:
      return OfSize<1>(duration, A, B);
    case 2:
      return OfSize<2>(duration, A, B);
    case 4:
      return OfSize<4>(duration, A, B);
    default:
      return OfSize<Eigen::Dynamic>(duration, A, B);
  }
}

SampleMap SampleMap::Over(double sample_time, double fraction,
                          const Eigen::MatrixXd& A, const Eigen::VectorXd& B) {
  const HeldInputMap first = HeldInputMap::Over(fraction * sample_time, A, B);
  const HeldInputMap rest =
      HeldInputMap::Over((1.0 - fraction) * sample_time, A, B);
  return {first.E + rest.E + rest.E * first.E,
          first.gamma + rest.E * first.gamma, rest.gamma};
}

}  // namespace mle
