#include "mle/correction/robust_correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/correction/cross_validation.h"
#include "mle/regression/duality_gap.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDownWeighted = 0.5;
// Weights that move less than this are left as they are in the moments.
constexpr double kUnmoved = 1e-9;
// Rows whose products are added at a time.
constexpr Index kBatch = 256;

// The rows of one output with weights, and their moments.
class WeightedRows {
 public:
  WeightedRows(const Correction& correction, int output)
      : output_(output), moments_(correction.moments()) {
    const RegressionData& data = correction.data();
    for (int i = 0; i < data.num_windows(); ++i) {
      for (const RegressionRows& rows : data.window(i)) {
        parts_.push_back(&rows);
        count_ += rows.rows.rows();
      }
    }
    weights_.setOnes(count_);
    moments_.cross = correction.moments().cross.col(output);
    moments_.response_squares =
        correction.moments().response_squares.segment(output, 1);
    moments_.response_sum = correction.moments().response_sum.row(output);
  }

  const LaggedMoments& moments() const { return moments_; }
  const VectorXd& weights() const { return weights_; }

  // e_k − b₀ − bᵀx_k, with the intercepts of the weighted means.
  VectorXd Residuals(const LassoProblem& problem, const VectorXd& b) const {
    VectorXd residuals(count_);
    Index begin = 0;
    for (const RegressionRows* part : parts_) {
      const double intercept = problem.response_mean(0, part->group) -
                               b.dot(problem.regressor_mean.col(part->group));
      auto own = residuals.segment(begin, part->rows.rows());
      own = part->responses.row(output_).transpose().array() - intercept;
      own.noalias() -= part->series->Regressors(part->rows).transpose() * b;
      begin += own.size();
    }
    return residuals;
  }

  // Returns by how much a weight moves at most.
  double SetWeights(const VectorXd& weights) {
    const VectorXd change = weights - weights_;
    Index begin = 0;
    for (const RegressionRows* part : parts_) {
      AddRows(*part, change.segment(begin, part->rows.rows()));
      begin += part->rows.rows();
    }
    weights_ += (change.array().abs() > kUnmoved).select(change, 0.0);
    return change.cwiseAbs().maxCoeff();
  }

 private:
  // Adds rows of `part` so many times each.
  void AddRows(const RegressionRows& part, const VectorXd& times) {
    std::vector<Index> moved;
    for (Index k = 0; k < times.size(); ++k) {
      if (std::abs(times(k)) > kUnmoved) moved.push_back(k);
    }
    const auto x = part.series->Regressors(part.rows);
    const int g = part.group;
    for (Index first = 0; first < static_cast<Index>(moved.size());
         first += kBatch) {
      const std::vector<Index> batch(
          moved.begin() + first,
          moved.begin() + std::min<Index>(first + kBatch,
                                          static_cast<Index>(moved.size())));
      const MatrixXd rows = x(Eigen::all, batch);
      const VectorXd t = times(batch);
      const VectorXd e = part.responses.row(output_).transpose()(batch);
      moments_.gram.noalias() += rows * t.asDiagonal() * rows.transpose();
      const VectorXd te = t.cwiseProduct(e);
      moments_.cross.col(0).noalias() += rows * te;
      moments_.response_squares(0) += te.dot(e);
      moments_.group_rows(g) += t.sum();
      moments_.regressor_sum.col(g).noalias() += rows * t;
      moments_.response_sum(0, g) += te.sum();
    }
  }

  int output_;
  std::vector<const RegressionRows*> parts_;
  Index count_ = 0;
  VectorXd weights_;
  LaggedMoments moments_;
};

absl::StatusOr<RobustFit> FitOutput(const Correction& correction, int output,
                                    double lambda,
                                    const RobustCorrectionOptions& options,
                                    VectorXd& b) {
  const VectorXd penalty_weights =
      PenaltyWeights(correction.penalty_weights(), output);
  WeightedRows rows(correction, output);
  LassoProblem problem = MakeLassoProblem(rows.moments(), correction.scaling());
  VectorXd beta = correction.fits()[output].path.Coefficients(lambda);
  b = problem.Unscale(beta);
  RobustFit fit;
  // Weights of the residuals at b, and the problem that they make.
  const auto reweight = [&] {
    const RobustWeights robust =
        ComputeRobustWeights(options.loss, rows.Residuals(problem, b));
    fit.scale = robust.scale;
    fit.down_weighted_rows =
        static_cast<int>((robust.weights.array() < kDownWeighted).count());
    fit.weight_change = rows.SetWeights(robust.weights);
    problem = MakeLassoProblem(rows.moments(), correction.scaling());
    beta = b.cwiseProduct(problem.scale);
  };
  reweight();
  while (fit.rounds < options.max_rounds && !fit.converged) {
    ++fit.rounds;
    MLE_ASSIGN_OR_RETURN(
        fit.lasso,
        SolveSmoothedLasso(LassoObjective(problem, 0, penalty_weights), lambda,
                           beta, options.lasso));
    if (fit.lasso.termination == SmoothedLassoTermination::kFailed) {
      return absl::InternalError(
          absl::StrFormat("robust correction: output %d: Ceres failed: %s",
                          output + 1, fit.lasso.message));
    }
    b = problem.Unscale(fit.lasso.beta);
    reweight();
    fit.converged = fit.weight_change <= options.weight_tolerance;
  }
  fit.relative_gap =
      ComputeDualityGap(LassoObjective(problem, 0, penalty_weights), lambda,
                        beta)
          .Relative();
  return fit;
}

}  // namespace

absl::Status RobustCorrectionOptions::Validate() const {
  if (!(weight_tolerance > 0.0 && weight_tolerance < 1.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "robust correction: weight_tolerance is %g, must be between 0 and 1",
        weight_tolerance));
  }
  if (max_rounds < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "robust correction: max_rounds is %d, must be at least 1", max_rounds));
  }
  return lasso.Validate();
}

double RobustCorrection::MaxRelativeGap() const {
  double worst = 0.0;
  for (const RobustFit& fit : fits) worst = std::max(worst, fit.relative_gap);
  return worst;
}

absl::StatusOr<RobustCorrection> CorrectRobustly(
    const Correction& correction, const VectorXd& lambdas,
    const RobustCorrectionOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  RobustCorrection robust;
  robust.model = correction.initial();
  const int outputs = robust.model.num_outputs;
  if (lambdas.size() != outputs) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "robust correction: %d values of λ are given for %d outputs; one for "
        "each is needed",
        lambdas.size(), outputs));
  }
  for (int i = 0; i < outputs; ++i) {
    VectorXd b;
    MLE_ASSIGN_OR_RETURN(RobustFit fit,
                         FitOutput(correction, i, lambdas(i), options, b));
    robust.model.R.row(i) += b.transpose();
    robust.fits.push_back(std::move(fit));
  }
  return robust;
}

}  // namespace mle
