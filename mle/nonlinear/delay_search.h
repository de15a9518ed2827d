// The best dead times of an output's elements on a grid, for any start.
// Internal to mle/nonlinear.
//
// For given time scales the model is linear in gains, offsets and amplitudes,
// and a dead time of whole samples shifts a response. So one Gram matrix of all
// shifted responses gives the least sum of squares of every combination of dead
// times. Two elements are searched together over all their combinations, the
// others held, in turns until no pair improves: with two elements that is the
// whole grid. What the others explain is taken out once, so that a combination
// of two costs ten operations.

#ifndef MLE_NONLINEAR_DELAY_SEARCH_H_
#define MLE_NONLINEAR_DELAY_SEARCH_H_

#include <vector>

#include "mle/nonlinear/output_error_problem.h"

namespace mle {

struct DelaySearchResult {
  // Gains and dead times of the free elements are the best found.
  OutputPoint point;
  // ½ Σ whitened residuals².
  double cost = 0.0;
  // The rounding error of `cost`.
  double cost_accuracy = 0.0;
};

// Which dead times of an element are tried: every sample, but on at most so
// many points, and no nearer to each other than a share of its shortest time
// constant.
struct DelayGrid {
  int max_points = 64;
  double share = 0.0;
};

// Dead times from 0 to `max_delays`[j].
DelaySearchResult SearchDelays(const OutputErrorProblem& problem,
                               const OutputPoint& start,
                               const NoiseShape& shape,
                               const std::vector<bool>& free,
                               const std::vector<double>& max_delays,
                               const DelayGrid& grid);

}  // namespace mle

#endif  // MLE_NONLINEAR_DELAY_SEARCH_H_
