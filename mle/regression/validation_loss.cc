#include "mle/regression/validation_loss.h"

#include <cmath>

#include "glog/logging.h"
#include "mle/regression/active_columns.h"

namespace mle {

ValidationRows::ValidationRows(const LassoProblem& fitted,
                               const LaggedMoments& validation) {
  CHECK_EQ(fitted.num_regressors(), validation.num_regressors());
  CHECK_EQ(fitted.num_responses(), validation.num_responses());
  CHECK_GT(validation.rows, 0);
  const double rows = static_cast<double>(validation.rows);
  CHECK_EQ(fitted.group_rows.size(), validation.num_groups());
  const Eigen::VectorXd inverse_scale =
      fitted.Unscale(Eigen::VectorXd::Ones(fitted.num_regressors()));

  // Moments about the fitted means: E[(x − x̄)(x − x̄)ᵀ] and so on.
  gram_ = validation.gram / rows;
  correlation_ = validation.cross / rows;
  response_square_ = validation.response_squares / rows;
  for (Eigen::Index g = 0; g < validation.num_groups(); ++g) {
    if (validation.group_rows(g) == 0.0) continue;
    const double part = validation.group_rows(g) / rows;
    const Eigen::VectorXd own_mean =
        validation.regressor_sum.col(g) / validation.group_rows(g);
    const Eigen::VectorXd own_response_mean =
        validation.response_sum.col(g) / validation.group_rows(g);
    const bool seen = fitted.group_rows(g) > 0.0;
    const Eigen::VectorXd mean = seen ? fitted.regressor_mean.col(g) : own_mean;
    const Eigen::VectorXd response_mean =
        seen ? fitted.response_mean.col(g) : own_response_mean;
    for (Eigen::Index j = 0; j < mean.size(); ++j) {
      gram_.col(j) -= part * (own_mean(j) * mean + mean(j) * (own_mean - mean));
    }
    correlation_.noalias() -= part * own_mean * response_mean.transpose();
    correlation_.noalias() -=
        part * mean * (own_response_mean - response_mean).transpose();
    response_square_ -=
        part * (2.0 * own_response_mean.cwiseProduct(response_mean) -
                response_mean.cwiseAbs2());
  }
  for (Eigen::Index j = 0; j < gram_.cols(); ++j) {
    gram_.col(j).array() *= inverse_scale.array() * inverse_scale(j);
  }
  correlation_.array().colwise() *= inverse_scale.array();
}

PiecewiseQuadratic ValidationRows::Loss(const LassoPath& path,
                                        int response) const {
  const auto correlation = correlation_.col(response);
  const double response_square = response_square_(response);
  PiecewiseQuadratic loss(0.5 * response_square);
  Eigen::VectorXd gram_start;
  Eigen::VectorXd gram_slope;
  for (const LassoPath::Segment& segment : path.segments()) {
    const auto active = path.Active(segment);
    const auto start = path.Start(segment);
    const auto slope = path.Slope(segment);
    MultiplyActive(gram_, absl::MakeConstSpan(active.data(), active.size()),
                   start.data(), slope.data(), gram_start, gram_slope);
    PiecewiseQuadratic::Piece piece{segment.lambda_begin, segment.lambda_end,
                                    0.5 * response_square, 0.0, 0.0};
    for (int i = 0; i < segment.active; ++i) {
      const int j = active(i);
      piece.value += start(i) * (0.5 * gram_start(j) - correlation(j));
      piece.slope += slope(i) * (gram_start(j) - correlation(j));
      piece.curvature += 0.5 * slope(i) * gram_slope(j);
    }
    loss.Append(piece);
  }
  return loss;
}

PiecewiseQuadratic PenaltyAlong(const LassoPath& path,
                                const Eigen::VectorXd& weights) {
  PiecewiseQuadratic penalty(0.0);
  for (const LassoPath::Segment& segment : path.segments()) {
    const auto active = path.Active(segment);
    const auto start = path.Start(segment);
    const auto slope = path.Slope(segment);
    // Σ w|β| = norm + rate t, times λ = λ_begin − t.
    double norm = 0.0;
    double rate = 0.0;
    for (int i = 0; i < segment.active; ++i) {
      const double w = weights(active(i));
      const double middle =
          start(i) +
          0.5 * (segment.lambda_begin - segment.lambda_end) * slope(i);
      norm += w * std::copysign(1.0, middle) * start(i);
      rate += w * std::copysign(1.0, middle) * slope(i);
    }
    penalty.Append({segment.lambda_begin, segment.lambda_end,
                    segment.lambda_begin * norm,
                    segment.lambda_begin * rate - norm, -rate});
  }
  return penalty;
}

}  // namespace mle
