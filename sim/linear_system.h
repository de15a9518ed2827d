// The general linear plant with several delays, for ContinuousPlant:
//
//   ẋ = A(t) x + Σ_i B_i(t) u(t − L_i(t)),
//   y = C(t) x + Σ_i D_i(t) u(t − L_i(t)).
//
// (Kono and Koizumi, Model Life Extension, Eq. 1, with feedthrough.) Written
// with one column for each pair of a delay and an input that it delays, w_c(t)
// = u_{j_c}(t − L_c(t)): ẋ = A x + B w, y = C x + D w, so that B is n × q for q
// paths. An input that acts with several delays has several paths.
//
// A transfer matrix becomes one by setting its elements side by side: A is
// block-diagonal with a block and a path for each element that is not zero.

#ifndef SIM_LINEAR_SYSTEM_H_
#define SIM_LINEAR_SYSTEM_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"
#include "sim/continuous_plant.h"
#include "sim/delayed_inputs.h"

namespace mle::sim {

struct LinearCoefficients {
  Eigen::MatrixXd A;  // n × n
  Eigen::MatrixXd B;  // n × q
  Eigen::MatrixXd C;  // p × n
  Eigen::MatrixXd D;  // p × q
};

// Sets the coefficients, sized on entry, to those at `time`.
using CoefficientUpdate =
    std::function<void(double time, LinearCoefficients& coefficients)>;

// From rest. Without `update` the coefficients are constant. The largest step
// is `relative_step` of the fastest time constant of `coefficients.A`; where A
// becomes faster, or breaks in time, adapt `largest_step` and `breaks` of the
// result. InvalidArgument where shapes disagree.
absl::StatusOr<ContinuousSystem> MakeLinearSystem(
    LinearCoefficients coefficients, int num_inputs,
    std::vector<InputPath> paths, CoefficientUpdate update = nullptr,
    double relative_step = 0.01);

// The transfer matrix `model`, ageing where `ageing` says so.
absl::StatusOr<ContinuousSystem> ToLinearSystem(
    const ProcessModel& model, const AgeingSchedule& ageing = {},
    double relative_step = 0.01);

}  // namespace mle::sim

#endif  // SIM_LINEAR_SYSTEM_H_
