#include "mle/filter/disturbance_system.h"

#include <cmath>

#include "Eigen/LU"
#include "glog/logging.h"
#include "mle/nonlinear/ar_component.h"

namespace mle {
namespace {

// Each squares what is left: 2^60 samples.
constexpr int kMostDoublings = 60;
constexpr double kSmallStep = 1e-15;

DisturbanceSystem EverySample(const NoiseEstimate& noise) {
  const bool coloured = noise.ar_ratio > 0.0;
  const ArComponent ar(coloured ? noise.ar_pole : 0.0,
                       coloured ? noise.ar_damping : 0.0);
  const Eigen::Index n = coloured ? 1 + ar.order() : 1;
  DisturbanceSystem system{.A = StateMatrix::Zero(n, n),
                           .C = StateRow::Zero(n),
                           .Q = StateMatrix::Zero(n, n),
                           .noise_variance = noise.variance};
  system.A(0, 0) = 1.0;
  system.C(0) = 1.0;
  system.Q(0, 0) = noise.increment_variance();
  if (!coloured) return system;
  const ArComponent::Power step = ar.After(1);
  system.A(1, 1) = step.own;
  system.C(1) = 1.0;
  if (n == 3) {
    system.A(1, 2) = step.cross;
    system.A(2, 1) = ar.spread() * step.cross;
    system.A(2, 2) = step.own;
  }
  system.Q(n - 1, n - 1) = noise.ar_ratio * noise.variance;
  return system;
}

DisturbanceSystem WalkBehindLag(const NoiseEstimate& noise, double lag) {
  DisturbanceSystem system{.A = StateMatrix::Identity(2, 2),
                           .C = Eigen::RowVector2d(0.0, 1.0),
                           .Q = StateMatrix::Zero(2, 2),
                           .noise_variance = noise.variance};
  system.A(1, 0) = -std::expm1(-1.0 / lag);
  system.A(1, 1) = std::exp(-1.0 / lag);
  system.Q(0, 0) = noise.increment_variance();
  return system;
}

}  // namespace

DisturbanceSystem SystemOf(const NoiseEstimate& noise, int samples,
                           double walk_lag) {
  CHECK_GE(samples, 1);
  const DisturbanceSystem one =
      walk_lag > 0.0 ? WalkBehindLag(noise, walk_lag) : EverySample(noise);
  DisturbanceSystem system = one;
  for (int i = 1; i < samples; ++i) {
    system.Q = (one.A * system.Q * one.A.transpose() + one.Q).eval();
    system.A = (one.A * system.A).eval();
  }
  return system;
}

std::vector<double> Autocovariances(const NoiseEstimate& noise, int samples) {
  constexpr int kMostLags = 1000;
  constexpr double kNoCorrelation = 1e-4;
  std::vector<double> covariances;
  if (!(noise.ar_ratio > 0.0)) return covariances;
  const ArComponent ar(noise.ar_pole, noise.ar_damping);
  const ArComponent::Covariance now = ar.Stationary();
  const double shocks = noise.ar_ratio * noise.variance;
  for (int h = 0; h < kMostLags; ++h) {
    const ArComponent::Power later = ar.After(h * samples);
    covariances.push_back(shocks * (later.own * now.aa + later.cross * now.ab));
    if (std::abs(covariances.back()) < kNoCorrelation * covariances.front()) {
      break;
    }
  }
  return covariances;
}

StateMatrix StationaryCovariance(const StateMatrix& A, const StateMatrix& Q) {
  StateMatrix sum = Q;
  StateMatrix power = A;
  for (int i = 0; i < kMostDoublings; ++i) {
    const StateMatrix more = power * sum * power.transpose();
    sum += more;
    if (more.norm() <= kSmallStep * sum.norm()) break;
    power = (power * power).eval();
  }
  return sum;
}

LevelAndRest Separate(const DisturbanceSystem& system) {
  const Eigen::Index n = system.order();
  const Eigen::Index rest = n - 1;
  LevelAndRest parts{.level = StateVector::Zero(n),
                     .B = system.A.bottomRightCorner(rest, rest)};
  parts.level(0) = 1.0;
  if (rest > 0) {
    parts.level.tail(rest) = (StateMatrix::Identity(rest, rest) - parts.B)
                                 .partialPivLu()
                                 .solve(system.A.col(0).tail(rest));
  }
  // (ξ, η) = T ω.
  StateMatrix T = StateMatrix::Identity(n, n);
  T.col(0).tail(rest) = -parts.level.tail(rest);
  parts.N = T * system.Q * T.transpose();
  return parts;
}

StationaryFilter SolveStationaryFilter(const DisturbanceSystem& system) {
  CHECK_GT(system.noise_variance, 0.0);
  CHECK_GT(system.Q(0, 0), 0.0);
  const Eigen::Index n = system.order();
  // In units of r.
  const double r = system.noise_variance;
  StateMatrix A = system.A.transpose();
  StateMatrix G = system.C.transpose() * system.C;
  StateMatrix P = system.Q / r;
  for (int i = 0; i < kMostDoublings; ++i) {
    const Eigen::PartialPivLU<StateMatrix> W(StateMatrix::Identity(n, n) +
                                             G * P);
    const StateMatrix WA = W.solve(A);
    const StateMatrix step = A.transpose() * P * WA;
    G += (A * W.solve(G) * A.transpose()).eval();
    A = (A * WA).eval();
    P += 0.5 * (step + step.transpose());
    if (step.norm() <= kSmallStep * P.norm()) break;
  }
  StationaryFilter filter;
  const StateVector PC = P * system.C.transpose();
  const double F = system.C.dot(PC) + 1.0;
  filter.gain = system.A * PC / F;
  const StateMatrix left = system.A * P * system.A.transpose() -
                           filter.gain * filter.gain.transpose() * F +
                           system.Q / r - P;
  filter.residual = left.cwiseAbs().maxCoeff() / P.cwiseAbs().maxCoeff();
  filter.covariance = r * P;
  filter.innovation_variance = r * F;
  return filter;
}

}  // namespace mle
