// One way to estimate: an axis of a campaign.
//
// Its name is ESTIMATOR or ESTIMATOR:TEST, with the estimators and tests of no
// change of the library (mle/maintain/estimator.h), the library's own test
// where none is named; `ceres` is arx with ΔR solved by Ceres at the λ of the
// exact path, and `none` leaves the model as it is:
//
//   arx:none           the paper's method
//   arx:adequacy       the same, if the inputs explain part of the residuals
//   output_error:none    every element free
//   combined           as of mle_correct

#ifndef APPS_EXPERIMENT_METHOD_H_
#define APPS_EXPERIMENT_METHOD_H_

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "mle/maintain/estimation.h"

namespace mle::experiment {

struct Method {
  // None: the model stays as it is.
  std::optional<Estimator> estimator;
  ChangeTest change_test = EstimationOptions().change_test;
  bool solve_by_ceres = false;
  // Indices into the campaign's lists, −1 where it chooses no λ.
  int selection = -1;
  int solver = -1;

  // Whether selection rules and solvers make a difference.
  bool UsesLambda() const {
    return estimator.has_value() && *estimator != Estimator::kOutputError;
  }
  std::string name() const;
};

// arx:none.
Method PaperMethod();

// InvalidArgument lists what is known.
absl::StatusOr<Method> ParseMethod(std::string_view name);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_METHOD_H_
