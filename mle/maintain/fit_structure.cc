#include "mle/maintain/fit_structure.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/maintain/unfitted.h"

namespace mle {
namespace {

// A probability that counts as none.
constexpr double kNever = 1e-300;

// Whether the structured correction is needed (estimation.h)
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
    const StructuredCorrection& structured, const EstimationOptions& options,
    const ProgressCallback& progress, SharedFits& shared, double& seconds) {
  NullCalibration test;
  test.p_value = structured.p_value;
  if (options.change_test == ChangeTest::kCalibrated) {
    MLE_ASSIGN_OR_RETURN(const NullCalibration* const calibrated,
                         shared.calibration.Get(
                             [&] {
                               return CalibrateTest(
                                   initial, windows, structured,
                                   options.structured, options.calibration,
                                   progress);
                             },
                             seconds));
    test = *calibrated;
  } else if (options.change_test == ChangeTest::kAdequacy) {
    MLE_ASSIGN_OR_RETURN(const ModelAdequacy* const adequacy,
                         shared.adequacy.Get(
                             [&] {
                               return TestAdequacy(
                                   initial, windows, {},
                                   AdequacyOptionsFor(options.structured));
                             },
                             seconds));
    test.p_value = adequacy->p_value;
  }
  return test;
}

}  // namespace

absl::Status FitStructure(const ProcessModel& initial,
                          const std::vector<Record>& windows,
                          const EstimationOptions& options,
                          const ProgressCallback& progress, SharedFits& shared,
                          EstimateFit& fit) {
  Stage fitting(progress,
                absl::StrCat("fitting ", windows.size(),
                             windows.size() == 1 ? " window" : " windows"));
  if (NeedsStructure(options, windows)) {
    MLE_ASSIGN_OR_RETURN(const StructuredCorrection* const made,
                         shared.structured.Get(
                             [&] {
                               return CorrectStructure(initial, windows,
                                                       options.structured);
                             },
                             fit.seconds));
    fit.structured = *made;
  } else {
    fit.structured = UnfittedStructure(initial);
  }
  MLE_RETURN_IF_ERROR(fitting.status());
  MLE_ASSIGN_OR_RETURN(fit.test,
                       TestNoChange(initial, windows, fit.structured, options,
                                    progress, shared, fit.seconds));
  const bool rejected =
      options.structured.change_given || fit.test.p_value < options.TestLevel();
  StructuredCorrection& structured = fit.structured;
  switch (options.change_test) {
    case ChangeTest::kCalibrated:
    case ChangeTest::kChiSquare:
      if (structured.change_proposed && !rejected) {
        StructuredOptions without = options.structured;
        without.false_alarm_probability = kNever;
        MLE_ASSIGN_OR_RETURN(structured,
                             CorrectStructure(initial, windows, without));
      }
      fit.change_proposed = structured.change_proposed;
      break;
    case ChangeTest::kAdequacy:
      fit.change_proposed = rejected;
      break;
    case ChangeTest::kNone:
      fit.change_proposed = true;
      if (options.estimator == Estimator::kArx) break;
      structured.change_proposed = true;
      structured.corrected = structured.full;
      for (int i = 0; i < initial.num_outputs(); ++i) {
        for (int j = 0; j < initial.num_inputs(); ++j) {
          structured.aged(i, j) =
              structured.full.element(i, j).state == ElementState::kFitted;
        }
      }
      break;
  }
  return absl::OkStatus();
}

}  // namespace mle
