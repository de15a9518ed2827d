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
  const Eigen::VectorXd& mean = fitted.regressor_mean;
  const Eigen::VectorXd& response_mean = fitted.response_mean;
  const Eigen::VectorXd own_mean = validation.regressor_sum / rows;
  const Eigen::VectorXd own_response_mean = validation.response_sum / rows;
  const Eigen::VectorXd inverse_scale =
      fitted.Unscale(Eigen::VectorXd::Ones(fitted.num_regressors()));

  // Moments about the fitted means: E[(x − x̄)(x − x̄)ᵀ] and so on.
  gram_.resize(mean.size(), mean.size());
  for (Eigen::Index j = 0; j < mean.size(); ++j) {
    gram_.col(j) = (validation.gram.col(j) / rows - own_mean(j) * mean -
                    mean(j) * (own_mean - mean))
                       .cwiseProduct(inverse_scale) *
                   inverse_scale(j);
  }
  correlation_ = validation.cross / rows;
  correlation_.noalias() -= own_mean * response_mean.transpose();
  correlation_.noalias() -=
      mean * (own_response_mean - response_mean).transpose();
  correlation_.array().colwise() *= inverse_scale.array();
  response_square_ = (validation.response_squares / rows -
                      2.0 * own_response_mean.cwiseProduct(response_mean) +
                      response_mean.cwiseAbs2());
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
