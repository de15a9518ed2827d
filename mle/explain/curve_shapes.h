// The shapes of the curves that won (curves.h). Internal to mle/explain.

#ifndef MLE_EXPLAIN_CURVE_SHAPES_H_
#define MLE_EXPLAIN_CURVE_SHAPES_H_

#include <memory>
#include <vector>

#include "mle/explain/output_competition.h"

namespace mle {

// Gives each curve the shape that leaves the least Σ E/M of the outputs that
// show it, all explanations estimated again beside it; those that leave up to 3
// more are its alternatives. Outputs may be null.
void ChooseShapes(
    const std::vector<std::unique_ptr<OutputCompetition>>& outputs);

}  // namespace mle

#endif  // MLE_EXPLAIN_CURVE_SHAPES_H_
