// Least squares over the parameters of explanations. Internal to mle/explain.

#ifndef MLE_EXPLAIN_EXPLANATION_FIT_H_
#define MLE_EXPLAIN_EXPLANATION_FIT_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "mle/explain/explained_output.h"
#include "mle/explain/explanation.h"

namespace mle {

// What is to be small, for some explanations.
using ExplanationValue =
    std::function<Eigen::VectorXd(const std::vector<Explanation>&)>;

// Some explanations, estimated.
struct ExplanationFit {
  std::vector<Explanation> explanations;
  double energy = 0.0;  // |value|²
  // energy + improbabilities times N (competition.h).
  double score = 0.0;
};

// By each θ, by differences within the bounds of `output`; `at` is the value of
// `explanations`.
Eigen::MatrixXd JacobianOf(const ExplainedOutput& output,
                           const ExplanationValue& value_of,
                           const std::vector<Explanation>& explanations,
                           const Eigen::VectorXd& at);

// Levenberg–Marquardt within bounds, from the θ given.
ExplanationFit FitExplanations(const ExplainedOutput& output,
                               const ExplanationValue& value_of,
                               std::vector<Explanation> explanations);

}  // namespace mle

#endif  // MLE_EXPLAIN_EXPLANATION_FIT_H_
