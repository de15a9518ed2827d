// The paper's result figures and some more, for any cases.

#ifndef APPS_REPRODUCE_FIGURES_H_
#define APPS_REPRODUCE_FIGURES_H_

#include <vector>

#include "Eigen/Core"
#include "apps/report/drawing.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// By their names, CASE being a case's:
//
//   overview                what has changed most in each case, and E over λ
//   distance_over_lambda    E over λ, a panel for each case (the paper's Fig.
//   4) distance_distribution   of E over the seeds, by model; with two seeds or
//   more step_responses_CASE     of the first run (Figs. 5 and 6)
//   impulse_responses_CASE  of the first run (Fig. 7)
//   closed_loop_CASE        set-point changes of the first run, by the model in
//                           the controller
std::vector<report::NamedFigure> MakeFigures(
    const std::vector<CaseResult>& cases, const Eigen::VectorXd& lambdas);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_FIGURES_H_
