// The maximum-likelihood fit of one output's elements. Internal to
// mle/nonlinear; the public interface is OutputErrorCorrection.
//
// Parameters are K, T and L of the free elements, the noise variance r and the
// noise shape: the ratio ρ = q/r and, where it pays, an AR component
// (noise_search.h). For a given shape the whitened residuals are minimised:
//
//   1. The dead times are searched on a grid (delay_search.h), with the time
//      scales half, as large and twice as large as at the start.
//   2. Gauss and Newton's steps refine the best of each, first with the dead
//      times free, then within the sample that each lies in, until no
//      neighbouring sample is better: a minimum may lie in a kink.
//   3. The shape is estimated anew (restricted likelihood: variation explained
//      by the parameters to first order is not noise) and 2 repeated until it
//      stays.
//   4. The grid is searched again around the end, with its time scales and
//      shape; a better combination of dead times starts 2 anew.
//   5. Ceres goes on until it finds no better point.

#ifndef MLE_NONLINEAR_OUTPUT_FIT_H_
#define MLE_NONLINEAR_OUTPUT_FIT_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/serial_correlation.h"

namespace mle {

struct OutputFitBounds {
  std::vector<double> min_time_scales;  // m
  std::vector<double> max_time_scales;
  std::vector<double> max_delays;
};

struct OutputFit {
  OutputPoint point;
  std::vector<bool> free;  // m
  NoiseEstimate noise;
  // 3m × 3m, by K, T, L of each element; zero for elements that are not free,
  // infinite on the diagonal of what the records do not determine, zero for
  // the T of an integrator without lag.
  Eigen::MatrixXd covariance;
  // The effect of correlation that the noise shape leaves on both tests and on
  // the covariance, which includes it already.
  SerialInflation inflation;
  // Degrees of freedom of each variance on the diagonal (Satterthwaite): ∞ for
  // known noise.
  Eigen::VectorXd degrees_of_freedom;
  // −2 ln likelihood less constants, maximised over r and the shape.
  double deviance = 0.0;
  FitCertificate certificate;
};

// Elements that are not `free` keep the values of `start`.
OutputFit FitOutput(const OutputErrorProblem& problem, const OutputPoint& start,
                    const std::vector<bool>& free,
                    const OutputFitBounds& bounds,
                    const OutputErrorOptions& options);

// The same continued from output i of options.start, whose lines and steps
// `problem` takes; without offsets if options.offsets has none.
OutputFit FitOutputFrom(const OutputPoint& start, const std::vector<bool>& free,
                        const OutputFitBounds& bounds,
                        const OutputErrorOptions& options, int i,
                        OutputErrorProblem& problem);

// The fit continued from `fit`, under the weights that `problem` has now.
// `search_ar`: an AR component that `fit` does not have is sought.
OutputFit Refit(const OutputErrorProblem& problem, const OutputFit& fit,
                const OutputFitBounds& bounds,
                const OutputErrorOptions& options, bool search_ar = true);

// Random errors of stamps (stamp_noise.h) and the fit under them, in turn from
// `fit`; left in `problem` and `fit`.
void FitWithStampNoise(const OutputFitBounds& bounds,
                       const OutputErrorOptions& options,
                       OutputErrorProblem& problem, OutputFit& fit);

// Weights of a robust loss and the fit under them, in turn from `fit` until
// neither moves; left in `problem` and `fit`.
void FitRobustly(const OutputFitBounds& bounds,
                 const OutputErrorOptions& options, OutputErrorProblem& problem,
                 OutputFit& fit);

// Estimates under one of several assumptions, to first order about a fit.
struct LinearEstimate {
  double weight = 1.0;
  Eigen::VectorXd change;              // 3m, of K, T, L from the fit's
  Eigen::MatrixXd covariance;          // 3m × 3m
  Eigen::VectorXd degrees_of_freedom;  // 3m, of its diagonal
};

// ρ is uncertain, and where drift is too weak to be detected its best estimate
// is 0. Estimates are therefore taken to first order about
// `fit` (an offset for each segment, its AR component) under every possible ρ,
// weighted by restricted likelihood and the prior of noise_search.h. Weights
// add up to one. One estimate where ρ is not estimated, or nothing is free.
std::vector<LinearEstimate> IntegrateRatio(const OutputErrorProblem& problem,
                                           const OutputFit& fit,
                                           bool estimate_drift);

// The elements of `fit` fitted under white noise without offsets, from there.
OutputFit FitWithoutOffsets(const OutputErrorProblem& problem,
                            const OutputFit& fit, const OutputFitBounds& bounds,
                            const OutputErrorOptions& options);

// The lines and steps of `noise` into `problem`, and those of `problem`, as
// they are at `point`, into `noise`.
void AdoptDisturbances(const NoiseEstimate& noise, OutputErrorProblem& problem);
void ReportDisturbances(const OutputErrorProblem& problem,
                        const OutputPoint& point, NoiseEstimate& noise);

inline NoiseShape ShapeOf(const NoiseEstimate& noise) {
  return {.ratio = noise.ratio,
          .offset = noise.offset,
          .ar_ratio = noise.ar_ratio,
          .ar_pole = noise.ar_pole,
          .ar_damping = noise.ar_damping};
}

// Noise of the output at `point`, by restricted likelihood, with the elements
// that are `free` taken to be estimated. Offsets are as in `start`; without
// them the shape is. An AR component is sought from that of `start`, or, if it
// has none and `search_ar`, everywhere (noise_search.h).
NoiseEstimate EstimateNoise(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const std::vector<bool>& free,
                            const NoiseEstimate& start, bool estimate_drift,
                            bool search_ar);

// The evidence against "the noise is white, without offsets" in one output.
struct OffsetEvidence {
  double offsets = 0.0;    // χ² of the offsets for ρ = 0
  double drift = 0.0;      // likelihood ratio of the walk and AR component
  int num_parameters = 0;  // offsets, and those of drift that are estimated
};

// At the fit of an output with offsets.
OffsetEvidence FindOffsetEvidence(const OutputErrorProblem& problem,
                                  const OutputPoint& point,
                                  const std::vector<bool>& free,
                                  const NoiseEstimate& noise,
                                  bool estimate_drift);

// Akaike's weight of offsets and drift in all outputs against neither in any:
// 1/(1 + exp(−ΔAIC/2)).
double OffsetWeight(const std::vector<OffsetEvidence>& evidence);

// −2 ln likelihood less constants at `point`, maximised over r, ρ and the
// AR component that `start` has, and, in first order, over the elements that
// are `free`; with an offset as in `start`.
double Deviance(const OutputErrorProblem& problem, const OutputPoint& point,
                const std::vector<bool>& free, const NoiseEstimate& start,
                bool estimate_drift);

// Two explanations of an output, the second with more parameters, under the
// same noise: an offset for each segment, one ρ and one AR component.
struct Contrast {
  // S(ρ), the reduction of the squares by the second over r, integrated over
  // the possible ρ: −2 ln Σ w(ρ) exp(−S(ρ)/2), with the weights w of
  // IntegrateRatio() for the second. ≥ 0; χ² where the first is right.
  double statistic = 0.0;
  // Degrees of freedom: the rank that the second has more.
  int degrees = 0;
};

// `null`, of restricted likelihood; and with the columns (of each segment,
// rows × k) besides, under the AR component of the second and the larger of the
// two ratios that restricted likelihood finds: one ratio for each would let the
// second explain slow drift and then call the noise white, and with weak drift
// every fourth test would raise a false alarm of one in a hundred.
Contrast ContrastWithColumns(const ShapeLikelihood& null,
                             const std::vector<Eigen::MatrixXd>& columns,
                             bool estimate_drift);

// At `null` with nothing fitted; and at the fit `point` of what is `free`, with
// the noise found there.
Contrast ContrastWithFit(const OutputErrorProblem& problem,
                         const OutputPoint& null, const OutputPoint& point,
                         const std::vector<bool>& free,
                         const NoiseEstimate& noise, bool estimate_drift);

struct OutputCovariance {
  Eigen::MatrixXd covariance;  // as above
  int rank = 0;
  double condition = 0.0;
};

// The same from JᵀJ of the whitened columns of what is free (3f × 3f), for
// r = `variance`.
OutputCovariance CovarianceOf(const OutputErrorProblem& problem,
                              const Eigen::MatrixXd& products,
                              const OutputPoint& point,
                              const std::vector<bool>& free, double variance);

// r (JᵀJ)⁻¹ at `point`, the inverse of Fisher's information.
OutputCovariance ComputeCovariance(const OutputErrorProblem& problem,
                                   const OutputPoint& point,
                                   const std::vector<bool>& free,
                                   const NoiseEstimate& noise);

// Columns at `point` for errors of the size that they have: by each dead time
// the secant over ± 3 standard errors. Under coloured noise the whitened
// derivative is all in the sample in which a response begins, and −2 ln L grows
// with |ΔL| beyond that sample, not with its square: the curvature within the
// sample would make intervals too short.
std::vector<SegmentColumns> LineariseWidely(const OutputErrorProblem& problem,
                                            const OutputPoint& point,
                                            const std::vector<bool>& free,
                                            const NoiseEstimate& noise);

// Degrees of freedom of the variances on the diagonal of the covariance (3m),
// which move with the shape's parameters and with r, all estimated:
// Satterthwaite's approximation.
Eigen::VectorXd ComputeDegreesOfFreedom(const OutputErrorProblem& problem,
                                        const OutputPoint& point,
                                        const std::vector<bool>& free,
                                        const NoiseEstimate& noise);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_FIT_H_
