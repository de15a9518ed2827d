// A record as a trial sees it: rows of several samples each, with what both
// models leave of the outputs. Internal to mle/trial.

#ifndef MLE_TRIAL_TRIAL_ROWS_H_
#define MLE_TRIAL_TRIAL_ROWS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/trial/model_trial.h"

namespace mle {

struct TrialRows {
  Eigen::Index first = 0;       // row that begins with the record's `first`
  Eigen::MatrixXd shapes;       // q × n
  Eigen::MatrixXd differences;  // r × n: x, NaN where it is not known
  Eigen::MatrixXd in_use;       // r × n: e⁰, NaN where it is not known
  Eigen::MatrixXd proposed;     // r × n: e¹
  std::vector<int> changes;     // n: of set points
};

// Rows are means of the samples that are known; where these are less than half
// of a row, it is not known. A set point that is not known stays. Where the
// record has no set points, inputs and their moves by hand stand for them.
absl::StatusOr<TrialRows> MakeTrialRows(const TrialModels& models,
                                        const Record& record, int first,
                                        const RowPlan& plan);

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_ROWS_H_
