// How well filters predict residuals that were recorded. Internal to
// mle/filter.
//
// At each control instant l, z_{l+1}, …, z_{l+H} (in control periods) are
// predicted; the squares of the errors are summed. A filter starts at the first
// sample measured; samples that are missing are bridged.

#ifndef MLE_FILTER_RESIDUAL_PREDICTION_H_
#define MLE_FILTER_RESIDUAL_PREDICTION_H_

#include <vector>

#include "Eigen/Core"
#include "mle/filter/disturbance_system.h"

namespace mle {

struct PredictionGrid {
  int samples = 1;  // of a control period, ≥ 1
  int horizon = 1;  // H ≥ 1, in control periods
};

struct SquaredErrors {
  double sum = 0.0;
  double count = 0.0;

  double mean() const { return count > 0.0 ? sum / count : 0.0; }
  void Add(const SquaredErrors& other) {
    sum += other.sum;
    count += other.count;
  }
};

SquaredErrors Together(const std::vector<SquaredErrors>& blocks);

// Of predictions that are made at samples [first, last) of a residual, of which
// NaN are not measured: for each block of starts as long as the horizon, after
// which errors are nearly independent.
std::vector<SquaredErrors> BiasErrors(const Eigen::VectorXd& residual,
                                      double gain, const PredictionGrid& grid,
                                      Eigen::Index first, Eigen::Index last);
// The system and its filter are those of every sample.
std::vector<SquaredErrors> KalmanErrors(const Eigen::VectorXd& residual,
                                        const DisturbanceSystem& system,
                                        const StationaryFilter& filter,
                                        const PredictionGrid& grid,
                                        Eigen::Index first, Eigen::Index last);

}  // namespace mle

#endif  // MLE_FILTER_RESIDUAL_PREDICTION_H_
