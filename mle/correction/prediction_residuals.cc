#include "mle/correction/prediction_residuals.h"

#include "glog/logging.h"

namespace mle {

Eigen::MatrixXd PredictionResiduals(const LaggedSeries& series, RowRange rows,
                                    const Eigen::MatrixXd& R, int horizon) {
  CHECK_EQ(R.cols(), series.num_regressors());
  CHECK_GE(horizon, 0);
  const int p = series.num_outputs();
  const int c = series.num_channels();
  const int d = series.order();
  // Samples last … first − d, whose outputs predictions replace in turn.
  const Eigen::MatrixXd measured = series.Samples({rows.first - d, rows.last});
  Eigen::MatrixXd samples = measured;
  Eigen::MatrixXd residuals(p, rows.rows());
  for (int ahead = 0; ahead < rows.rows(); ++ahead) {
    const Eigen::Index column = rows.rows() - 1 - ahead;
    if (horizon > 0 && ahead % horizon == 0) {
      samples.block(0, column + 1, p, d) = measured.block(0, column + 1, p, d);
    }
    const Eigen::Map<const Eigen::VectorXd> regressor(
        samples.data() + c * (column + 1), static_cast<Eigen::Index>(c) * d);
    auto prediction = samples.col(column).head(p);
    prediction.noalias() = R * regressor;
    residuals.col(column) = measured.col(column).head(p) - prediction;
  }
  residuals.colwise() -= residuals.rowwise().mean().eval();
  return residuals;
}

}  // namespace mle
