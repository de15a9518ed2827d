// Windows of records as rows of a regression on a model's mismatch.
//
// The response of sample k is the residual of the model, e_k = y_k − R x_k.

#ifndef MLE_CORRECTION_REGRESSION_DATA_H_
#define MLE_CORRECTION_REGRESSION_DATA_H_

#include <deque>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "mle/data/lagged_series.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/regression/lagged_moments.h"
#include "mle/regression/lasso_problem.h"

namespace mle {

class RegressionData {
 public:
  RegressionData() = default;
  // Rows point into the object: it moves, but is not copied.
  RegressionData(RegressionData&&) = default;
  RegressionData& operator=(RegressionData&&) = default;

  // No row extends over the ends of a window. Where the problem will be
  // centred, the channels' means are subtracted first, for accuracy.
  // InvalidArgument if channels or sample times do not match the model's, or if
  // a window leaves no row (its length and the order are named).
  static absl::StatusOr<RegressionData> Create(absl::Span<const Record> windows,
                                               const ArxModel& model,
                                               Scaling scaling,
                                               bool window_intercepts = false);

  int order() const { return order_; }                         // d
  const Eigen::MatrixXd& model_R() const { return model_R_; }  // p × n

  // 1, or with an intercept for each window their number.
  int num_groups() const { return num_groups_; }
  int num_windows() const { return static_cast<int>(rows_.size()); }
  // The usable rows of one window with their responses.
  const std::vector<RegressionRows>& window(int number) const {
    return rows_[number];
  }

 private:
  int order_ = 0;
  int num_groups_ = 1;
  Eigen::MatrixXd model_R_;
  std::deque<LaggedSeries> series_;  // rows point into it
  std::vector<std::vector<RegressionRows>> rows_;
};

}  // namespace mle

#endif  // MLE_CORRECTION_REGRESSION_DATA_H_
