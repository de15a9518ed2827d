// The library's result, with what the command adds to show it.

#ifndef APPS_CORRECT_RESULT_H_
#define APPS_CORRECT_RESULT_H_

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/correct/data_sources.h"
#include "apps/correct/next_move.h"
#include "apps/correct/request.h"
#include "mle/data/record.h"
#include "mle/maintain/correct.h"
#include "mle/model/step_response.h"

namespace mle::correct {

// The effect of a correction on control: set points followed by the controller
// with the old model and with the corrected one, on a plant that is as the
// corrected model says.

// A step of one output's set point from rest, without noise or limits.
struct LoopStep {
  int output = 0;
  Record before;  // under the model in use
  Record after;   // under the corrected model, tuned as before
  // Squared errors of all outputs in units of the set-point step, summed over
  // the samples: after / before.
  double error_ratio = 1.0;
};

struct LoopComparison {
  std::vector<LoopStep> steps;  // of each output
};

// One thing that a run found out. Console, page and result.json show the same
// list of them.
struct Finding {
  std::string name;  // "gain", "response_change", "fit_percent"
  std::string place;  // "overhead ← reflux", "overhead"; empty: the whole model
  double value = std::numeric_limits<double>::quiet_NaN();  // NaN: has none
  std::string unit;
  double lower = std::numeric_limits<double>::quiet_NaN();  // its interval
  double upper = std::numeric_limits<double>::quiet_NaN();
  std::string text;  // a whole sentence; empty: part of the one before
};

// The texts that are there.
std::vector<std::string> Sentences(const std::vector<Finding>& findings);

// How to tune the controller for the corrected model.
struct Tuning {
  std::string heading;
  std::vector<std::string> reasons;
};

// The variances of the outputs (p) that are expected in operation under the
// controller as it is tuned, over those with its filter as it is.
struct FilterOperation {
  Eigen::VectorXd bias;    // with the bias filters that predict better
  Eigen::VectorXd kalman;  // with the disturbance model of state_space.json
};

struct Result : CorrectionResult {
  Request request;
  std::vector<DataFile> files;
  // The plant, where it is simulated, and the models' distances to it.
  std::optional<StepResponse> true_response;
  std::optional<ResponseDistance> initial_to_truth;
  std::optional<ResponseDistance> corrected_to_truth;
  std::vector<std::string> verdict;  // two sentences
  std::vector<Finding> findings;     // what it rests on
  std::vector<std::string> advice;   // items
  Tuning tuning;
  // Set points followed before and after, or why they are not compared.
  absl::StatusOr<LoopComparison> loops;
  // Or why it is not computed.
  absl::StatusOr<FilterOperation> filter_operation;
  std::optional<NextMove> next_move;  // where it is asked for

  int exit_code() const;
};

// FailedPrecondition where nothing was corrected, the tuning was not told, or a
// loop is not stable.
absl::StatusOr<LoopComparison> CompareLoops(const Result& result);
// FailedPrecondition without a filter or the controller's tuning, or where a
// loop is not stable.
absl::StatusOr<FilterOperation> CompareFilters(const Result& result);
// p: by how much the correction moves predictions up to the model's settling
// time ahead, root mean square over the windows, with the inputs recorded and
// the measured output as the bias at the begin of each prediction.
absl::StatusOr<Eigen::VectorXd> PredictionShifts(const Result& result);

// Names and SHA-256 of the files, for the page.
std::vector<std::pair<std::string, std::string>> Checksums(
    const Result& result);

// Warnings about pairs whose step responses are described with notable
// differences.
std::vector<Message> DescriptionWarnings(const ModelFile& file);

// Everything after the records were read. Tells request.options.progress what
// it is doing, which may stop it.
absl::StatusOr<Result> RunCorrection(const Request& request, RecordData data,
                                     std::vector<DataFile> files);

// With the option that the error is about named as the command's flag.
absl::Status NameFlags(const absl::Status& status);
// In what is said of mistakes.
void NameFlags(RecordData& data);

// The text, and the flags that would change it.
std::string Shown(const Message& message);

// The same of each, but one for all windows that are not at rest, cut or left
// out, and for all outputs with many outliers, where these are more than two.
std::vector<std::string> ShownTogether(const std::vector<Message>& messages);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RESULT_H_
