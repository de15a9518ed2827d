// The figures of the page.

#ifndef APPS_CORRECT_FIGURES_H_
#define APPS_CORRECT_FIGURES_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"
#include "apps/report/figure.h"

namespace mle::correct {

struct NamedFigure {
  std::string name;  // of its file, without extension
  std::string caption;
  std::string alt;
  report::Figure figure;
};

// A panel for each pair: initial, corrected with its band, true.
NamedFigure StepResponseFigure(const Result& result);
// A panel for each channel, windows one after the other: outputs with set
// points, inputs.
NamedFigure RecordFigure(const Result& result);
// A panel for each output: measured, and simulated by both models.
NamedFigure PredictionFigure(const Result& result);
// The loss the rule for λ minimises; only where ΔR was used.
bool HasLossFigure(const Result& result);
NamedFigure LossFigure(const Result& result);
// A panel for each output: autocorrelation of the one-step errors.
NamedFigure AutocorrelationFigure(const Result& result);
// A panel for each pair: errors against inputs over the lag.
NamedFigure CrossCorrelationFigure(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_FIGURES_H_
