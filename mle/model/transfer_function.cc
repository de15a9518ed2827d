#include "mle/model/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <utility>

#include "Eigen/Eigenvalues"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "mle/model/held_input_map.h"

namespace mle {
namespace {

constexpr int kMaxDegree = 50;
// So that settling times, multiples of it, and those of corrections are
// numbers.
constexpr double kLongestTime = 1e300;
constexpr double kLargestSquared = 1e150;
// A dead time within this fraction of a sample of a sampling instant is on it.
constexpr double kInstantTolerance = 1e-9;
// A pole whose damping ratio is smaller cannot be told from an undamped one.
constexpr double kMinDampingRatio = 1e-10;

std::vector<double> WithoutLeadingZeros(std::vector<double> coefficients) {
  const auto first = std::find_if(coefficients.begin(), coefficients.end(),
                                  [](double c) { return c != 0.0; });
  coefficients.erase(coefficients.begin(), first);
  if (coefficients.empty()) coefficients.push_back(0.0);
  return coefficients;
}

int Degree(const std::vector<double>& coefficients) {
  return static_cast<int>(coefficients.size()) - 1;
}

std::string Polynomial(const std::vector<double>& coefficients) {
  return absl::StrCat("[", absl::StrJoin(coefficients, ", "), "]");
}

// Powers of two d that bring the rows and columns of D⁻¹AD (D = diag d) to
// alike size. (Parlett and Reinsch, Numer. Math. 13, 1969.)
Eigen::VectorXd BalancingScales(Eigen::MatrixXd A) {
  const Eigen::Index n = A.rows();
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(n);
  bool changed = true;
  for (int sweep = 0; changed && sweep < 100; ++sweep) {
    changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double column = A.col(i).lpNorm<1>() - std::abs(A(i, i));
      const double row = A.row(i).lpNorm<1>() - std::abs(A(i, i));
      if (!(column > 0.0) || !(row > 0.0)) continue;
      const double f =
          std::exp2(std::round(0.5 * (std::log2(row) - std::log2(column))));
      if (column * f + row / f < 0.95 * (column + row)) {
        changed = true;
        scales(i) *= f;
        A.col(i) *= f;
        A.row(i) /= f;
      }
    }
  }
  return scales;
}

Eigen::MatrixXd Balanced(const Eigen::MatrixXd& A,
                         const Eigen::VectorXd& scales) {
  return scales.cwiseInverse().asDiagonal() * A * scales.asDiagonal();
}

// Eigenvalues of the companion matrix, after scaling time so that no
// coefficient of the monic polynomial exceeds 1.
Eigen::VectorXcd Poles(const std::vector<double>& denominator) {
  const int r = Degree(denominator);
  double log_scale = -std::numeric_limits<double>::infinity();
  const double log_leading = std::log(std::abs(denominator[0]));
  for (int i = 1; i <= r; ++i) {
    log_scale = std::max(
        log_scale, (std::log(std::abs(denominator[i])) - log_leading) / i);
  }
  if (!std::isfinite(log_scale)) return Eigen::VectorXcd::Zero(r);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(r, r);
  A.diagonal(1).setOnes();
  const double sign = std::copysign(1.0, denominator[0]);
  for (int i = 1; i <= r; ++i) {
    if (denominator[i] == 0.0) continue;
    A(r - 1, r - i) = -sign * std::copysign(1.0, denominator[i]) *
                      std::exp(std::log(std::abs(denominator[i])) -
                               log_leading - i * log_scale);
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(
      Balanced(A, BalancingScales(A)), /*computeEigenvectors=*/false);
  if (solver.info() != Eigen::Success) {
    return Eigen::VectorXcd::Constant(r,
                                      std::numeric_limits<double>::quiet_NaN());
  }
  return solver.eigenvalues() * std::exp(log_scale);
}

// The coefficients of the poles other than one at s = 0.
std::vector<double> WithoutIntegratorPole(std::vector<double> denominator) {
  if (denominator.size() > 1 && denominator.back() == 0.0) {
    denominator.pop_back();
  }
  return denominator;
}

// Every pole in the open left half-plane.
absl::Status CheckStable(const std::vector<double>& denominator) {
  const absl::Status unstable = InvalidArgument(
      "denominator ", Polynomial(denominator),
      " has a pole that is not in the open left half-plane (an unstable mode); "
      "every pole must have a negative real part, but for at most one at s = "
      "0");
  // Necessary for stability, and exact: a missing or turned sign.
  for (const double coefficient : denominator) {
    if (!(coefficient * std::copysign(1.0, denominator[0]) > 0.0)) {
      return unstable;
    }
  }
  if (denominator.size() < 3) return absl::OkStatus();  // Also sufficient.
  if (denominator.size() == 3) {
    const double damping = 0.5 * std::abs(denominator[1]) /
                           std::sqrt(std::abs(denominator[0])) /
                           std::sqrt(std::abs(denominator[2]));
    if (damping >= kMinDampingRatio) return absl::OkStatus();
    return InvalidArgument(
        "denominator ", Polynomial(denominator), " has a damping ratio of ",
        damping, "; below ", kMinDampingRatio,
        " an oscillation cannot be told from one that does not end");
  }
  for (const std::complex<double> pole : Poles(denominator)) {
    if (!(pole.real() < -kMinDampingRatio * std::abs(pole))) return unstable;
  }
  return absl::OkStatus();
}

// At most one pole at s = 0, which the numerator does not cancel; the others
// stable.
absl::Status CheckPoles(const std::vector<double>& numerator,
                        const std::vector<double>& denominator) {
  const std::vector<double> others = WithoutIntegratorPole(denominator);
  if (others.size() > 1 && others.back() == 0.0) {
    return InvalidArgument(
        "denominator ", Polynomial(denominator),
        " has more than one pole at s = 0; an element may integrate once (a "
        "level, a pressure, an inventory), not twice");
  }
  if (others.size() < denominator.size() && numerator.back() == 0.0 &&
      numerator[0] != 0.0) {
    return InvalidArgument(
        "numerator ", Polynomial(numerator), " and denominator ",
        Polynomial(denominator),
        " are both zero at s = 0; cancel the common factor s");
  }
  return CheckStable(others);
}

// The numbers the realisation is made of do not overflow, nor do products of A.
bool CanBeRealised(const TransferFunction& g) {
  const StateSpace system = g.Realize();
  const bool has_square =
      system.A.size() == 0 || system.A.cwiseAbs().maxCoeff() < kLargestSquared;
  return has_square && system.A.allFinite() && system.C.allFinite() &&
         std::isfinite(system.D) && std::isfinite(g.StaticGain()) &&
         std::isfinite(g.SlowestTimeConstant());
}

}  // namespace

TransferFunction::TransferFunction(std::vector<double> numerator,
                                   std::vector<double> denominator,
                                   double delay)
    : numerator_(WithoutLeadingZeros(std::move(numerator))),
      denominator_(WithoutLeadingZeros(std::move(denominator))),
      delay_(delay) {}

TransferFunction TransferFunction::FirstOrder(double gain, double time_constant,
                                              double delay) {
  return TransferFunction({gain}, {time_constant, 1.0}, delay);
}

TransferFunction TransferFunction::Integrator(double gain, double time_constant,
                                              double delay) {
  return TransferFunction({gain}, {time_constant, 1.0, 0.0}, delay);
}

absl::Status TransferFunction::Validate() const {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(numerator_.begin(), numerator_.end(), finite)) {
    return InvalidArgument("numerator ", Polynomial(numerator_),
                           " has a coefficient that is not finite");
  }
  if (!std::all_of(denominator_.begin(), denominator_.end(), finite)) {
    return InvalidArgument("denominator ", Polynomial(denominator_),
                           " has a coefficient that is not finite");
  }
  if (denominator_[0] == 0.0) {
    return absl::InvalidArgumentError(
        "denominator is zero; it needs a coefficient other than zero");
  }
  if (Degree(denominator_) > kMaxDegree) {
    return InvalidArgument("denominator has degree ", Degree(denominator_),
                           ", must be at most ", kMaxDegree);
  }
  if (numerator_.size() > denominator_.size()) {
    return InvalidArgument(
        "numerator ", Polynomial(numerator_), " has degree ",
        Degree(numerator_), ", denominator ", Polynomial(denominator_),
        " degree ", Degree(denominator_),
        "; the element must be proper, the numerator's degree not the larger");
  }
  if (!(delay_ >= 0.0) || !std::isfinite(delay_)) {
    return InvalidArgument("delay is ", delay_,
                           ", must be finite and not negative");
  }
  MLE_RETURN_IF_ERROR(CheckPoles(numerator_, denominator_));
  if (!CanBeRealised(*this)) {
    return InvalidArgument(
        "numerator ", Polynomial(numerator_), " over denominator ",
        Polynomial(denominator_),
        " overflows when divided by its leading or "
        "last coefficient; give the coefficients in a more even range");
  }
  if (const double time = delay_ + SlowestTimeConstant();
      !(time <= kLongestTime)) {
    return InvalidArgument("delay and slowest time constant are together ",
                           time, ", must be at most ", kLongestTime);
  }
  return absl::OkStatus();
}

bool TransferFunction::IsZero() const { return numerator_[0] == 0.0; }

int TransferFunction::IntegrationOrder() const {
  return denominator_.back() == 0.0 && !IsZero() ? 1 : 0;
}

bool TransferFunction::IsFirstOrder() const {
  return numerator_.size() == 1 && denominator_.size() == 2 &&
         denominator_[1] != 0.0;
}

bool TransferFunction::IsIntegratorWithLag() const {
  return IsIntegrating() && numerator_.size() == 1 && denominator_.size() <= 3;
}

double TransferFunction::StaticGain() const {
  return IsZero()
             ? 0.0
             : numerator_.back() / WithoutIntegratorPole(denominator_).back();
}

double TransferFunction::TimeConstant() const {
  CHECK(IsFirstOrder() || IsIntegratorWithLag());
  return SlowestTimeConstant();
}

double TransferFunction::SlowestTimeConstant() const {
  const std::vector<double> others = WithoutIntegratorPole(denominator_);
  const int r = Degree(others);
  if (r == 0) return 0.0;
  if (r == 1) return others[0] / others[1];
  return -1.0 / Poles(others).real().maxCoeff();
}

double TransferFunction::TimeToSettle() const {
  const std::vector<double> others = WithoutIntegratorPole(denominator_);
  if (Degree(others) < 2) return delay_ + 5.0 * SlowestTimeConstant();
  const Eigen::VectorXd times = -Poles(others).real().cwiseInverse();
  return delay_ + times.sum() + 4.0 * times.norm();
}

StateSpace TransferFunction::Realize() const {
  const int r = Degree(denominator_);
  const int q = Degree(numerator_);
  StateSpace system;
  system.A = Eigen::MatrixXd::Zero(r, r);
  system.B = Eigen::VectorXd::Zero(r);
  system.C = Eigen::RowVectorXd::Zero(r);
  system.D = q == r ? numerator_[0] / denominator_[0] : 0.0;
  if (r == 0) return system;
  system.A.diagonal(1).setOnes();
  system.B(r - 1) = 1.0;
  for (int i = 1; i <= r; ++i) {
    const double monic = denominator_[i] / denominator_[0];
    const int k = i - (r - q);  // The numerator's coefficient of s^{r−i}.
    const double b = k >= 0 ? numerator_[k] / denominator_[0] : 0.0;
    system.A(r - 1, r - i) = -monic;
    system.C(r - i) = b - system.D * monic;
  }
  if (r == 1) return system;
  const Eigen::VectorXd scales = BalancingScales(system.A);
  system.A = Balanced(system.A, scales);
  // The states are so scaled as a whole that B stays as it is.
  system.C = system.C.cwiseProduct(scales.transpose() / scales(r - 1)).eval();
  return system;
}

Eigen::VectorXd TransferFunction::StepResponse(double sample_time,
                                               int samples) const {
  CHECK_GT(sample_time, 0.0);
  CHECK_GE(samples, 0);
  Eigen::VectorXd response = Eigen::VectorXd::Zero(samples);
  int first = 0;  // The first sample after the dead time.
  while (first < samples &&
         first * sample_time - delay_ <= kInstantTolerance * sample_time) {
    ++first;
  }
  if (IsZero() || first == samples) return response;

  const StateSpace system = Realize();
  const HeldInputMap step = HeldInputMap::Over(sample_time, system.A, system.B);
  Eigen::VectorXd state =
      HeldInputMap::Over(first * sample_time - delay_, system.A, system.B)
          .gamma;
  for (int k = first; k < samples; ++k) {
    response(k) = system.C.dot(state) + system.D;
    state += step.E.lazyProduct(state).eval() + step.gamma;
  }
  return response;
}

}  // namespace mle
