// A record as a trial sees it: rows of several samples each, with what both
// models leave of the outputs. Internal to mle/trial.

#ifndef MLE_TRIAL_TRIAL_ROWS_H_
#define MLE_TRIAL_TRIAL_ROWS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// Two models of the outputs that differ, r of p.
struct TrialModels {
  ProcessModel in_use;
  ProcessModel proposed;
  std::vector<int> outputs;
  std::vector<int> inputs;  // that move these outputs
};

struct RowPlan {
  int samples = 1;     // of a row
  int forgetting = 0;  // samples in which former inputs act
  double pole = 0.5;   // of the shapes, for each row
};

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
