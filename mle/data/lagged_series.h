// The lagged regressors of an ARX model as views into one array.
//
// With z_k = [y_k; u_k] (c = p + m channels) the regressor of sample k is
//
//   x_k = [z_{k−1}; …; z_{k−d}]          (n = dc),
//
// the order of ArxModel's coefficients. The samples are stored latest first, so
// that x_k is n consecutive numbers and a range of rows is a matrix whose
// columns overlap (outer stride c): X is never formed. In these views time runs
// backwards, which does not matter for sums over rows.

#ifndef MLE_DATA_LAGGED_SERIES_H_
#define MLE_DATA_LAGGED_SERIES_H_

#include <vector>

#include "Eigen/Core"
#include "mle/data/record.h"

namespace mle {

// Samples first … last (both included) as rows of a regression.
struct RowRange {
  int first = 0;
  int last = -1;

  int rows() const { return last - first + 1; }
};

class LaggedSeries {
 public:
  using View = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

  // `offset` (c) is subtracted from every sample first: sums of squares about a
  // distant operating point would lose digits. Empty means zero.
  LaggedSeries(const Record& record, int order,
               const Eigen::VectorXd& offset = {});

  int order() const { return order_; }                                    // d
  int num_channels() const { return static_cast<int>(samples_.rows()); }  // c
  int num_regressors() const { return order_ * num_channels(); }          // n
  int samples() const { return static_cast<int>(samples_.cols()); }

  // The longest runs of samples k whose outputs and lags are all finite.
  std::vector<RowRange> UsableRows() const;

  // n × rows: x_k for k = last … first.
  View Regressors(RowRange rows) const;
  // c × rows: z_k for k = last − lag … first − lag.
  View Samples(RowRange rows, int lag = 0) const;
  // p × rows: y_k for k = last … first.
  View Outputs(RowRange rows) const;

 private:
  int order_;
  int num_outputs_;
  Eigen::MatrixXd samples_;  // c × N, latest first
};

// Mean of each channel (c) over the finite samples of all records; 0 for a
// channel without any.
Eigen::VectorXd ChannelMeans(const std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_DATA_LAGGED_SERIES_H_
