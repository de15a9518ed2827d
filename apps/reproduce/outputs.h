// The files mle_reproduce leaves: results.json (docs/formats.md) and the curves
// as CSV.

#ifndef APPS_REPRODUCE_OUTPUTS_H_
#define APPS_REPRODUCE_OUTPUTS_H_

#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {

// A file's name and content.
using File = std::pair<std::string, std::string>;

std::string FormatResults(const std::vector<CaseResult>& cases);

// Of each case's first run: E and cross-validation loss over λ
// (curve_NAME.csv), step responses (step_response_NAME.csv: time, then
// output/input for initial, true, corrected and unregularised).
std::vector<File> FormatCurves(const std::vector<CaseResult>& cases,
                               const Eigen::VectorXd& lambdas);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_OUTPUTS_H_
