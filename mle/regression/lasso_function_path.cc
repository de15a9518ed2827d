#include "mle/regression/lasso_function_path.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/regression/duality_gap.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kAcceptedGap = 1e-9;

class FunctionPath {
 public:
  FunctionPath(const LassoObjective& objective, const LassoFunction& function,
               LassoSolution& solution)
      : objective_(objective), function_(function), solution_(solution) {}

  absl::Status Solve() {
    const Index count = solution_.lambdas.size();
    solution_.relative_gap.setZero(count);
    const double top = objective_.LambdaMax();
    const bool unpenalised = (objective_.weights.array() == 0.0).any();
    // The largest λ with a solution other than zero.
    Index last = count - 1;
    while (!unpenalised && last > 0 && solution_.lambdas(last) >= top) --last;
    MLE_RETURN_IF_ERROR(SolveAt(last, VectorXd::Zero(objective_.size())));
    if (last > 0) {
      MLE_RETURN_IF_ERROR(SolveAt(0, solved_.at(last)));
      MLE_RETURN_IF_ERROR(Refine(0, last));
    }
    double lambda = top;
    VectorXd beta = VectorXd::Zero(objective_.size());
    if (unpenalised) {
      // Those do not vanish: the path begins above every λ.
      lambda = std::numeric_limits<double>::max();
      beta = solved_.at(last);
    }
    solution_.path = LassoPath(objective_.size());
    for (auto it = solved_.rbegin(); it != solved_.rend(); ++it) {
      solution_.path.AppendJoin(lambda, beta, solution_.lambdas(it->first),
                                it->second);
      lambda = std::min(lambda, solution_.lambdas(it->first));
      beta = it->second;
    }
    solution_.report = absl::StrFormat(
        "%d of %d values of λ solved, the others interpolated, relative gap at "
        "most %.1e",
        solved_.size(), count, solution_.relative_gap.maxCoeff());
    return absl::OkStatus();
  }

 private:
  absl::Status SolveAt(Index i, const VectorXd& start) {
    const double lambda = solution_.lambdas(i);
    MLE_ASSIGN_OR_RETURN(VectorXd beta, function_(objective_, lambda, start));
    if (beta.size() != objective_.size()) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "lasso: the function given returns %d coefficients for %d regressors",
          beta.size(), objective_.size()));
    }
    solution_.relative_gap(i) =
        ComputeDualityGap(objective_, lambda, beta).Relative();
    solved_[i] = std::move(beta);
    return absl::OkStatus();
  }

  VectorXd Between(Index low, Index high, double lambda) const {
    const double from = solution_.lambdas(low);
    const double share = (lambda - from) / (solution_.lambdas(high) - from);
    return (1.0 - share) * solved_.at(low) + share * solved_.at(high);
  }

  // Whether the interpolation holds at λ number i, whose gap is noted.
  bool Holds(Index low, Index high, Index i) {
    const double lambda = solution_.lambdas(i);
    solution_.relative_gap(i) =
        ComputeDualityGap(objective_, lambda, Between(low, high, lambda))
            .Relative();
    return solution_.relative_gap(i) <= kAcceptedGap;
  }

  // The λ between two that are solved.
  absl::Status Refine(Index low, Index high) {
    if (high - low < 2) return absl::OkStatus();
    const Index middle = low + (high - low) / 2;
    bool holds = Holds(low, high, middle);
    for (Index i = low + 1; holds && i < high; ++i) {
      holds = i == middle || Holds(low, high, i);
    }
    if (holds) return absl::OkStatus();
    MLE_RETURN_IF_ERROR(
        SolveAt(middle, Between(low, high, solution_.lambdas(middle))));
    MLE_RETURN_IF_ERROR(Refine(middle, high));
    return Refine(low, middle);
  }

  const LassoObjective& objective_;
  const LassoFunction& function_;
  LassoSolution& solution_;
  std::map<Index, VectorXd> solved_;
};

}  // namespace

absl::Status SolveByFunction(const LassoObjective& objective,
                             const LassoFunction& function,
                             LassoSolution& solution) {
  return FunctionPath(objective, function, solution).Solve();
}

}  // namespace mle
