#include "control/quadratic_program.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A limit holds if it is missed by no more than this part of the sizes that
// make up the value.
constexpr double kFeasibility = 1e-12;
// A row depends on those in use if no more than this part of it is left.
constexpr double kDependence = 1e-12;

}  // namespace

absl::StatusOr<QuadraticProgram> QuadraticProgram::Create(
    const MatrixXd& H, const MatrixXd& A, const VectorXd& slack_cost) {
  const Eigen::Index n = H.rows();
  const Eigen::Index r = A.rows();
  if (n < 1 || H.cols() != n || A.cols() != n || slack_cost.size() != r) {
    return InvalidArgument("quadratic programme: H is ", n, " × ", H.cols(),
                           ", A ", r, " × ", A.cols(), ", and there are ",
                           slack_cost.size(), " slack costs");
  }
  if (!((slack_cost.array() > 0.0).all())) {
    return absl::InvalidArgumentError(
        "quadratic programme: a slack cost is not positive");
  }
  const Eigen::LLT<MatrixXd> llt(H);
  if (!H.allFinite() || llt.info() != Eigen::Success) {
    return absl::InvalidArgumentError(
        "quadratic programme: H is not positive definite");
  }
  QuadraticProgram program;
  program.A_ = A;
  program.factor_ = llt.matrixU();
  program.scaled_rows_ = program.factor_.transpose()
                             .triangularView<Eigen::Lower>()
                             .solve(A.transpose())
                             .transpose();
  program.softness_ = slack_cost.cwiseInverse();
  program.diagonal_ =
      program.scaled_rows_.rowwise().squaredNorm() + program.softness_;
  for (VectorXd* v :
       {&program.lower_, &program.upper_, &program.free_values_,
        &program.values_, &program.multipliers_, &program.lambda_,
        &program.column_, &program.step_, &program.cosines_, &program.sines_}) {
    *v = VectorXd::Zero(r);
  }
  program.direction_ = program.x_ = VectorXd::Zero(n);
  program.rows_.assign(r, 0);
  program.sides_.assign(r, 0);
  program.in_use_.assign(r, 0);
  program.L_.setZero(r, r);
  return program;
}

void QuadraticProgram::ForgetActiveRows() {
  count_ = 0;
  std::fill(in_use_.begin(), in_use_.end(), 0);
}

QuadraticProgram::Summary QuadraticProgram::Solve(
    const Eigen::Ref<const VectorXd>& x0,
    const Eigen::Ref<const VectorXd>& lower,
    const Eigen::Ref<const VectorXd>& upper) {
  CHECK_EQ(x0.size(), x_.size());
  CHECK_EQ(lower.size(), A_.rows());
  CHECK_EQ(upper.size(), A_.rows());
  lower_ = lower;
  upper_ = upper;
  free_values_.noalias() = A_ * x0;

  Summary summary;
  StartFromActiveRows();
  bool possible = true;
  const int limit = 50 + 10 * static_cast<int>(A_.rows() + A_.cols());
  while (possible) {
    values_ = free_values_;
    if (count_ > 0) values_.noalias() += scaled_rows_ * direction_;
    const Violation violation = FindViolation();
    if (violation.row < 0) {
      summary.converged = true;
      break;
    }
    possible = summary.iterations < limit && AddRow(violation, summary);
  }

  // x = x₀ + R⁻¹ (R (x − x₀)).
  factor_.triangularView<Eigen::Upper>().solveInPlace(direction_);
  x_ = x0 + direction_;
  multipliers_.setZero();
  for (int k = 0; k < count_; ++k) multipliers_[rows_[k]] = lambda_[k];
  summary.active_rows = count_;
  if (!summary.converged) ForgetActiveRows();
  return summary;
}

double QuadraticProgram::Bound(int position) const {
  const int row = rows_[position];
  return sides_[position] > 0 ? upper_[row] : lower_[row];
}

// From the rows in use at the last solution: those whose multiplier, with all
// of them held as equations, has the wrong sign are dropped, worst first.
void QuadraticProgram::StartFromActiveRows() {
  for (int k = count_ - 1; k >= 0; --k) {
    if (!std::isfinite(Bound(k))) RemoveFromFactor(k);
  }
  while (count_ > 0) {
    SolveForMultipliers();
    int worst = -1;
    double most = 0.0;
    for (int k = 0; k < count_; ++k) {
      const double wrong =
          -sides_[k] * lambda_[k] * std::sqrt(diagonal_[rows_[k]]);
      if (wrong > most) {
        most = wrong;
        worst = k;
      }
    }
    if (worst < 0) break;
    RemoveFromFactor(worst);
  }
  UpdateDirection();
}

QuadraticProgram::Violation QuadraticProgram::FindViolation() const {
  Violation worst;
  const double length = direction_.norm();
  double most = 0.0;
  for (int i = 0; i < num_rows(); ++i) {
    if (in_use_[i] != 0) continue;
    const double value = values_[i];
    const double above = value - upper_[i];
    const double below = lower_[i] - value;
    const double amount = std::max(above, below);
    if (!(amount > 0.0)) continue;
    const double norm = std::sqrt(diagonal_[i]);
    const double bound = above > below ? upper_[i] : lower_[i];
    const double size =
        std::abs(bound) + std::abs(free_values_[i]) + norm * length;
    if (amount <= kFeasibility * size || norm == 0.0) continue;
    if (amount / norm > most) {
      most = amount / norm;
      worst = {i, above > below ? 1 : -1, amount};
    }
  }
  return worst;
}

// Moves the multiplier of the violated row away from zero until the row holds;
// rows whose multiplier reaches zero on the way are dropped.
bool QuadraticProgram::AddRow(Violation violation, Summary& summary) {
  const int row = violation.row;
  while (true) {
    ++summary.iterations;
    GramColumn(row);
    step_.head(count_) = column_.head(count_);
    SolveWithFactor(step_.head(count_));
    const double curvature =
        diagonal_[row] - step_.head(count_).dot(column_.head(count_));
    const double full = curvature > kDependence * diagonal_[row]
                            ? violation.amount / curvature
                            : kInfinity;
    double partial = kInfinity;
    int blocking = -1;
    for (int k = 0; k < count_; ++k) {
      const double rate = violation.side * sides_[k] * step_[k];
      if (rate <= 0.0) continue;
      const double way = std::max(sides_[k] * lambda_[k], 0.0) / rate;
      if (way < partial) {
        partial = way;
        blocking = k;
      }
    }
    if (full == kInfinity && blocking < 0) return false;
    if (full <= partial && AppendToFactor(row, violation.side)) break;
    if (blocking < 0) return false;
    lambda_.head(count_) -= partial * violation.side * step_.head(count_);
    violation.amount -= partial * std::max(curvature, 0.0);
    RemoveFromFactor(blocking);
  }
  SolveForMultipliers();
  return true;
}

// direction = −(A_W R⁻¹)ᵀ λ.
void QuadraticProgram::UpdateDirection() {
  direction_.setZero();
  for (int k = 0; k < count_; ++k) {
    direction_ -= lambda_[k] * scaled_rows_.row(rows_[k]).transpose();
  }
}

// G λ = −(b_W − A_W x₀), with one step of refinement.
void QuadraticProgram::SolveForMultipliers() {
  auto lambda = lambda_.head(count_);
  for (int k = 0; k < count_; ++k) {
    lambda[k] = free_values_[rows_[k]] - Bound(k);
  }
  SolveWithFactor(lambda);
  UpdateDirection();
  auto correction = step_.head(count_);
  for (int k = 0; k < count_; ++k) {
    const int row = rows_[k];
    correction[k] = free_values_[row] + scaled_rows_.row(row).dot(direction_) -
                    softness_[row] * lambda[k] - Bound(k);
  }
  SolveWithFactor(correction);
  lambda += correction;
  UpdateDirection();
}

void QuadraticProgram::SolveWithFactor(Eigen::Ref<VectorXd> v) const {
  for (int i = 0; i < count_; ++i) {
    v[i] = (v[i] - L_.row(i).head(i).dot(v.head(i))) / L_(i, i);
  }
  for (int i = count_ - 1; i >= 0; --i) {
    v[i] /= L_(i, i);
    v.head(i) -= v[i] * L_.row(i).head(i).transpose();
  }
}

// The products of `row` with the rows in use.
void QuadraticProgram::GramColumn(int row) {
  for (int k = 0; k < count_; ++k) {
    column_[k] = scaled_rows_.row(rows_[k]).dot(scaled_rows_.row(row));
  }
}

// Expects the row's GramColumn. False, and nothing changed, if the row depends
// on those in use.
bool QuadraticProgram::AppendToFactor(int row, int side) {
  auto last = L_.row(count_);
  for (int i = 0; i < count_; ++i) {
    last[i] = (column_[i] - L_.row(i).head(i).dot(last.head(i))) / L_(i, i);
  }
  const double pivot = diagonal_[row] - last.head(count_).squaredNorm();
  if (!(pivot > kDependence * diagonal_[row])) return false;
  last[count_] = std::sqrt(pivot);
  rows_[count_] = row;
  sides_[count_] = side;
  in_use_[row] = 1;
  ++count_;
  return true;
}

// The rows below move up; rotations of neighbouring columns restore the
// triangle, row by row, each row fixing the rotation that those below it need.
void QuadraticProgram::RemoveFromFactor(int position) {
  in_use_[rows_[position]] = 0;
  for (int i = position + 1; i < count_; ++i) {
    rows_[i - 1] = rows_[i];
    sides_[i - 1] = sides_[i];
    lambda_[i - 1] = lambda_[i];
    L_.row(i - 1).head(i + 1) = L_.row(i).head(i + 1);
  }
  --count_;
  for (int i = position; i < count_; ++i) {
    double* const row = L_.row(i).data();
    for (int j = position; j < i; ++j) {
      const double first = row[j];
      const double second = row[j + 1];
      row[j] = cosines_[j] * first + sines_[j] * second;
      row[j + 1] = cosines_[j] * second - sines_[j] * first;
    }
    const double length = std::hypot(row[i], row[i + 1]);
    cosines_[i] = row[i] / length;
    sines_[i] = row[i + 1] / length;
    row[i] = length;
  }
}

}  // namespace mle::control
