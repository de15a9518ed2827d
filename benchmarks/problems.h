// The regression problems on which speed is measured.
//
// Failures end the program: they are mistakes of the benchmarks themselves.

#ifndef BENCHMARKS_PROBLEMS_H_
#define BENCHMARKS_PROBLEMS_H_

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "mle/data/lagged_series.h"
#include "mle/data/record.h"
#include "mle/regression/lagged_moments.h"

namespace mle::benchmarks {

// Rows of a regression with the series they refer to. Move-only: the rows point
// into `series`.
struct Problem {
  std::deque<LaggedSeries> series;
  std::vector<RegressionRows> rows;

  Problem() = default;
  Problem(Problem&&) = default;
  Problem& operator=(Problem&&) = default;

  std::int64_t num_rows() const;
  int num_regressors() const { return series.front().num_regressors(); }
};

// The paper's correction of the aged Wood-Berry column ("gain" or "delay"):
// closed loop under MPC, two windows of ±200 min, responses y − R x with R
// converted from the model before ageing. n = 600, N = 3702 at order 150.
Problem WoodBerryCorrection(const std::string& ageing, std::uint64_t seed,
                            int order = 150);

// The paper's conversion: the Wood-Berry column under white inputs, responses
// y. N = `rows`.
Problem WoodBerryConversion(std::uint64_t seed, int rows, int order = 150);

// A plant of p × m elements, each first order with a dead time and zero with
// probability one half, under inputs that hold a Gaussian level for 1 … 20 min;
// Δt = 0.2 min, measurement noise of variance 1e-3, responses y. N = `rows`.
Problem SyntheticPlant(int num_outputs, int num_inputs, int rows, int order,
                       std::uint64_t seed);

// Samples of no particular plant: time series without structure, for measuring
// what does not depend on the values. N = `rows`; as many responses as outputs.
Problem WhiteSeries(int num_outputs, int num_inputs, int rows, int order);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_PROBLEMS_H_
