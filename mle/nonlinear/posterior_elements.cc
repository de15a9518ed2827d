#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/QR"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/posterior_correction.h"

namespace mle {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// samples × (3 + ranges): what K, ln T, L and each increment do to a step
// response at 0, Δt, …
MatrixXd StepBasis(const TransferFunction& initial, const ElementValues& values,
                   const std::vector<int>& first_lags, int start,
                   double sample_time, int samples) {
  const auto ranges = static_cast<Eigen::Index>(first_lags.size()) - 1;
  MatrixXd basis = MatrixXd::Zero(samples, 3 + ranges);
  const auto response = ElementResponse::Create(initial);
  if (response.ok()) {
    const int whole = static_cast<int>(values.delay / sample_time);
    MatrixXd columns(samples, 3);
    response->Simulate(
        values.time_scale, sample_time,
        {whole, std::clamp(values.delay / sample_time - whole, 0.0, 1.0)},
        VectorXd::Ones(samples), 0.0, columns);
    basis.col(0) = columns.col(0);
    basis.middleCols(1, 2) = values.gain * columns.rightCols(2);
  }
  // An increment of range b adds to h from the first range's begin to b's end.
  const int before =
      *std::lower_bound(first_lags.begin(), first_lags.end(), start) - 1;
  for (Eigen::Index b = 0; b < ranges; ++b) {
    if (first_lags[b] < start) continue;
    for (int k = 0; k < samples; ++k) {
      basis(k, 3 + b) = std::clamp(k, before, first_lags[b + 1] - 1) - before;
    }
  }
  return basis;
}

// The element of the shape of `initial` whose step response is nearest to
// `mean`, by Gauss and Newton's steps from `values` (of first order where there
// is no initial shape), and the basis (samples × 3) at it.
struct NearestStep {
  ElementValues values;
  MatrixXd basis;
};

NearestStep FindNearest(const TransferFunction& shape, ElementValues values,
                        const VectorXd& mean, double sample_time) {
  constexpr int kMaxSteps = 50;
  constexpr double kMaxLogStep = 0.3;
  const int samples = static_cast<int>(mean.size());
  // Steps may be of any size where the response hardly shows a parameter.
  const double latest = sample_time * (samples - 1);
  values.delay = std::min(values.delay, latest);
  const auto at = [&](const ElementValues& v) {
    return StepBasis(shape, v, {1}, 1, sample_time, samples);
  };
  NearestStep nearest = {values, at(values)};
  const auto squares = [&](const NearestStep& n) {
    return (mean - n.values.gain * n.basis.col(0)).squaredNorm();
  };
  double best = squares(nearest);
  double damping = 1e-6;
  for (int step = 0; step < kMaxSteps; ++step) {
    MatrixXd normal = nearest.basis.transpose() * nearest.basis;
    normal.diagonal() *= 1.0 + damping;
    const VectorXd change = normal.ldlt().solve(
        nearest.basis.transpose() *
        (mean - nearest.values.gain * nearest.basis.col(0)));
    if (!change.allFinite()) break;
    NearestStep next;
    next.values = {
        nearest.values.gain + change(0),
        nearest.values.time_scale *
            std::exp(std::clamp(change(1), -kMaxLogStep, kMaxLogStep)),
        std::clamp(nearest.values.delay + change(2), 0.0, latest)};
    next.basis = at(next.values);
    const double value = squares(next);
    const bool better = value < best;
    damping = better ? std::max(0.1 * damping, 1e-9) : 10.0 * damping;
    const bool done = better && value > best * (1.0 - 1e-9);
    if (better) {
      best = value;
      nearest = std::move(next);
    }
    if (done || damping > 1e6) break;
  }
  return nearest;
}

ParameterEstimate Held(double initial) {
  return {.initial = initial,
          .value = initial,
          .standard_error = 0.0,
          .lower = initial,
          .upper = initial};
}

ParameterEstimate Between(double initial, double value, double variance,
                          double quantile) {
  const double error = std::sqrt(std::max(variance, 0.0));
  return {.initial = initial,
          .value = value,
          .standard_error = error,
          .lower = value - quantile * error,
          .upper = value + quantile * error};
}

// The step basis of an element that the posterior has.
MatrixXd BasisOf(const PosteriorCorrection& posterior,
                 const ProcessModel& initial, int i, int j, int samples) {
  const OutputShapes& shapes = posterior.outputs[i];
  return StepBasis(initial.element(i, j), shapes.elements[j].values,
                   shapes.first_lags, shapes.starts[j], posterior.sample_time,
                   samples);
}

// Gain, time scale and dead time of the posterior mean, and their covariance.
struct NearestElement {
  ElementValues values;
  Matrix3d covariance;
};

NearestElement Nearest(const PosteriorCorrection& posterior,
                       const ProcessModel& initial, int i, int j) {
  const OutputShapes& shapes = posterior.outputs[i];
  const ElementPosterior& element = shapes.elements[j];
  const bool present = !initial.element(i, j).IsZero();
  const TransferFunction shape =
      present ? initial.element(i, j)
              : TransferFunction::FirstOrder(1.0, element.time_unit, 0.0);
  const int samples = shapes.first_lags.back() + 1;
  const VectorXd mean = posterior.MeanStep(initial, i, j, samples);
  // h adds to a static gain, and nothing to a slope.
  const bool ramp = initial.element(i, j).IsIntegrating();
  const double gain = ramp ? element.MeanGain() : mean(samples - 1);
  const NearestStep nearest = FindNearest(
      shape, present ? element.values : ElementValues{gain, element.time_unit},
      mean, posterior.sample_time);
  const MatrixXd all = BasisOf(posterior, initial, i, j, samples);
  // The effect of an error of the response on the nearest K, ln T and L.
  MatrixXd errors = nearest.basis.colPivHouseholderQr().solve(all);
  errors.row(0) = ramp ? Eigen::RowVectorXd::Unit(all.cols(), 0)
                       : Eigen::RowVectorXd(all.row(samples - 1));
  errors.row(1) *= nearest.values.time_scale;
  return {{gain, nearest.values.time_scale, nearest.values.delay},
          errors * element.covariance * errors.transpose()};
}

}  // namespace

void PosteriorCorrection::Describe(const ProcessModel& initial,
                                   double confidence,
                                   OutputErrorCorrection& output_error) const {
  const double quantile = StudentTwoSidedQuantile(1.0 - confidence, kInfinity);
  const int m = initial.num_inputs();
  OutputErrorFit& fit = output_error.corrected;
  for (int i = 0; i < initial.num_outputs(); ++i) {
    if (!outputs[i].needed) continue;
    fit.noise[i] = outputs[i].noise;
    fit.covariances[i].setZero(3 * m, 3 * m);
    for (int j = 0; j < m; ++j) {
      const ElementPosterior& element = outputs[i].elements[j];
      const ElementValues& before = element.initial;
      ElementEstimate& estimate = fit.elements[i * m + j];
      fit.model.element(i, j) = model.element(i, j);
      output_error.aged(i, j) = element.changed;
      if (!element.changed) {
        if (estimate.state == ElementState::kFitted) {
          estimate.state = ElementState::kHeld;
        }
        estimate.gain = Held(before.gain);
        estimate.time_scale = Held(before.time_scale);
        estimate.delay = Held(before.delay);
        continue;
      }
      const auto [values, covariance] = Nearest(*this, initial, i, j);
      fit.covariances[i].block(3 * j, 3 * j, 3, 3) = covariance;
      estimate.state = ElementState::kFitted;
      estimate.gain =
          Between(before.gain, values.gain, covariance(0, 0), quantile);
      estimate.time_scale = Between(before.time_scale, values.time_scale,
                                    covariance(1, 1), quantile);
      estimate.delay =
          Between(before.delay, values.delay, covariance(2, 2), quantile);
    }
  }
}

VectorXd PosteriorCorrection::MeanStep(const ProcessModel& initial, int output,
                                       int input, int samples) const {
  const ElementPosterior& element = outputs[output].elements[input];
  const MatrixXd basis = BasisOf(*this, initial, output, input, samples);
  return basis.col(0) * element.values.gain + basis * element.means;
}

VectorXd PosteriorCorrection::StepErrors(const ProcessModel& initial,
                                         int output, int input,
                                         int samples) const {
  const ElementPosterior& element = outputs[output].elements[input];
  const MatrixXd basis = BasisOf(*this, initial, output, input, samples);
  return (basis * element.covariance)
      .cwiseProduct(basis)
      .rowwise()
      .sum()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

}  // namespace mle
