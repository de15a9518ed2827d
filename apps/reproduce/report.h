// The report of mle_reproduce on its cases: the page, figures, results.json and
// curves.

#ifndef APPS_REPRODUCE_REPORT_H_
#define APPS_REPRODUCE_REPORT_H_

#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// The files mle_reproduce leaves: results.json (docs/formats.md) and the curves
// as CSV.

// A file's name and content.
using File = std::pair<std::string, std::string>;

std::string FormatResults(const std::vector<CaseResult>& cases);

// Curves of each case's first run: E and cross-validation loss over λ
// (curve_NAME.csv), step responses (step_response_NAME.csv: time, then
// output/input for initial, true, corrected and unregularised).
std::vector<File> FormatCurves(const std::vector<CaseResult>& cases,
                               const Eigen::VectorXd& lambdas);

// The paper's result figures and some more, for any cases.

// By their names, CASE being a case's:
//
//   overview                the step response that has changed most in each
//                           case, and E over λ
//   distance_over_lambda    E over λ, a panel for each case (paper's Fig. 4)
//   step_responses_CASE     of the first run (Figs. 5 and 6)
//   impulse_responses_CASE  of the first run (Fig. 7)
//   closed_loop_CASE        set-point changes of the first run, by the model in
//                           the controller
std::vector<report::NamedFigure> MakeFigures(
    const std::vector<CaseResult>& cases, const Eigen::VectorXd& lambdas);

// report.html of mle_reproduce: one page that opens without a network.

// With the figures of MakeFigures, drawn, or without any.
std::string FormatPage(const std::vector<CaseResult>& cases,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_REPORT_H_
