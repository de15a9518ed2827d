// The filter of an output's disturbance, from routine records: what a
// controller that has the model adds to its predictions.
//
// The noise of what the model leaves (measured less simulated outputs) is
// estimated by maximum likelihood, as in the correction itself
// (EstimateNoise()). From it follow, in the forms that controllers have,
//
// - the stationary Kalman gain K with the covariances Q and r
//   (disturbance_system.h), for a controller with a state-space model;
// - the gain g and time constant of a bias filter,
//
//     ŵ_l = ŵ_{l−1} + g (z_l − ŵ_{l−1}) at the control instants,
//
//   with the least mean squared error over the prediction horizon, for a
//   controller with step responses.
//
// Each is compared with the bias filter in use by the errors of its predictions
// over the horizon on the half of the records that it was not estimated from,
// and is better only where these are less by more than chance: by Student's
// test of blocks of a horizon, at 5 %.
//
// Sources: Odelson, Rajamani and Rawlings, Automatica 42 (2006) 303–308, for
// the problem; Anderson and Moore, Optimal Filtering, 1979, ch. 4.
//
//   const std::vector<OutputFilter> filters =
//       FindFilters(residuals, sample_time, integrating, options);

#ifndef MLE_FILTER_OUTPUT_FILTER_H_
#define MLE_FILTER_OUTPUT_FILTER_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/state_space.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct FilterOptions {
  bool estimate = true;
  // Δt_c ≥ 0, in the model's time unit, taken as the nearest whole multiple of
  // the sample time; 0: the sample time.
  double control_period = 0.0;
  // Over which predictions are judged, ≥ 0 in the model's time unit, at most
  // 1000 control periods; 0: until the model has settled.
  double horizon = 0.0;
  // g of the bias filters in use (p), 0 < g ≤ 1, at the control period; empty:
  // 1, the plain bias update.
  Eigen::VectorXd gains_in_use;

  absl::Status Validate() const;
};

// The disturbance of an output (disturbance_system.h has the equations).
//
// Of up to three states, which take no memory from the heap.
using StateMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;
using StateRow =
    Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 3>;

struct DisturbanceSystem {
  // n × n. The first state is the walk, A(0, :) = (1, 0, …).
  StateMatrix A;
  StateRow C;                   // n
  StateMatrix Q;                // n × n
  double noise_variance = 0.0;  // r

  Eigen::Index order() const { return A.rows(); }
};

// Every `samples`-th sample, ≥ 1. With `walk_lag` > 0, in samples, the walk
// acts behind a lag of this time constant, and there is no coloured component.
// Sinusoids and steps of the estimate are left out.
DisturbanceSystem SystemOf(const NoiseEstimate& noise, int samples,
                           double walk_lag = 0.0);

// Of a disturbance.
struct StationaryFilter {
  StateVector gain;                  // K, n
  StateMatrix covariance;            // P, n × n, of d̂ before its sample
  double innovation_variance = 0.0;  // F
  // The certificate: what the equation of P leaves, relative to the largest
  // entry of P.
  double residual = 0.0;
};

// A form of the filter, and the root mean squared errors of its predictions on
// the halves held out.
struct FilterForm {
  bool better = false;  // than the filter in use
  double error = 0.0;
};

struct OutputFilter {
  // Why there is no estimate; empty: there is one.
  std::string reason;
  // A sample; its random walk at least one of ρ = 1/N².
  NoiseEstimate noise;
  // The walk acts behind a lag of this time constant, in samples; 0: as it is.
  double walk_lag = 0.0;
  StationaryFilter stationary;      // of every sample
  double bias_gain = 0.0;           // g, at the control period
  double bias_time_constant = 0.0;  // −Δt_c / ln(1 − g); 0 of g = 1
  FilterForm kalman;
  FilterForm bias;
  double gain_in_use = 1.0;
  double error_in_use = 0.0;
  // The period and the horizon in use, in samples and control periods.
  int samples_of_period = 1;
  int horizon = 1;

  bool estimated() const { return reason.empty(); }
  DisturbanceSystem Every(int samples) const {
    return SystemOf(noise, samples, walk_lag);
  }
};

// `residuals`: p × N of each record, NaN where nothing is measured or the model
// still depends on what was before the record. `integrating` (p): outputs that
// integrate, which have no filter. `settling_time`: of the model.
std::vector<OutputFilter> FindFilters(
    const std::vector<Eigen::MatrixXd>& residuals, double sample_time,
    const std::vector<bool>& integrating, double settling_time,
    const FilterOptions& options, int threads);

// The disturbances of all outputs for a filter that runs every `samples`-th
// sample: where the Kalman filter is not better a random walk, whose gain is
// that of the bias filter in use. Outputs without an estimate have zero rows of
// C and zero columns of K, so that their disturbance is not followed. Empty
// matrices where no Kalman filter is better.
DisturbanceForm CombineFilters(const std::vector<OutputFilter>& filters,
                               int samples);

}  // namespace mle

#endif  // MLE_FILTER_OUTPUT_FILTER_H_
