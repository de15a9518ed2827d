#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/drawing.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

// "y1 −12 %, y2 +3.0 %, the others unchanged", which is what nobody would
// notice.
std::string ErrorChanges(const Result& result) {
  constexpr double kNoticed = 0.1;
  std::vector<std::string> changes;
  for (const LoopStep& step : result.loops->steps) {
    const double percent = 100.0 * (step.error_ratio - 1.0);
    if (std::abs(percent) < kNoticed) continue;
    changes.push_back(absl::StrCat(
        result.initial.outputs()[step.output].name, percent < 0.0 ? " −" : " +",
        report::FormatSignificant(std::abs(percent), 2), " %"));
  }
  if (changes.empty()) return "unchanged";
  if (changes.size() < result.loops->steps.size()) {
    changes.emplace_back("the others unchanged");
  }
  return absl::StrJoin(changes, ", ");
}

// How predictions move with the correction, and how to tell the tuning.
void AddPredictions(const Result& result, report::HtmlPage& page) {
  page.AddHeading("What it means for predictions");
  const absl::StatusOr<Eigen::VectorXd> shifts = PredictionShifts(result);
  if (shifts.ok()) {
    std::vector<std::string> moved;
    for (int i = 0; i < result.initial.num_outputs(); ++i) {
      const OutputChannel& output = result.initial.outputs()[i];
      const double shift = (*shifts)(i);
      moved.push_back(shift > 0.0
                          ? absl::StrCat(output.name, " by ",
                                         report::FormatSignificant(shift, 2),
                                         output.unit.empty() ? "" : " ",
                                         output.unit)
                          : absl::StrCat(output.name, " unchanged"));
    }
    page.AddParagraph(absl::StrCat(
        "With the inputs of these records the correction moves predictions up "
        "to ",
        report::FormatSignificant(SettlingTime(result.initial), 3), " ",
        result.initial.time_unit(),
        " ahead (root mean square): ", absl::StrJoin(moved, ", "), "."));
  }
  page.AddParagraph(
      "What it means for control depends on the controller's tuning: with "
      "--control_period, --prediction_horizon, --control_horizon, "
      "--output_weight and --move_weight as they are in the controller, set "
      "points are followed with both models, and a tuning for the corrected "
      "model is advised.");
}

}  // namespace

void AddControl(const Result& result,
                const std::vector<report::DrawnFigure>& figures,
                report::HtmlPage& page) {
  if (!result.accepted()) return;
  if (!result.request.controller_known()) {
    AddPredictions(result, page);
    return;
  }
  page.AddHeading("What it means for control");
  if (result.loops.ok()) {
    page.AddParagraph(absl::StrCat(
        "Squared control error of a set-point step with the corrected model "
        "instead of the controller's model, on a plant that is as the "
        "corrected model says: ",
        ErrorChanges(result), "."));
  } else {
    page.AddParagraph(absl::StrCat(
        "Set points followed before and after cannot be compared: ",
        result.loops.status().message(), "."));
  }
  AddFigure(figures, "control", page);
  if (result.tuning.heading.empty()) return;
  page.OpenFold("Tuning of the controller");
  page.AddParagraph(result.tuning.heading);
  page.AddList(result.tuning.reasons);
  page.CloseFold();
}

void AddFilter(const Result& result, report::HtmlPage& page) {
  if (result.filters.empty()) return;
  const std::string advice = FilterAdvice(result);
  if (advice.empty()) {
    page.OpenFold("The filter of disturbances: keep the one in use");
  } else {
    page.AddHeading("The filter of disturbances");
    page.AddParagraph(advice);
    page.OpenFold("The filter of each output");
  }
  page.AddTable(FilterTable(result));
  page.AddParagraph(FilterNote(result));
  page.CloseFold();
}

}  // namespace mle::correct
