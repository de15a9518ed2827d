#include "mle/regression/lasso_problem.h"

#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_format.h"
#include "glog/logging.h"

namespace mle {
namespace {

// A centred sum of squares below this part of the uncentred one is rounding:
// the bound for a sum of N equal terms, whose roundings need not cancel, less
// the square of another.
double ConstantTolerance(double rows) {
  return (256.0 + 2.0 * rows) * std::numeric_limits<double>::epsilon();
}

// Sets the means of each group; zero where nothing is centred.
void SetMeans(const LaggedMoments& moments, Scaling scaling,
              LassoProblem& problem) {
  problem.regressor_mean.setZero(problem.gram.cols(), moments.num_groups());
  problem.response_mean.setZero(moments.num_responses(), moments.num_groups());
  if (scaling != Scaling::kStandardise) return;
  const Eigen::ArrayXd divisor = moments.group_rows.array().max(1.0);
  problem.regressor_mean =
      moments.regressor_sum * divisor.inverse().matrix().asDiagonal();
  problem.response_mean =
      moments.response_sum * divisor.inverse().matrix().asDiagonal();
}

}  // namespace

Eigen::VectorXd LassoProblem::Unscale(const Eigen::VectorXd& beta) const {
  return (scale.array() > 0.0)
      .select(
          beta.array() / scale.array().max(std::numeric_limits<double>::min()),
          0.0);
}

LassoProblem MakeLassoProblem(LaggedMoments moments, Scaling scaling) {
  CHECK_GT(moments.rows, 0);
  const auto n = moments.num_regressors();
  const double rows = static_cast<double>(moments.rows);
  LassoProblem problem;
  problem.rows = moments.rows;
  problem.gram = std::move(moments.gram);
  problem.correlation = moments.cross / rows;
  problem.response_square = moments.response_squares / rows;

  problem.group_rows = moments.group_rows;
  SetMeans(moments, scaling, problem);
  // Means by the root of their group's part of the rows: what centring takes
  // off is Σ_g m_g m_gᵀ.
  const Eigen::VectorXd root_part = (moments.group_rows / rows).cwiseSqrt();
  const Eigen::MatrixXd mean = problem.regressor_mean * root_part.asDiagonal();
  const Eigen::MatrixXd response_mean =
      problem.response_mean * root_part.asDiagonal();
  problem.correlation.noalias() -= mean * response_mean.transpose();
  for (int i = 0; i < problem.response_square.size(); ++i) {
    const double second_moment = problem.response_square(i);
    const double variance = second_moment - response_mean.row(i).squaredNorm();
    const bool constant = variance <= ConstantTolerance(rows) * second_moment;
    problem.response_square(i) = constant ? 0.0 : variance;
    if (constant) problem.correlation.col(i).setZero();
  }

  problem.scale.setOnes(n);
  for (int j = 0; j < n; ++j) {
    const double second_moment = problem.gram(j, j) / rows;
    const double variance = second_moment - mean.row(j).squaredNorm();
    if (variance <= ConstantTolerance(rows) * second_moment) {
      problem.scale(j) = 0.0;
      problem.constant_regressors.push_back(j);
    } else if (scaling == Scaling::kStandardise) {
      problem.scale(j) = std::sqrt(variance);
    }
  }
  const Eigen::ArrayXd inverse_scale =
      (problem.scale.array() > 0.0)
          .select(problem.scale.array().inverse(), 0.0);
  // In this order of operations G stays symmetric to the bit.
  for (int j = 0; j < n; ++j) {
    auto column = problem.gram.col(j);
    column /= rows;
    for (Eigen::Index g = 0; g < mean.cols(); ++g) {
      column -= mean(j, g) * mean.col(g);
    }
    column.array() *= inverse_scale * inverse_scale(j);
  }
  problem.correlation.array().colwise() *= inverse_scale;
  return problem;
}

LassoObjective::LassoObjective(const LassoProblem& problem, int response,
                               const Eigen::VectorXd& penalty_weights)
    : gram(&problem.gram),
      correlation(problem.correlation.col(response)),
      response_square(problem.response_square(response)),
      weights(penalty_weights) {
  if (weights.size() == 0) weights.setOnes(problem.num_regressors());
  if (weights.size() == problem.num_regressors()) {
    for (const int j : problem.constant_regressors) {
      weights(j) = std::numeric_limits<double>::infinity();
    }
  }
}

absl::Status LassoObjective::Validate() const {
  if (gram == nullptr || gram->rows() != size() || gram->cols() != size() ||
      weights.size() != size()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "lasso: the Gram matrix is %d × %d, the correlations have %d entries "
        "and the weights %d; all must agree",
        gram == nullptr ? 0 : gram->rows(), gram == nullptr ? 0 : gram->cols(),
        size(), weights.size()));
  }
  if (size() == 0) {
    return absl::InvalidArgumentError("lasso: there are no regressors");
  }
  if (!gram->allFinite() || !correlation.allFinite() ||
      !std::isfinite(response_square)) {
    return absl::InvalidArgumentError(
        "lasso: the moments are not finite; leave bad samples out of the rows");
  }
  for (int j = 0; j < size(); ++j) {
    if (!(weights(j) >= 0.0)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "lasso: weight %d is %g; weights must be 0 (not penalised), positive "
          "or infinite (excluded)",
          j, weights(j)));
    }
  }
  if (!(weights.minCoeff() < std::numeric_limits<double>::infinity())) {
    return absl::InvalidArgumentError(
        "lasso: every regressor is excluded or constant; there is nothing to "
        "estimate");
  }
  return absl::OkStatus();
}

double LassoObjective::LambdaMax() const {
  double lambda = 0.0;
  for (int j = 0; j < size(); ++j) {
    if (weights(j) > 0.0 && std::isfinite(weights(j))) {
      lambda = std::max(lambda, std::abs(correlation(j)) / weights(j));
    }
  }
  return lambda;
}

}  // namespace mle
