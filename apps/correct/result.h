// All that a run found out, for the files and the page to show.

#ifndef APPS_CORRECT_RESULT_H_
#define APPS_CORRECT_RESULT_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/correct/diagnostics.h"
#include "apps/correct/estimation.h"
#include "apps/correct/fopdt_elements.h"
#include "apps/correct/records.h"
#include "apps/correct/request.h"
#include "apps/correct/validation.h"
#include "mle/correction/pair_information.h"
#include "mle/model/step_response.h"

namespace mle::correct {

enum class Decision {
  kNoChange,   // the records do not contradict the model
  kCorrected,  // they do, and the correction is what was written
  kRefused,    // they do, but the correction predicts worse: initial model
};

std::string_view NameOf(Decision decision);

// How to tune the controller for the corrected model.
struct Tuning {
  std::string heading;
  std::vector<std::string> reasons;
};

// How two models differ, by the sum of squares of their step responses.
struct Distance {
  double total = 0.0;        // E: all pairs and samples
  double relative = 0.0;     // √(E / Σ φ²), φ of the first model
  Eigen::MatrixXd elements;  // p × m: the same for each pair, 0 for zero pairs
};

Distance Compare(const StepResponse& from, const StepResponse& to);

struct Result {
  Request request;
  RecordData data;
  Estimate estimate;
  // What the windows can tell about each pair, by the model's own values and
  // the noise found.
  PairInformation information;
  Validation validation;
  Decision decision = Decision::kNoChange;
  CorrectedModel corrected;
  std::vector<FopdtElement> fopdt;  // row by row
  StepResponse initial_response;
  std::optional<StepResponse> true_response;
  Distance change;  // initial to corrected
  // To the truth, where it was given.
  std::optional<Distance> initial_to_truth;
  std::optional<Distance> corrected_to_truth;
  int max_lag = 0;                                  // of the diagnostics
  std::vector<ResidualReport> initial_residuals;    // p
  std::vector<ResidualReport> corrected_residuals;  // p
  std::vector<std::string> verdict;                 // two sentences
  std::vector<std::string> findings;                // what it rests on
  std::vector<std::string> advice;                  // items
  Tuning tuning;
  std::vector<std::string> warnings;  // records' and the fit's
  // Fits that did not converge, or are not exact: the result is not usable.
  std::vector<std::string> failures;

  const ProcessModel& initial() const { return request.model; }
  bool accepted() const { return decision == Decision::kCorrected; }
  int exit_code() const;
};

// Everything after the records were read. Says on standard error what it is
// doing.
absl::StatusOr<Result> CorrectFromRecords(const Request& request,
                                          RecordData data);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RESULT_H_
