// A linear map of the residual of an output, v = P e, for one set of
// explanations after the other. With z = Σ K c,
//
//   v = P measured − Σ K P c,
//
// and P c of each response is kept: explanations that change one element cost
// one response, and those that change a gain none. A curve of the output is not
// linear: its e is made and mapped whole. Internal to mle/explain.

#ifndef MLE_EXPLAIN_PROJECTED_RESIDUAL_H_
#define MLE_EXPLAIN_PROJECTED_RESIDUAL_H_

#include <functional>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "mle/explain/explained_output.h"
#include "mle/explain/explanation.h"
#include "mle/explain/response_cache.h"

namespace mle {

class ProjectedResidual {
 public:
  using Map = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  // `output`, and what the map refers to, must outlive it.
  ProjectedResidual(const ExplainedOutput& output, Map map)
      : output_(output),
        map_(std::move(map)),
        measured_(map_(output.Measured())),
        cache_(static_cast<double>(measured_.size())) {}

  Eigen::VectorXd operator()(
      const std::vector<Explanation>& explanations) const {
    if (output_.IsCurved(explanations)) {
      return map_(output_.Residual(explanations));
    }
    Eigen::VectorXd value = measured_;
    for (const ResponsePart& part : output_.Responses(explanations)) {
      value -= part.gain *
               cache_.Get(part, [&] { return map_(output_.ResponseOf(part)); });
    }
    return value;
  }

 private:
  const ExplainedOutput& output_;
  Map map_;
  Eigen::VectorXd measured_;
  mutable ResponseCache cache_;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_PROJECTED_RESIDUAL_H_
