#include "mle/explain/several_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/base/double_limits.h"
#include "mle/explain/held_out_errors.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPrior = 0.03;  // ε
constexpr double kWorth = 0.02;  // of the sum, for a parameter

// The covariance of an estimate by those without one of n parts each
// (Quenouille, Biometrika 43, 1956), larger by what Student's t of n − 1
// degrees asks for in an interval of 95 %.
MatrixXd Jackknife(const std::vector<VectorXd>& values) {
  const auto n = static_cast<double>(values.size());
  VectorXd mean = VectorXd::Zero(values.front().size());
  for (const VectorXd& value : values) mean += value / n;
  MatrixXd sum = MatrixXd::Zero(mean.size(), mean.size());
  for (const VectorXd& value : values) {
    sum += (value - mean) * (value - mean).transpose();
  }
  const double t = StudentTwoSidedQuantile(0.05, n - 1.0) /
                   StudentTwoSidedQuantile(0.05, kInfinity);
  return t * t * (n - 1.0) / n * sum;
}

}  // namespace

int InRows(const ExplainedOutput& output, double time) {
  const double row_time = output.sample_time() * output.samples_a_row();
  return std::max(1, static_cast<int>(std::lround(time / row_time)));
}

bool Reaches(const std::vector<ResidualRow>& rows, std::size_t i, int ahead) {
  if (i < static_cast<std::size_t>(ahead)) return false;
  const ResidualRow& from = rows[i - static_cast<std::size_t>(ahead)];
  return from.record == rows[i].record &&
         rows[i].first - from.first == ahead * rows[i].samples;
}

SeveralSteps::SeveralSteps(const ExplainedOutput& output,
                           const Instruments& instruments)
    : output_(output), instruments_(instruments) {
  for (std::size_t h = 0; h < kStepsAhead.size(); ++h) {
    ahead_[h] = InRows(output, kStepsAhead[h] * output.tau());
  }
  scales_.fill(1.0);
  const auto rows = static_cast<Index>(output.rows().size());
  const VectorXd initial = ErrorsAt({}, VectorXd::Ones(rows));
  for (std::size_t h = 0; h < kStepsAhead.size(); ++h) {
    scales_[h] = std::max(
        initial.segment(static_cast<Index>(h) * rows, rows).norm(), 1e-300);
  }
}

VectorXd SeveralSteps::ErrorsAt(const std::vector<Explanation>& explanations,
                                const VectorXd& weights) const {
  const std::vector<ResidualRow>& rows = output_.rows();
  const VectorXd e = instruments_.Freed(output_.Residual(explanations));
  const Index n = e.size();
  const auto horizons = static_cast<Index>(kStepsAhead.size());
  VectorXd errors =
      VectorXd::Zero(horizons * n + static_cast<Index>(explanations.size()));
  for (Index h = 0; h < horizons; ++h) {
    const int ahead = ahead_[static_cast<std::size_t>(h)];
    for (Index i = ahead; i < n; ++i) {
      if (weights[i] == 0.0 || weights[i - ahead] == 0.0 ||
          !Reaches(rows, static_cast<std::size_t>(i), ahead)) {
        continue;
      }
      errors[h * n + i] =
          (e[i] - e[i - ahead]) / scales_[static_cast<std::size_t>(h)];
    }
  }
  for (std::size_t i = 0; i < explanations.size(); ++i) {
    errors[horizons * n + static_cast<Index>(i)] =
        kPrior * explanations[i].value;
  }
  return errors;
}

ExplanationValue SeveralSteps::Errors(const VectorXd& weights) const {
  return [this, weights](const std::vector<Explanation>& explanations) {
    return ErrorsAt(explanations, weights);
  };
}

ExplanationFit SeveralSteps::Fit(std::vector<Explanation> explanations,
                                 const VectorXd& weights) const {
  return FitExplanations(output_, Errors(weights), std::move(explanations));
}

std::vector<Explanation> SeveralSteps::Worth(bool second_lags,
                                             double most) const {
  const VectorXd all =
      VectorXd::Ones(static_cast<Index>(output_.rows().size()));
  std::vector<Explanation> explanations;
  for (const Explanation& one : output_.Applicable({})) {
    if (IsAgeing(one.kind) ||
        (second_lags && one.kind == ExplanationKind::kHigherOrder)) {
      explanations.push_back(one);
    }
  }
  while (!explanations.empty()) {
    const ExplanationFit fit = Fit(explanations, all);
    double prior = 0.0;
    for (const Explanation& one : fit.explanations) {
      prior += kPrior * kPrior * one.value * one.value;
    }
    if (fit.energy - prior > most) return {};
    const MatrixXd J = JacobianOf(output_, Errors(all), fit.explanations,
                                  ErrorsAt(fit.explanations, all));
    const MatrixXd H = J.transpose() * J;
    const MatrixXd inverse =
        H.ldlt().solve(MatrixXd::Identity(H.rows(), H.cols()));
    std::vector<Explanation> worth;
    for (std::size_t i = 0; i < fit.explanations.size(); ++i) {
      const double value = fit.explanations[i].value;
      const auto k = static_cast<Index>(i);
      const double rise = value * value / std::max(inverse(k, k), 1e-300);
      if (rise > kWorth * fit.energy) worth.push_back(fit.explanations[i]);
    }
    const bool same = worth.size() == explanations.size();
    explanations = std::move(worth);
    if (same) break;
  }
  return explanations;
}

void SeveralSteps::FitFolds(SeveralStepsFit& fit) const {
  std::vector<VectorXd> values;  // θ̂ of each fold
  fit.held_out =
      HeldOutErrors(output_, instruments_, [&](const VectorXd& weights) {
        const ExplanationFit part = Fit(fit.explanations, weights);
        VectorXd& of_part =
            values.emplace_back(static_cast<Index>(part.explanations.size()));
        for (std::size_t i = 0; i < part.explanations.size(); ++i) {
          of_part[static_cast<Index>(i)] = part.explanations[i].value;
        }
        return part.explanations;
      });
  fit.covariance = Jackknife(values);
}

SeveralStepsFit SeveralSteps::Best(bool second_lags, double most) const {
  const VectorXd all =
      VectorXd::Ones(static_cast<Index>(output_.rows().size()));
  SeveralStepsFit fit;
  fit.explanations = Worth(second_lags, most);
  while (!fit.explanations.empty()) {
    FitFolds(fit);
    std::vector<Explanation> significant;
    for (std::size_t i = 0; i < fit.explanations.size(); ++i) {
      const auto k = static_cast<Index>(i);
      if (std::abs(fit.explanations[i].value) >
          kNormalQuantile * std::sqrt(fit.covariance(k, k))) {
        significant.push_back(fit.explanations[i]);
      }
    }
    if (significant.size() == fit.explanations.size()) break;
    fit.explanations = Fit(std::move(significant), all).explanations;
  }
  return fit;
}

}  // namespace mle
