#include "mle/maintain/fit_by_output_error.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/maintain/kept_parameters.h"
#include "mle/maintain/no_change_test.h"
#include "mle/maintain/stage.h"
#include "mle/maintain/unfitted.h"

namespace mle {
namespace {

// Whether the output-error correction is needed (estimation.h)
bool NeedsStructure(const EstimationOptions& options,
                    const std::vector<Record>& windows) {
  const bool guards = options.change_test == ChangeTest::kCalibrated ||
                      options.change_test == ChangeTest::kChiSquare;
  return guards || options.estimator != Estimator::kArx || !options.converter ||
         std::any_of(windows.begin(), windows.end(), [](const Record& window) {
           return !window.outputs.allFinite();
         });
}

// The test that options.change_test asks for.
absl::StatusOr<NullCalibration> TestNoChange(
    const ProcessModel& initial, const std::vector<Record>& windows,
    const OutputErrorCorrection& output_error, const EstimationOptions& options,
    const ProgressCallback& progress, SharedFits& shared, double& seconds) {
  NullCalibration test;
  test.p_value = output_error.p_value;
  if (options.change_test == ChangeTest::kCalibrated) {
    MLE_ASSIGN_OR_RETURN(const NullCalibration* const calibrated,
                         shared.calibration.Get(
                             [&] {
                               return CalibrateTest(
                                   initial, windows, output_error,
                                   options.output_error, options.calibration,
                                   progress);
                             },
                             seconds));
    test = *calibrated;
  } else if (options.change_test == ChangeTest::kAdequacy) {
    MLE_ASSIGN_OR_RETURN(const ModelAdequacy* const adequacy,
                         shared.adequacy.Get(
                             [&] {
                               return TestAdequacy(
                                   initial, windows,
                                   AdequacyOptionsFor(options.output_error));
                             },
                             seconds));
    test.p_value = adequacy->p_value;
  }
  return test;
}

}  // namespace

absl::Status FitByOutputError(const ProcessModel& initial,
                              const std::vector<Record>& windows,
                              const EstimationOptions& options,
                              const ProgressCallback& progress,
                              SharedFits& shared, EstimateFit& fit) {
  Stage fitting(progress,
                absl::StrCat("fitting ", windows.size(),
                             windows.size() == 1 ? " window" : " windows"),
                2 * initial.num_outputs());
  OutputErrorOptions output_error_options = options.output_error;
  output_error_options.after_fit = [&fitting] {
    fitting.Done();
    return !fitting.cancelled();
  };
  if (NeedsStructure(options, windows)) {
    const absl::StatusOr<const OutputErrorCorrection*> made =
        shared.output_error.Get(
            [&] {
              return CorrectByOutputError(initial, windows,
                                          output_error_options);
            },
            fit.seconds);
    MLE_RETURN_IF_ERROR(fitting.status());
    MLE_RETURN_IF_ERROR(made.status());
    fit.output_error = **made;
  } else {
    fit.output_error = UnfittedStructure(initial);
  }
  MLE_RETURN_IF_ERROR(fitting.status());
  MLE_ASSIGN_OR_RETURN(fit.test,
                       TestNoChange(initial, windows, fit.output_error, options,
                                    progress, shared, fit.seconds));
  const bool rejected =
      options.output_error.change_given ||
      fit.test.p_value < options.output_error.false_alarm_probability;
  OutputErrorCorrection& output_error = fit.output_error;
  switch (options.change_test) {
    case ChangeTest::kCalibrated:
    case ChangeTest::kChiSquare:
      if (output_error.change_proposed && !rejected) {
        OutputErrorOptions without = options.output_error;
        without.false_alarm_probability = kNoFalseAlarm;
        MLE_ASSIGN_OR_RETURN(output_error,
                             CorrectByOutputError(initial, windows, without));
      }
      fit.change_proposed = output_error.change_proposed;
      KeepUnchangedParameters(output_error.corrected);
      break;
    case ChangeTest::kAdequacy:
      fit.change_proposed = rejected;
      break;
    case ChangeTest::kNone:
      fit.change_proposed = true;
      if (options.estimator == Estimator::kArx) break;
      output_error.change_proposed = true;
      output_error.corrected = output_error.full;
      for (int i = 0; i < initial.num_outputs(); ++i) {
        for (int j = 0; j < initial.num_inputs(); ++j) {
          output_error.aged(i, j) =
              output_error.full.element(i, j).state == ElementState::kFitted;
        }
      }
      break;
  }
  return absl::OkStatus();
}

}  // namespace mle
