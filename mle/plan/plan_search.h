// The search for the cheapest shape of a plan. Internal to mle/plan.
//
// Patterns (pulse, doublet, two of them, staircase) of single set points, and
// of such combinations as hold all inputs but one, are tried with several
// lengths; further ones follow the best as long as that pays; then levels and
// times change one by one by ever smaller steps (pattern search: Hooke and
// Jeeves, Journal of the ACM 8, 1961), and levels that hardly matter go.

#ifndef MLE_PLAN_PLAN_SEARCH_H_
#define MLE_PLAN_PLAN_SEARCH_H_

#include "Eigen/Core"
#include "mle/plan/plan_shape.h"

namespace mle {

struct ShapeBounds {
  // p × any: combinations of set points, in units of PlanGrid::scale.
  Eigen::MatrixXd directions;
  std::vector<bool> movable;  // p
  int shortest_hold = 1;      // in steps of the grid
  int most_steps = 1;
};

ShapeBounds MakeShapeBounds(const PlanProblem& problem,
                            const PlanOptions& options, const PlanGrid& grid);

PlanShape FindShape(const ShapeEvaluator& evaluator, const ShapeBounds& bounds);

// The last stage alone, from a shape on.
PlanShape RefineShape(const ShapeEvaluator& evaluator,
                      const ShapeBounds& bounds, PlanShape shape);

}  // namespace mle

#endif  // MLE_PLAN_PLAN_SEARCH_H_
