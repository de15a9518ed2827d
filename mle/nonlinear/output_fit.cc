#include "mle/nonlinear/output_fit.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fitter.h"
#include "mle/nonlinear/robust_loss.h"
#include "mle/nonlinear/stamp_noise.h"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

using Eigen::VectorXd;

constexpr int kMaxNoiseRounds = 8;
constexpr int kMaxSearchRounds = 5;
constexpr int kMaxRobustRounds = 30;
constexpr int kMaxStampRounds = 4;
constexpr double kStampTolerance = 0.1;
// A shape stays where logarithms of ρ, σ and 1 − φ move less, or where ratios
// are below any effect.
constexpr double kShapeTolerance = 0.02;
// A move of an input has an effect for dead time + this many time scales.
constexpr double kMoveTimeScales = 5.0;

// Whether an AR component is sought. Bursts of outliers look like one, and what
// is taken for one is not down-weighted: a robust loss finds its
// weights first.
bool MayHaveAr(const OutputErrorProblem& problem,
               const OutputErrorOptions& options) {
  if (options.start != nullptr) return false;
  return options.robust_loss == RobustLoss::kNone ||
         problem.weights().size() > 0;
}

// Noise that has been searched everywhere: from it drift is sought downhill,
// from the least that matters where there was none.
NoiseEstimate Known(const OutputErrorProblem& problem, NoiseEstimate noise) {
  if (noise.offset && !(noise.ar_ratio > 0.0)) {
    noise.ratio = std::max(noise.ratio, LeastRatio(problem));
  }
  return noise;
}

bool SameShape(const NoiseEstimate& a, const NoiseEstimate& b) {
  const auto same = [](double x, double y) {
    const double floor = 1e-10;
    return std::abs(std::log((x + floor) / (y + floor))) < kShapeTolerance;
  };
  return a.offset == b.offset && same(a.ratio, b.ratio) &&
         same(a.ar_ratio, b.ar_ratio) &&
         same(1.0 - a.ar_pole, 1.0 - b.ar_pole) &&
         same(a.ar_damping, b.ar_damping);
}

// Steps 2 to 5 and what is reported, from `fit`'s values and noise.
void Finish(const OutputErrorProblem& problem,
            const OutputErrorOptions& options, bool search_ar, Fitter& fitter,
            OutputFit& fit) {
  const bool part = options.start != nullptr;
  for (int round = 0; round < kMaxSearchRounds; ++round) {
    double cost = 0.0;
    for (int again = 0; again < kMaxNoiseRounds; ++again) {
      const NoiseEstimate former = fit.noise;
      const bool first = round == 0 && again == 0 && !part;
      fit.noise = EstimateNoise(
          problem, fit.point, fit.free, first ? former : Known(problem, former),
          options.estimate_drift, again == 1 && search_ar);
      if (again > 0 && ShapeOf(fit.noise) == ShapeOf(former)) break;
      cost = fitter.RefineRoughly(fit.point, ShapeOf(fit.noise),
                                  /*near=*/again > 0 || part);
      if (again > 0 && SameShape(former, fit.noise)) break;
    }
    // The start of a fit to parts of the records was confirmed by all of them,
    // and parts need no certificate.
    if (part) break;
    const OutputPoint found =
        fitter.Search(fit.point, ShapeOf(fit.noise)).point;
    const double found_cost = fitter.CostOf(found, ShapeOf(fit.noise));
    const auto better = [&] { return found_cost < cost * (1.0 - 1e-9); };
    const bool last = round + 1 == kMaxSearchRounds;
    if (last || !better()) {
      cost = fitter.RefineExactly(fit.point, ShapeOf(fit.noise));
    }
    fitter.SetConfirmed(!better());
    if (last || !better()) break;
    fit.point = found;
  }
  fit.noise = EstimateNoise(problem, fit.point, fit.free,
                            Known(problem, fit.noise), options.estimate_drift,
                            /*search_ar=*/false);
  fitter.CertifyGradient(fit.point, fit.noise);
}

// The samples for which a move of an input has an effect.
int LongestMemory(const OutputErrorProblem& problem, const OutputFit& fit) {
  double longest = 0.0;
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    if (!fit.free[j]) continue;
    const ElementValues& values = fit.point.values[j];
    longest =
        std::max(longest, values.delay + kMoveTimeScales * values.time_scale);
  }
  return static_cast<int>(std::min(longest / problem.sample_time(), 1e9));
}

void FillIn(const OutputErrorProblem& problem,
            const OutputErrorOptions& options, FitCertificate certificate,
            OutputFit& fit) {
  const WhitenedColumns whitened =
      problem.Whiten(LineariseWidely(problem, fit.point, fit.free, fit.noise),
                     ShapeOf(fit.noise));
  const OutputCovariance covariance =
      CovarianceOf(problem, GramMatrix(whitened.jacobian), fit.point, fit.free,
                   fit.noise.variance);
  fit.inflation = InflationOf(problem, fit.point, whitened, fit.free,
                              ShapeOf(fit.noise), LongestMemory(problem, fit));
  fit.noise.inflation = fit.inflation.statistic;
  fit.noise.samples_at_rest =
      problem.at_rest() != nullptr ? problem.at_rest()->num_samples() : 0;
  fit.covariance = fit.inflation.Scale(covariance.covariance);
  fit.degrees_of_freedom =
      ComputeDegreesOfFreedom(problem, fit.point, fit.free, fit.noise);
  // For what is compared with other fits to the same records.
  if (options.start == nullptr) {
    fit.deviance = Deviance(problem, fit.point, fit.free,
                            Known(problem, fit.noise), options.estimate_drift);
  }
  certificate.condition = covariance.condition;
  certificate.rank = covariance.rank;
  certificate.num_parameters =
      static_cast<int>(problem.FreeParameters(fit.free).size());
  fit.certificate = certificate;
}

FitCertificate NothingFree() {
  FitCertificate certificate;
  certificate.termination = FitTermination::kConverged;
  certificate.message = "no parameter is free";
  certificate.gradient = 0.0;
  certificate.search_confirmed = true;
  return certificate;
}

// The weights at `fit`; returns by how much any of them moves.
double Reweight(RobustLoss loss, const OutputFit& fit,
                OutputErrorProblem& problem) {
  VectorXd residuals = problem.WhiteResiduals(fit.point, ShapeOf(fit.noise));
  const VectorXd& stamps = problem.stamp_weights();
  if (stamps.size() > 0) residuals.array() *= stamps.array().sqrt();
  RobustWeights robust = ComputeRobustWeights(loss, residuals);
  if (stamps.size() > 0) robust.weights.array() *= stamps.array();
  const VectorXd former = problem.weights().size() > 0
                              ? problem.weights()
                              : VectorXd::Ones(robust.weights.size());
  problem.SetWeights(robust.weights, robust.variance_factor);
  return (robust.weights - former).cwiseAbs().maxCoeff();
}

}  // namespace

OutputFit FitOutput(const OutputErrorProblem& problem, const OutputPoint& start,
                    const std::vector<bool>& free,
                    const OutputFitBounds& bounds,
                    const OutputErrorOptions& options) {
  OutputFit fit;
  fit.free = free;
  fit.point = start;
  fit.point.SetCells(problem.sample_time());
  // At the start the model's error would be taken for an AR component.
  const bool any = std::find(free.begin(), free.end(), true) != free.end();
  fit.noise = EstimateNoise(problem, fit.point, free, NoiseEstimate(),
                            options.estimate_drift,
                            !any && MayHaveAr(problem, options));
  Fitter fitter(problem, fit.free, bounds, options);
  if (!any) {
    FillIn(problem, options, NothingFree(), fit);
    return fit;
  }
  fit.point = fitter.Start(fit.point, ShapeOf(fit.noise));
  Finish(problem, options, MayHaveAr(problem, options), fitter, fit);
  FillIn(problem, options, fitter.certificate(), fit);
  return fit;
}

OutputFit FitOutputFrom(const OutputPoint& start, const std::vector<bool>& free,
                        const OutputFitBounds& bounds,
                        const OutputErrorOptions& options, int i,
                        OutputErrorProblem& problem) {
  AdoptDisturbances(options.start->full.noise[i], problem);
  OutputFit fit;
  fit.free = free;
  fit.noise = options.start->full.noise[i];
  if (options.offsets == WindowOffsets::kNever && !problem.is_integrating()) {
    fit.noise = NoiseEstimate();
    fit.noise.offset = false;
  } else {
    fit.noise.offset = true;
  }
  fit.point = start;
  for (int j = 0; j < problem.num_elements(); ++j) {
    if (!free[j]) continue;
    const ElementEstimate& element = options.start->full.element(i, j);
    if (element.state != ElementState::kFitted) continue;
    ElementValues& values = fit.point.values[j];
    values.gain = element.gain.value;
    values.delay = std::clamp(element.delay.value, 0.0, bounds.max_delays[j]);
    if (!problem.elements()[j]->has_time_scale()) continue;
    values.time_scale =
        std::clamp(element.time_scale.value, bounds.min_time_scales[j],
                   bounds.max_time_scales[j]);
  }
  fit.point.SetCells(problem.sample_time());
  fit.certificate.num_parameters =
      static_cast<int>(problem.FreeParameters(free).size());
  if (fit.certificate.num_parameters == 0) {
    fit.certificate = NothingFree();
  }
  return Refit(problem, fit, bounds, options);
}

namespace {

// Steps 2 to 5 from `fit`, and their certificate.
FitCertificate Continue(const OutputErrorProblem& problem,
                        const OutputFitBounds& bounds,
                        const OutputErrorOptions& options, bool search_ar,
                        OutputFit& fit) {
  FitCertificate certificate = fit.certificate;
  if (fit.certificate.num_parameters > 0) {
    Fitter fitter(problem, fit.free, bounds, options);
    Finish(problem, options, search_ar, fitter, fit);
    certificate = fitter.certificate();
  } else {
    fit.noise = EstimateNoise(problem, fit.point, fit.free, fit.noise,
                              options.estimate_drift, search_ar);
  }
  certificate.weight_change = fit.certificate.weight_change;
  return certificate;
}

}  // namespace

OutputFit Refit(const OutputErrorProblem& problem, const OutputFit& fit,
                const OutputFitBounds& bounds,
                const OutputErrorOptions& options, bool search_ar) {
  OutputFit again = fit;
  const FitCertificate certificate =
      Continue(problem, bounds, options,
               search_ar && MayHaveAr(problem, options), again);
  FillIn(problem, options, certificate, again);
  return again;
}

OutputFit FitWithoutOffsets(const OutputErrorProblem& problem,
                            const OutputFit& fit, const OutputFitBounds& bounds,
                            const OutputErrorOptions& options) {
  OutputFit plain = fit;
  plain.noise = NoiseEstimate();
  plain.noise.offset = false;
  if (fit.certificate.num_parameters == 0) {
    return Refit(problem, plain, bounds, options);
  }
  // The dead times lie where they lay: no grid is searched.
  Fitter fitter(problem, plain.free, bounds, options);
  fitter.RefineRoughly(plain.point, ShapeOf(plain.noise), /*near=*/false);
  if (options.start == nullptr) {
    fitter.RefineExactly(plain.point, ShapeOf(plain.noise));
  }
  plain.noise = EstimateNoise(problem, plain.point, plain.free, plain.noise,
                              options.estimate_drift,
                              /*search_ar=*/false);
  fitter.CertifyGradient(plain.point, plain.noise);
  fitter.SetConfirmed(fit.certificate.search_confirmed);
  FitCertificate certificate = fitter.certificate();
  certificate.weight_change = fit.certificate.weight_change;
  FillIn(problem, options, certificate, plain);
  return plain;
}

void FitWithStampNoise(const OutputFitBounds& bounds,
                       const OutputErrorOptions& options,
                       OutputErrorProblem& problem, OutputFit& fit) {
  for (int round = 0; round < kMaxStampRounds; ++round) {
    const double former = problem.stamp_deviation();
    FindStampNoise(fit, problem);
    const double found = problem.stamp_deviation();
    if (found == 0.0 && former == 0.0) return;
    fit = Refit(problem, fit, bounds, options, MayHaveAr(problem, options));
    if (std::abs(found - former) <= kStampTolerance * found) return;
  }
}

void FitRobustly(const OutputFitBounds& bounds,
                 const OutputErrorOptions& options, OutputErrorProblem& problem,
                 OutputFit& fit) {
  if (problem.num_segments() == 0) return;
  Fitter fitter(problem, fit.free, bounds, options);
  const bool parameters = fit.certificate.num_parameters > 0;
  FitCertificate certificate = fit.certificate;
  double change = kInfinity;
  for (int search = 0; search < kMaxSearchRounds && change > kWeightTolerance;
       ++search) {
    // Weights from nearby, then the search for dead times once more.
    for (int round = 0; round < kMaxRobustRounds; ++round) {
      change = Reweight(options.robust_loss, fit, problem);
      if (change <= kWeightTolerance) break;
      fit.noise = EstimateNoise(problem, fit.point, fit.free, fit.noise,
                                options.estimate_drift,
                                /*search_ar=*/false);
      if (parameters) {
        fitter.RefineRoughly(fit.point, ShapeOf(fit.noise), /*near=*/true);
      }
    }
    certificate =
        Continue(problem, bounds, options, MayHaveAr(problem, options), fit);
    certificate.num_parameters = fit.certificate.num_parameters;
    change = Reweight(options.robust_loss, fit, problem);
  }
  FillIn(problem, options, certificate, fit);
  // At the weights of the final residuals: the robust loss's own gradient.
  if (parameters) {
    fitter.CertifyGradient(fit.point, fit.noise);
    fit.certificate.gradient = fitter.certificate().gradient;
  }
  fit.certificate.weight_change = change;
}

}  // namespace mle
