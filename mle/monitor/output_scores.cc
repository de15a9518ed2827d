#include "mle/monitor/output_scores.h"

#include <algorithm>
#include <utility>

#include "Eigen/Eigenvalues"
#include "Eigen/QR"

namespace mle {
namespace {

// Eigenvalues up to this share of the largest are rounding.
constexpr double kSingular = 1e-10;
// Iterations of Huber's estimate; a third changes nothing.
constexpr int kRounds = 2;

Eigen::VectorXd BestChange(const ScoreSums& sums) {
  return sums.information.completeOrthogonalDecomposition().solve(sums.score);
}

}  // namespace

double RobustDeviation(const std::vector<WhitenedRun>& runs) {
  std::vector<double> values;
  for (const WhitenedRun& run : runs) {
    values.insert(values.end(), run.innovations.begin(), run.innovations.end());
  }
  return RobustDeviationOf(std::move(values));
}

void ClipInnovations(double limit, std::vector<WhitenedRun>& runs) {
  for (WhitenedRun& run : runs) {
    run.innovations = run.innovations.cwiseMin(limit).cwiseMax(-limit);
  }
}

double ClipAroundChange(double clip, double least,
                        std::vector<WhitenedRun>& runs) {
  if (runs.empty()) return 0.0;
  const std::vector<WhitenedRun> given = runs;
  double deviation = RobustDeviation(runs);
  ClipInnovations(clip * std::max(deviation, least), runs);
  for (int round = 0; round < kRounds; ++round) {
    const ScoreSums sums =
        SumScores(runs, static_cast<int>(runs.front().sensitivities.cols()));
    const Eigen::VectorXd change = BestChange(sums);
    std::vector<WhitenedRun> rest = given;
    for (WhitenedRun& run : rest) run.innovations -= run.sensitivities * change;
    deviation = RobustDeviation(rest);
    ClipInnovations(clip * std::max(deviation, least), rest);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      runs[r].innovations =
          rest[r].innovations + rest[r].sensitivities * change;
    }
  }
  return deviation;
}

std::vector<double> AutocovariancesOf(const std::vector<WhitenedRun>& runs,
                                      int longest) {
  std::vector<double> sums(longest + 1, 0.0);
  Eigen::Index samples = 0;
  for (const WhitenedRun& run : runs) {
    const Eigen::Index n = run.innovations.size();
    samples += n;
    for (int h = 0; h <= longest && h < n; ++h) {
      sums[h] += run.innovations.head(n - h).dot(run.innovations.tail(n - h));
    }
  }
  for (double& sum : sums) {
    sum /= static_cast<double>(std::max<Eigen::Index>(samples, 1));
  }
  return sums;
}

Eigen::MatrixXd ScoreVariance(const std::vector<WhitenedRun>& runs,
                              const std::vector<double>& covariances,
                              int num_parameters) {
  Eigen::MatrixXd variance =
      Eigen::MatrixXd::Zero(num_parameters, num_parameters);
  const auto lags = static_cast<Eigen::Index>(covariances.size());
  Eigen::MatrixXd smoothed;
  for (const WhitenedRun& run : runs) {
    const Eigen::MatrixXd& J = run.sensitivities;
    const Eigen::Index n = J.rows();
    // Row k: what later rows add, so that one product remains.
    smoothed = 0.5 * covariances.front() * J;
    for (Eigen::Index h = 1; h < std::min(lags, n); ++h) {
      const double taper =
          1.0 - static_cast<double>(h) / static_cast<double>(lags);
      smoothed.topRows(n - h) += taper *
                                 covariances[static_cast<std::size_t>(h)] *
                                 J.bottomRows(n - h);
    }
    const Eigen::MatrixXd half = J.transpose() * smoothed;
    variance += half + half.transpose();
  }
  return variance;
}

void AllowForVariance(const Eigen::MatrixXd& variance, ScoreSums& sums) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(sums.information);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double largest = values.tail(1)(0);
  Eigen::Index null = 0;
  while (null < values.size() && values(null) <= kSingular * largest) ++null;
  const Eigen::Index rank = values.size() - null;
  const Eigen::VectorXd roots = values.tail(rank).cwiseSqrt();
  const Eigen::MatrixXd basis = solver.eigenvectors().rightCols(rank);
  // V^½ and V^−½ where there is information.
  const Eigen::MatrixXd up = basis * roots.asDiagonal();
  const Eigen::MatrixXd down = basis * roots.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ratio(down.transpose() *
                                                             variance * down);
  const Eigen::MatrixXd shape =
      ratio.eigenvectors() *
      ratio.eigenvalues().cwiseMax(1.0).cwiseInverse().asDiagonal() *
      ratio.eigenvectors().transpose();
  sums.score = (up * (shape * (down.transpose() * sums.score))).eval();
  sums.information = up * shape * up.transpose();
}

ScoreSums SumScores(const std::vector<WhitenedRun>& runs, int num_parameters) {
  ScoreSums sums;
  sums.score.setZero(num_parameters);
  sums.information.setZero(num_parameters, num_parameters);
  for (const WhitenedRun& run : runs) {
    sums.score += run.sensitivities.transpose() * run.innovations;
    sums.information += run.sensitivities.transpose() * run.sensitivities;
    sums.squares += run.innovations.squaredNorm();
    sums.samples += static_cast<int>(run.innovations.size());
  }
  return sums;
}

double UnexplainedSquares(const ScoreSums& sums) {
  return std::max(sums.squares - ExplainedSquares(sums.score, sums.information),
                  0.0);
}

double ExplainedSquares(const Eigen::VectorXd& score,
                        const Eigen::MatrixXd& information) {
  return score.dot(information.completeOrthogonalDecomposition().solve(score));
}

}  // namespace mle
