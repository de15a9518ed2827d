// A factor that all gains of a row or column of a model have in common, as a
// channel in another unit or with another sign gives it: ageing changes
// elements one by one, and not by a hundred.

#ifndef MLE_MAINTAIN_COMMON_FACTOR_H_
#define MLE_MAINTAIN_COMMON_FACTOR_H_

#include <optional>
#include <vector>

#include "Eigen/Core"

namespace mle {

// Gains found in records over those of the model (p × m).
struct GainEstimates {
  Eigen::MatrixXd values;
  Eigen::MatrixXd errors;  // standard errors, infinite for zero elements
};

struct CommonFactor {
  double factor = 1.0;  // negative for a sign
  int elements = 0;     // of the row or column, zero ones left out
  // It is one that ageing could make, and not all estimates agree on it: it
  // must leave nothing else to be explained.
  bool must_be_complete = false;
};

// `estimates`: of the same gains in several ways, the most efficient first.
// `row`: of the output `channel`, not of the input. The rules are those of
// operator_mistakes.h.
std::optional<CommonFactor> FindCommonFactor(
    const std::vector<GainEstimates>& estimates, bool row, int channel);

}  // namespace mle

#endif  // MLE_MAINTAIN_COMMON_FACTOR_H_
