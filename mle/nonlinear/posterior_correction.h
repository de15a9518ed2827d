// The completion of a process model's structure by what it lacks. Every element
// keeps its parametric form K e^{−Ls} g₀(Ts) and gets an addition h to its
// impulse response,
//
//   y_i = offset + Σ_j (g_ij(K, T, L) + h_ij) u_j + free response + noise,
//
// zero where the structure suffices. A pair that is absent in the model may
// become present by h alone. Priors of an element:
//
//   K ~ N(K₀, K₀²), ln T ~ N(ln T₀, 0.7²), L ~ N(L₀, (0.5 (T₀ + L₀))²)
//     with probability 1/5, else K₀, T₀, L₀;
//   h = 0 with probability 19/20 (99/100 where the pair is absent), else the TC
//     kernel Cov(h(s), h(t)) = σ² K₀² e^{−max(s,t)/τ} / (2τ²)
//
// from a start before the dead time on, so that σ is the standard deviation of
// the gain that h adds, in gains; σ is 0.01 … 10, τ a quarter of T₀ to twice
// T₀. (Chen, Ohlsson and Ljung, Automatica 48, 2012; Pillonetto, Dinuzzo, Chen,
// De Nicolao and Ljung, Automatica 50, 2014: there the kernel is of the whole
// response; here it is of the mismatch.)
//
// Which parts are there, σ, τ and the noise maximise the evidence, output by
// output. Where no output's evidence speaks for an h, the output-error
// correction stands as it is. In directions in which records are silent the
// posterior is the prior model, and its band says so.
//
//   MLE_ASSIGN_OR_RETURN(const PosteriorCorrection posterior,
//                        CompleteByPosterior(model, windows, output_error,
//                                            OutputErrorOptions()));
//   if (posterior.any()) use(posterior.model);
//
// docs/posterior.md has how it is computed and measured figures.

#ifndef MLE_NONLINEAR_POSTERIOR_CORRECTION_H_
#define MLE_NONLINEAR_POSTERIOR_CORRECTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/element_response.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// One element of an output that needs an h.
struct ElementPosterior {
  // Whether K, T, L or h differ from the initial ones, whether h is there.
  bool changed = false;
  bool reshaped = false;
  double change_probability = 0.0;
  double shape_probability = 0.0;
  ElementValues initial{.gain = 0.0, .time_scale = 0.0, .delay = 0.0};
  ElementValues values;      // K, T and L that h adds to
  double time_unit = 0.0;    // that τ is measured by
  double shape_scale = 0.0;  // σ
  // Means of K, ln T, L less `values`, then of the increments of h (rows of
  // StepBasis()).
  Eigen::VectorXd means;
  Eigen::MatrixXd covariance;
  // ‖mean response − that of the model's element‖ / ‖mean response‖, of an
  // element that integrates less their ramp.
  double reduction_error = 0.0;

  // The mean of K, to which the static gain of h adds.
  double MeanGain() const { return values.gain + means(0); }
};

struct OutputShapes {
  bool needed = false;  // if not, the output-error correction's row stands
  NoiseEstimate noise;
  double decay = 0.0;           // τ in units of each element's T₀
  std::vector<int> first_lags;  // of h's ranges, and the end of the last
  std::vector<int> starts;      // m: first lag of h
  std::vector<ElementPosterior> elements;  // m
};

struct PosteriorCorrection {
  // The output-error correction's model, and in outputs that need an h the
  // posterior mean by elements of low order (rational_fit.h).
  ProcessModel model;
  std::vector<OutputShapes> outputs;  // p
  double sample_time = 0.0;

  bool any() const;
  // Puts the posterior's elements into the rows of `output_error` that need an
  // h: model, `aged` and, of each element, the static gain (slope) of its
  // posterior mean and K, T and L of the element of the model's own shape
  // nearest to that (least squares of the step responses), with the posterior's
  // errors.
  void Describe(const ProcessModel& initial, double confidence,
                OutputErrorCorrection& output_error) const;
  // Posterior mean and standard deviation of the step response of an element
  // of an output that needs an h, at 0, Δt, …
  Eigen::VectorXd MeanStep(const ProcessModel& initial, int output, int input,
                           int samples) const;
  Eigen::VectorXd StepErrors(const ProcessModel& initial, int output, int input,
                             int samples) const;
};

// `output_error` is that of the same model and windows; `outputs`, p or empty
// for all, are those whose structure may lack something (WrongOutputs() of
// model_adequacy.h). Errors are those of CorrectByOutputError().
absl::StatusOr<PosteriorCorrection> CompleteByPosterior(
    const ProcessModel& initial, const std::vector<Record>& windows,
    const OutputErrorFit& output_error, const OutputErrorOptions& options,
    const std::vector<bool>& outputs = {});

}  // namespace mle

#endif  // MLE_NONLINEAR_POSTERIOR_CORRECTION_H_
