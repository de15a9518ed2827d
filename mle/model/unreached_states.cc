#include "mle/model/unreached_states.h"

#include <cstddef>
#include <vector>

namespace mle {
namespace {

// A direction is new if its part orthogonal to the known ones is longer than
// this share of the norm of A, or of its column of B.
constexpr double kNewDirection = 1e-9;

// Those that entries other than 0 join to an input.
std::vector<int> JoinedStates(const DiscreteStateSpace& system) {
  std::vector<bool> is_joined(system.order(), false);
  std::vector<int> joined;
  const auto join = [&](int state) {
    if (is_joined[state]) return;
    is_joined[state] = true;
    joined.push_back(state);
  };
  for (int i = 0; i < system.order(); ++i) {
    if (!system.B.row(i).isZero(0.0)) join(i);
  }
  for (std::size_t k = 0; k < joined.size(); ++k) {
    for (int i = 0; i < system.order(); ++i) {
      if (system.A(i, joined[k]) != 0.0) join(i);
    }
  }
  joined.clear();
  for (int i = 0; i < system.order(); ++i) {
    if (is_joined[i]) joined.push_back(i);
  }
  return joined;
}

// An orthonormal basis of what B, A B, A² B, … span (Arnoldi, each direction
// orthogonalised twice).
Eigen::MatrixXd ReachedBasis(const DiscreteStateSpace& system) {
  const Eigen::Index n = system.order();
  Eigen::MatrixXd basis(n, n);
  Eigen::Index rank = 0;
  const auto add = [&](Eigen::VectorXd direction, double scale) {
    for (int pass = 0; pass < 2; ++pass) {
      const auto known = basis.leftCols(rank);
      direction -= known * (known.transpose() * direction);
    }
    if (rank < n && direction.norm() > kNewDirection * scale) {
      basis.col(rank++) = direction.normalized();
    }
  };
  for (int j = 0; j < system.num_inputs(); ++j) {
    add(system.B.col(j), system.B.col(j).norm());
  }
  for (Eigen::Index k = 0; k < rank; ++k) {
    add(system.A * basis.col(k), system.A.norm());
  }
  return basis.leftCols(rank);
}

}  // namespace

int LeaveOutUnreachedStates(DiscreteStateSpace& system) {
  const int all = system.order();
  const std::vector<int> joined = JoinedStates(system);
  if (joined.empty()) return 0;
  system.A = system.A(joined, joined).eval();
  system.B = system.B(joined, Eigen::all).eval();
  system.C = system.C(Eigen::all, joined).eval();
  if (system.Validate().ok()) return all - system.order();
  const Eigen::MatrixXd basis = ReachedBasis(system);
  if (basis.cols() == system.order()) return all - system.order();
  system.A = (basis.transpose() * system.A * basis).eval();
  system.B = (basis.transpose() * system.B).eval();
  system.C = (system.C * basis).eval();
  return all - system.order();
}

}  // namespace mle
