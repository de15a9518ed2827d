// An output's records set up and fitted, for the tests of what follows the fit.

#ifndef TESTS_MLE_NONLINEAR_FITTED_OUTPUT_H_
#define TESTS_MLE_NONLINEAR_FITTED_OUTPUT_H_

#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {

struct FittedOutput {
  std::vector<OutputSetup> setups;
  OutputFit fit;

  const OutputErrorProblem& problem() const { return *setups[0].problem; }
};

// Both elements of the one output of `model` fitted to records of it.
inline FittedOutput FitRecords(const ProcessModel& model,
                               const RecordNoise& noise, unsigned seed) {
  auto setups = SetUpOutputs(model, MakeRecords(model, 400, seed, noise), {});
  EXPECT_TRUE(setups.ok()) << setups.status();
  FittedOutput fitted{*std::move(setups), {}};
  const OutputSetup& setup = fitted.setups[0];
  fitted.fit =
      FitOutput(*setup.problem, setup.start, {true, true}, setup.bounds, {});
  return fitted;
}

}  // namespace mle

#endif  // TESTS_MLE_NONLINEAR_FITTED_OUTPUT_H_
