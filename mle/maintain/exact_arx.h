// The ARX model whose free run has given step responses.
//
// With impulse responses h_ij(l), l = 1, 2, …, row i
//
//   y_i(k+1) = Σ_{l=1..L} a_il y_i(k+1−l) + Σ_j Σ_{l=1..d} b_ijl u_j(k+1−l)
//
// runs as they say if b_ijl = h_ij(l) − Σ_m a_im h_ij(l−m) up to d, and the
// same expression is 0 beyond. L = d less the row's longest dead time; linear
// elements have few modes, and the second condition leaves many a. Taken are
// the smallest: what the noise of measured outputs adds to a prediction is
// ‖a‖² of its variance, and their other modes decay (Kumaresan, IEEE Trans.
// ASSP 31, 1983). It is what the paper's conversion tends to with more and more
// samples of a model excited under white noise, with no error of estimation and
// under no other noise.
//
// The row of an output that integrates is that of its increments, whose impulse
// responses h(l) − h(l−1) decay: with ã of these,
//
//   1 − Σ a_l z^−l = (1 − z⁻¹)(1 − Σ ã_l z^−l),
//
// so that its pole at 1 is exact, and no drift of the level is left.
//
//   const ExactArx exact = ArxOfModel(model, /*sample_time=*/0.2, {});
//   if (exact.errors.maxCoeff() < 0.01) Use(exact.model);

#ifndef MLE_MAINTAIN_EXACT_ARX_H_
#define MLE_MAINTAIN_EXACT_ARX_H_

#include <vector>

#include "Eigen/Core"
#include "mle/maintain/channel_scales.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

struct ExactArx {
  ArxModel model;
  // p: the largest difference of a step response in free run, or of a static
  // gain (the slope of an output that integrates), relative to the largest
  // value of that response.
  Eigen::VectorXd errors;
};

// `response` is longer than `order` (≥ 1) and shows the slowest mode, `gains`
// (p × m) are what it settles at, or the slopes that it ends in where outputs
// are `integrating` (p, or empty; then `order` ≥ 2).
ExactArx ArxOfResponse(const StepResponse& response,
                       const Eigen::MatrixXd& gains, int order,
                       const std::vector<bool>& integrating = {});

// The ARX model of a process model. The order is that of `settings`, where it
// is not given at least what the longest dead time and the modes of a row need.
ExactArx ArxOfModel(const ProcessModel& model, double sample_time,
                    const ConversionSettings& settings);

// errors as above; infinite where the model has no static gain.
Eigen::VectorXd FreeRunErrors(const ArxModel& model,
                              const StepResponse& response,
                              const Eigen::MatrixXd& gains,
                              const std::vector<bool>& integrating = {});

}  // namespace mle

#endif  // MLE_MAINTAIN_EXACT_ARX_H_
