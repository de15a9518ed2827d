// Whether gains follow the level of an input, as those of a valve with a curved
// characteristic do.
//
// What an input u does is, to second order about its mean ū over the records
// with h = max |u − ū|,
//
//   v = u + c (u − ū)²/h,   dv/du = 1 + 2c (u − ū)/h,
//
// and the response of an element (i, j) to (u_j − ū_j)²/h_j is one more column
// of its output's fit. The test is that of model_adequacy.h with this column
// alone, summed over the outputs that the input moves: χ² where gains are
// constant. c is the mean over the outputs, by the precision of each.

#ifndef MLE_NONLINEAR_LEVEL_DEPENDENCE_H_
#define MLE_NONLINEAR_LEVEL_DEPENDENCE_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct LevelDependence {
  double p_value = 1.0;    // that gains do not follow the level
  double curvature = 0.0;  // c
  double error = 0.0;      // its standard error

  // By how much gains differ from those at the mean level, relative to them,
  // at the ends of what the records contain.
  double variation() const;
  // The same, with c two standard errors further from 0.
  double LargestVariation() const;
};

// m: of each input; 1 and 0 for those of which no element was `fitted` (p × m)
// to the records. `model` has the fitted values, `noise` (p) as of the fit.
// Errors are those of CorrectByOutputError().
absl::StatusOr<std::vector<LevelDependence>> TestLevelDependence(
    const ProcessModel& model, const std::vector<Record>& records,
    const Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>& fitted,
    const OutputErrorOptions& options, const std::vector<NoiseEstimate>& noise);

}  // namespace mle

#endif  // MLE_NONLINEAR_LEVEL_DEPENDENCE_H_
