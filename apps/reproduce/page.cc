#include "absl/strings/str_cat.h"
#include "apps/report/number.h"
#include "apps/reproduce/report.h"

namespace mle::reproduce {

using report::FormatScientific;
using report::FormatSignificant;

std::vector<std::string> Findings(const std::vector<CaseResult>& cases) {
  std::vector<std::string> sentences;
  for (const CaseResult& result : cases) {
    const bool several = result.runs.size() > 1;
    sentences.push_back(absl::StrCat(
        "Case ", result.name, ": corrected from ", result.plant.num_outputs(),
        " set-point changes, the model's squared distance E from the plant "
        "falls from ",
        FormatSignificant(result.E_initial, 4), " to ",
        FormatSignificant(result.E_star.mean),
        several ? absl::StrCat(" on average over ", result.runs.size(),
                               " seeds (worst ",
                               FormatSignificant(result.E_star.max), ")")
                : "",
        "."));
  }
  return sentences;
}

namespace {

using Figures = std::vector<report::DrawnFigure>;

void AddDistances(const std::vector<CaseResult>& cases, const Figures& figures,
                  report::HtmlPage& page) {
  page.AddHeading("Distance from the plant");
  page.AddParagraph(
      "E is the sum of the squared differences of the step responses over all "
      "input–output pairs and samples. λ* is chosen from the records alone, by "
      "the rule that --selection names; the plant is not used for it.");
  for (const CaseResult& result : cases) page.AddTable(DistanceTable(result));
  AddFigure(figures, "distance_over_lambda", page);
}

void AddEstimators(const std::vector<CaseResult>& cases,
                   report::HtmlPage& page) {
  if (cases.front().runs.front().estimators.empty()) return;
  page.AddHeading("Estimators side by side");
  page.AddParagraph(
      "On the same records. arx: ΔR by the exact engine, unless a test finds "
      "that the initial model explains the records; ceres: the same by "
      "smoothed L1, first seed only; output_error: gains, time constants and "
      "dead times; combined: output_error, and shapes that the structure lacks "
      "where the records speak for them. The information bound is the E that "
      "no "
      "unbiased estimate of the plant's parameters can beat on average; an "
      "estimate that knows which elements have aged can.");
  for (const CaseResult& result : cases) {
    page.AddTable(EstimatorTable(result, /*with_times=*/false));
  }
}

void AddAblations(const std::vector<CaseResult>& cases,
                  report::HtmlPage& page) {
  if (cases.front().ablations.empty()) return;
  page.AddHeading("What each decision is worth");
  page.AddParagraph(
      "The same records corrected with one decision taken differently. A large "
      "duality gap means that the fits are not exact.");
  for (const CaseResult& result : cases) {
    page.AddTable(AblationTable(result));
  }
}

void AddResponses(const std::vector<CaseResult>& cases, const Figures& figures,
                  report::HtmlPage& page) {
  page.AddHeading("Gains and dead times");
  page.AddParagraph(
      "Gain error by the end of the step response and by a first-order-plus-"
      "dead-time (FOPDT) fit to it; dead time at the peak of the impulse "
      "response, as the paper reads it, and error of the fit's. The peak comes "
      "up to two samples after the dead time even without any error. The "
      "paper's figures are of one run.");
  for (const CaseResult& result : cases) {
    page.AddTable(GainTable(result));
    page.AddTable(DelayTable(result));
    AddFigure(figures, absl::StrCat("step_responses_", result.name), page);
    AddFigure(figures, absl::StrCat("impulse_responses_", result.name), page);
  }
}

void AddLoops(const std::vector<CaseResult>& cases, const Figures& figures,
              report::HtmlPage& page) {
  page.AddHeading("The loop under control");
  page.AddParagraph(
      "The aged plant with the initial model in its controller, with the "
      "corrected ARX model as it is, and with the plant's own; same weights, "
      "horizons and noise. Squared error: integrated over all outputs, from "
      "the set-point change to the end of its window.");
  for (const CaseResult& result : cases) {
    page.AddTable(
        ClosedLoopTable(result.name, result.plant, result.ClosedLoops()));
    AddFigure(figures, absl::StrCat("closed_loop_", result.name), page);
  }
}

void AddCertificates(const std::vector<CaseResult>& cases,
                     report::HtmlPage& page) {
  page.AddHeading("Certificate");
  for (const CaseResult& result : cases) {
    const std::string sentence = absl::StrCat(
        "Case ", result.name,
        ": relative duality gap of every lasso fit, at every λ of the grid, at "
        "most ",
        FormatScientific(result.max_relative_gap, 2), ".");
    if (result.max_relative_gap <= kAcceptedGap) {
      page.AddParagraph(sentence);
    } else {
      page.AddWarning(absl::StrCat(sentence, " This is more than ",
                                   FormatScientific(kAcceptedGap, 1),
                                   ": the fits there are not exact."));
    }
  }
}

}  // namespace

std::string FormatPage(const std::vector<CaseResult>& cases,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again) {
  report::HtmlPage page("Model Life Extension: reproduction");
  page.AddSummary(Findings(cases));
  AddFigure(figures, "overview", page);
  AddDistances(cases, figures, page);
  AddEstimators(cases, page);
  AddAblations(cases, page);
  AddResponses(cases, figures, page);
  AddLoops(cases, figures, page);
  AddCertificates(cases, page);
  page.AddRunAgain(run_again);
  return page.Render();
}

}  // namespace mle::reproduce
