// Transfer functions that describe a step-response model.
//
// Each pair is described by the first of these that is within 0.2 % of the
// range of its response (its largest less its smallest coefficient, with 0
// among them). Where none is, a shape takes the place of the one before it if
// it leaves less than three quarters of its difference (root mean square), so
// that noise of the coefficients is not described:
//
//   a jump         K e^{−Ls}                           one level after zeros
//   first order    K e^{−Ls} / (T s + 1)               fopdt_fit.h
//   second order   K e^{−Ls} / (T² s² + 2ζT s + 1)     sopdt_fit.h
//   sum of lags    e^{−Ls} Σ_i c_i / (τ_i s + 1)       rational_fit.h, ≤ 5
//
// and a pair that ends in a ramp, whose range counts for ten times dead time
// and lag only, by the first of
//
//   an integrator  K e^{−Ls} / s
//   with a lag     K e^{−Ls} / (s (T s + 1))
//   and lags       e^{−Ls} (K/s + Σ_i c_i / (τ_i s + 1))
//
//   MLE_ASSIGN_OR_RETURN(const Description description, Describe(model));
//   use(description.process, description.pairs[0].largest_difference);

#ifndef MLE_EXCHANGE_DESCRIPTION_H_
#define MLE_EXCHANGE_DESCRIPTION_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"

namespace mle {

// Largest difference, relative to the range of a response, of a description
// that is used, and of one that is used without a warning.
inline constexpr double kAcceptedDifference = 0.05;
inline constexpr double kUnremarkableDifference = 0.01;
// How far, in that range, a description may still move after the last
// coefficient: what would be told of the gain beyond is a guess.
inline constexpr double kAcceptedMovingOn = 0.5;

// How near an element is to the coefficients, relative to their range.
struct PairDescription {
  int output = 0;
  int input = 0;
  double relative_rms = 0.0;
  double largest_difference = 0.0;
  double time = 0.0;  // of the largest difference
  // How far the description still moves after the last coefficient, where the
  // response does not end in a ramp.
  double moves_on = 0.0;
};

struct Description {
  ProcessModel process;
  std::vector<PairDescription> pairs;  // in the order of the model's
};

// max(h, 0) − min(h, 0) of a response h, in its unit.
double RangeOf(const Eigen::VectorXd& response);

// Describes a valid model. InvalidArgument names pairs that end in a ramp
// without a slope, those whose difference is larger than kAcceptedDifference,
// with its size and time, and those that move on after their last coefficient.
absl::StatusOr<Description> Describe(const StepResponseModel& model);

// "overhead ← reflux: 3.2 % of its range at 14 min".
std::string DifferenceText(const ProcessModel& channels,
                           const PairDescription& pair);

}  // namespace mle

#endif  // MLE_EXCHANGE_DESCRIPTION_H_
