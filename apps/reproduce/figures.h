// The paper's result figures, for any cases.

#ifndef APPS_REPRODUCE_FIGURES_H_
#define APPS_REPRODUCE_FIGURES_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "apps/report/figure.h"
#include "apps/reproduce/summary.h"
#include "mle/model/process_model.h"

namespace mle::reproduce {

// A figure, the name of its files, and what it shows, in words.
struct NamedFigure {
  std::string name;
  std::string caption;
  std::string alt;
  report::Figure figure;
};

// An overview; E over λ, a panel for each case (the paper's Fig. 4); and for
// each case the step responses (Figs. 5 and 6) and impulse responses (Fig. 7)
// of its first run.
std::vector<NamedFigure> MakeFigures(const std::vector<CaseResult>& cases,
                                     const Eigen::VectorXd& lambdas);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_FIGURES_H_
