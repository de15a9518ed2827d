// The posterior of one output's elements where their structure may lack
// something. Internal to mle/nonlinear; the public interface is
// posterior_correction.h, which has the model and the priors.
//
// Everything is linear about a point θ̂ but for K, T and L themselves: the
// columns are the derivatives by K, ln T and L of each element and, for its
// addition h, the sums of its input over the lags first_lags[0] … first_lags[b]
// (a step of h back from lag first_lags[b + 1] on: the increments of a TC
// kernel are independent, so that its covariance is diagonal in them). Which
// elements change, the scales of h and their decay are found by coordinate
// search on the evidence (linear_evidence.h); then θ̂ moves to its posterior
// mean, the noise is estimated anew, and so on until θ̂ stays.

#ifndef MLE_NONLINEAR_SHAPE_POSTERIOR_H_
#define MLE_NONLINEAR_SHAPE_POSTERIOR_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {

// The prior of an element.
struct ElementPrior {
  bool informed = false;    // its input moves; if not, it stays as it is
  bool present = false;     // it has values; if not, it can only be added
  ElementValues values;     // of the initial model
  double gain_scale = 0.0;  // what its gain is measured by, > 0
  // The unit of the gain that h adds, > 0: `gain_scale` or, for an element that
  // integrates, what its slope makes in a time scale.
  double shape_scale = 0.0;
  double time_scale = 0.0;  // what the decay of h is measured by, > 0
  int first_lag = 1;        // h is zero before
};

// Which of an element's parts are free.
struct ElementChoice {
  bool parameters = false;  // K, T and L
  double shape = 0.0;       // σ, the scale of h; 0: none
};

struct OutputPosterior {
  OutputPoint point;  // θ̂
  NoiseEstimate noise;
  std::vector<ElementChoice> choices;  // m
  double decay = 1.0;                  // of h, in time scales
  std::vector<int> first_lags;         // of the ranges, and the end of the last
  // Means of K, ln T, L of each element less θ̂ (3m), then of the increments
  // (m · ranges).
  Eigen::VectorXd means;
  Eigen::MatrixXd covariance;
  double deviance = 0.0;  // −2 ln evidence, costs of the choices included
  // p: by how much the deviance rises if the element keeps its initial values;
  // if it keeps its shape.
  std::vector<double> change_evidence;
  std::vector<double> shape_evidence;

  bool HasShape() const;
};

// From the output-error fit `start` (its point and noise) and from the initial
// values, whichever ends better.
OutputPosterior FindPosterior(const OutputErrorProblem& problem,
                              const std::vector<ElementPrior>& priors,
                              const std::vector<int>& first_lags,
                              const OutputFitBounds& bounds,
                              const OutputFit& start, bool estimate_drift);

}  // namespace mle

#endif  // MLE_NONLINEAR_SHAPE_POSTERIOR_H_
