// Linear filters of the regression on plays (play_regression.h). Internal to
// maintain.

#ifndef MLE_MAINTAIN_PLAY_FILTERS_H_
#define MLE_MAINTAIN_PLAY_FILTERS_H_

#include <array>

#include "Eigen/Core"
#include "mle/maintain/whitened_fit.h"
#include "mle/model/process_model.h"

namespace mle {

inline constexpr int kPlayFilters = 6;

// F_c of what an element makes of its input.
std::array<Eigen::VectorXd, kPlayFilters> ThroughPlayFilters(
    const TransferFunction& element, double sample_time,
    const Eigen::VectorXd& values);

// The innovations of drift upon white noise: κ = `share`.
Eigen::VectorXd InnovationsOfDrift(const Eigen::VectorXd& values, double share);
// Of all outputs and responses.
WhitenedData InnovationsOfDrift(WhitenedData data, double share);

}  // namespace mle

#endif  // MLE_MAINTAIN_PLAY_FILTERS_H_
