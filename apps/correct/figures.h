// The figures of the page, each also a file of its own.

#ifndef APPS_CORRECT_FIGURES_H_
#define APPS_CORRECT_FIGURES_H_

#include <array>
#include <string_view>
#include <vector>

#include "apps/correct/result.h"
#include "apps/report/drawing.h"

namespace mle::correct {

// By their names:
//
//   step_responses     a panel for each pair that is not zero: the
//                      controller's model, the corrected one with its band,
//                      true where it is known
//   changed_responses  the same of the pairs that have changed most; only where
//                      something was corrected
//   control            a panel for each output: its set point followed with the
//                      initial and the corrected model in the controller
//   mismatch_map       what has changed of each pair, and how surely
//   records            a panel for each channel: samples, bad ones, set points,
//                      the windows used
//   predictions        a panel for each output: measured, and simulated by both
//                      models in every window
//   loss_over_lambda   what the rule for λ minimises; only where ΔR was used
//   autocorrelation    a panel for each output, of the one-step errors
//   cross_correlation  a panel for each pair: errors against inputs over the
//   lag
std::vector<report::NamedFigure> MakeFigures(const Result& result);

// All names that a figure may have.
inline constexpr std::array<std::string_view, 9> kFigureNames = {
    "step_responses",   "changed_responses", "control",
    "mismatch_map",     "records",           "predictions",
    "loss_over_lambda", "autocorrelation",   "cross_correlation"};

}  // namespace mle::correct

#endif  // APPS_CORRECT_FIGURES_H_
