// What the paper reports beside what the runs give.

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/report/text.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {
namespace {

using experiment::Describe;
using experiment::Distribution;
using report::FormatScientific;
using report::FormatSignificant;

constexpr double kPaperLambda = 1e-3;

constexpr std::array<PaperFigure, 4> kPaperFigures = {{
    {"gain", 0, 0, 9.33e-2, 0.0},
    {"gain", 1, 0, 5.15e-2, 0.0},
    {"delay", 0, 1, 0.0, 7.6},
    {"delay", 1, 1, 0.0, 7.6},
}};

bool IsOfGain(const PaperFigure& figure) { return figure.gain_error > 0.0; }

// What λ* is where one decision that the paper leaves open is taken otherwise.
std::string WhyOtherLambda(const CaseResult& result) {
  std::vector<std::string> tried;
  for (const AblationResult& ablation : result.ablations) {
    const MethodSummary runs = SummariseRuns(ablation.runs);
    if (!ablation.ablation->left_open || runs.E.count == 0) continue;
    tried.push_back(absl::StrCat(ablation.ablation->what, ": ",
                                 Extremes(runs.lambda, FormatSignificant),
                                 " (E ", FormatSignificant(runs.E.mean), ")"));
  }
  if (tried.empty()) {
    return "The paper leaves scaling, stop of the solver and noise in the "
           "conversion open; --ablations=all shows what each changes.";
  }
  return absl::StrCat("The paper leaves open: ", absl::StrJoin(tried, "; "),
                      ".");
}

// What the paper reports of an element, over the runs.
Distribution ValuesOf(const CaseResult& result, const PaperFigure& figure) {
  std::vector<double> values;
  for (const RunResult& run : result.runs) {
    const Judgement& judgement = run.judgement;
    values.push_back(
        IsOfGain(figure)
            ? std::abs(judgement.static_gain_error(figure.output, figure.input))
            : judgement.delay_impulse_peak(figure.output, figure.input));
  }
  return Describe(std::move(values), 0);
}

std::string WhyGain(const Distribution& errors, double paper,
                    const ElementErrors& element) {
  return absl::StrCat(
      "Error of the step response after 100 min; the paper's is one run",
      paper <= errors.max ? ", and lies among these"
                          : ", with a larger λ, which shrinks the correction",
      ". A first-order fit is off by ",
      FormatSignificant(element.fopdt_gain_error_rms, 2), ".");
}

std::string WhyDelay(const CaseResult& result, const PaperFigure& figure,
                     const ElementErrors& element) {
  const TransferFunction& plant =
      result.plant.element(figure.output, figure.input);
  const double time_constant =
      plant.IsFirstOrder() ? plant.TimeConstant() : 0.0;
  return absl::StrCat(
      "Read at the peak of the impulse response, truly ",
      FormatSignificant(element.true_delay), " ", result.plant.time_unit(),
      ". The response falls slowly behind its peak",
      time_constant > 0.0
          ? absl::StrCat(" (T = ", FormatSignificant(time_constant), ")")
          : "",
      ", so that small errors move it; a first-order fit is off by ",
      FormatSignificant(element.fopdt_delay_error_rms, 2), ".");
}

}  // namespace

const PaperFigure* FindPaperFigure(const CaseResult& result, int output,
                                   int input) {
  if (!result.from_paper) return nullptr;
  for (const PaperFigure& figure : kPaperFigures) {
    if (result.name == figure.case_name && output == figure.output &&
        input == figure.input) {
      return &figure;
    }
  }
  return nullptr;
}

report::Table PaperTable(const std::vector<CaseResult>& cases) {
  using report::Align;
  report::Table table{.caption = "",
                      .columns = {{"", Align::kLeft},
                                  {"the paper says", Align::kLeft},
                                  {"we find", Align::kLeft},
                                  {"why", Align::kLeft}},
                      .stacked = true};
  for (const CaseResult& result : cases) {
    if (!result.from_paper) continue;
    const std::string name = absl::StrCat("Case ", result.name, ": ");
    table.AddRow({absl::StrCat(name, "λ*"),
                  absl::StrCat("about ", FormatScientific(kPaperLambda, 1)),
                  Extremes(result.lambda_star, FormatSignificant),
                  WhyOtherLambda(result)});
    for (const auto& [i, j] : Pairs(result.plant)) {
      const PaperFigure* const figure = FindPaperFigure(result, i, j);
      if (figure == nullptr) continue;
      const ElementErrors& element =
          result.elements[i * result.plant.num_inputs() + j];
      const bool is_gain = IsOfGain(*figure);
      const Distribution values = ValuesOf(result, *figure);
      table.AddRow(
          {absl::StrCat(name, is_gain ? "error of the gain (" : "dead time (",
                        i + 1, ",", j + 1, ")"),
           FormatSignificant(is_gain ? figure->gain_error : figure->delay),
           Extremes(values, FormatSignificant),
           is_gain ? WhyGain(values, figure->gain_error, element)
                   : WhyDelay(result, *figure, element)});
    }
  }
  return table;
}

}  // namespace mle::reproduce
