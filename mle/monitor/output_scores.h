// Sums over whitened samples that a batch is remembered by. Internal to
// mle/monitor; the equations are in model_watch.h.

#ifndef MLE_MONITOR_OUTPUT_SCORES_H_
#define MLE_MONITOR_OUTPUT_SCORES_H_

#include <vector>

#include "Eigen/Core"
#include "mle/monitor/row_response.h"

namespace mle {

// RobustDeviationOf() all innovations.
double RobustDeviation(const std::vector<WhitenedRun>& runs);

// ψ: at most `limit` in magnitude.
void ClipInnovations(double limit, std::vector<WhitenedRun>& runs);

// The same where the parameters may have changed: ν becomes J β + ψ(ν − J β)
// with `clip` deviations, `least` or more each, as the limit of ψ, and β the
// best change for that, in turn (Huber's estimate). The deviation of ν − J β.
double ClipAroundChange(double clip, double least,
                        std::vector<WhitenedRun>& runs);

// γ_0 … γ_longest of the innovations, pairs within runs.
std::vector<double> AutocovariancesOf(const std::vector<WhitenedRun>& runs,
                                      int longest);

// Σ_k J_k J_kᵀ γ_0 + Σ_h (1 − h/(H + 1)) γ_h Σ_k (J_k J_k+hᵀ + J_k+h J_kᵀ): the
// variance of Σ J ν where ν has these autocovariances (n × n).
Eigen::MatrixXd ScoreVariance(const std::vector<WhitenedRun>& runs,
                              const std::vector<double>& covariances,
                              int num_parameters);

struct ScoreSums {
  Eigen::VectorXd score;        // Σ J ν
  Eigen::MatrixXd information;  // Σ J Jᵀ
  double squares = 0.0;         // Σ ν²
  int samples = 0;
};
ScoreSums SumScores(const std::vector<WhitenedRun>& runs, int num_parameters);

// The score and information of a normal score of mean V δ and variance W, taken
// to be V at least: V W⁻¹ S and V W⁻¹ V, with W = V^½ max(1, V^−½ W V^−½) V^½.
void AllowForVariance(const Eigen::MatrixXd& variance, ScoreSums& sums);

// Σ ν² less what the best change of the parameters explains of it.
double UnexplainedSquares(const ScoreSums& sums);

// SᵀV⁺S: what it explains.
double ExplainedSquares(const Eigen::VectorXd& score,
                        const Eigen::MatrixXd& information);

}  // namespace mle

#endif  // MLE_MONITOR_OUTPUT_SCORES_H_
