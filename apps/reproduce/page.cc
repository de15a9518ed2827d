#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/common/model_files.h"
#include "apps/report/text.h"
#include "apps/reproduce/report.h"
#include "mle/base/version.h"
#include "mle/data/csv_rows.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::reproduce {

using report::FormatScientific;
using report::FormatSignificant;

namespace {

// "E falls from … to …", for each case.
std::vector<std::string> FindingsOf(const std::vector<CaseResult>& cases) {
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

using Figures = std::vector<report::DrawnFigure>;

report::Verdict VerdictOn(const std::vector<CaseResult>& cases) {
  std::vector<std::string> worse;
  for (const CaseResult& result : cases) {
    if (!(result.E_star.max < result.E_initial)) worse.push_back(result.name);
  }
  report::Verdict verdict = {
      .badge = worse.empty() ? report::Badge::kGood : report::Badge::kUnknown,
      .label = worse.empty() ? "reproduced" : "not in every run",
      .headline = worse.empty()
                      ? "The corrected model is nearer to the plant in every "
                        "run"
                      : absl::StrCat("The corrected model is not nearer to the "
                                     "plant in every run: ",
                                     absl::StrJoin(worse, ", ")),
      .sentences = FindingsOf(cases)};
  return verdict;
}

void AddDistances(const std::vector<CaseResult>& cases, const Figures& figures,
                  report::HtmlPage& page) {
  page.AddHeading("Distance from the plant");
  page.AddParagraph(
      "E is the sum of the squared differences of the step responses over all "
      "input–output pairs and samples. λ* is chosen from the records alone, by "
      "the rule that --selection names; the plant is not used for it.");
  for (const CaseResult& result : cases) page.AddTable(DistanceTable(result));
  page.OpenFold("E over λ");
  AddFigure(figures, "distance_over_lambda", page);
  page.CloseFold();
}

void AddEstimators(const std::vector<CaseResult>& cases,
                   report::HtmlPage& page) {
  if (cases.front().runs.front().estimators.empty()) return;
  page.OpenFold("Estimators side by side");
  page.AddParagraph(
      "On the same records. arx: ΔR by the exact engine, unless a test finds "
      "that the initial model explains the records; ceres: the same by "
      "smoothed L1, first seed only; output_error: gains, time constants and "
      "dead times. The information bound is the E that "
      "no unbiased estimate of the plant's parameters can beat on average; an "
      "estimate that knows which elements have aged can.");
  for (const CaseResult& result : cases) {
    page.AddTable(EstimatorTable(result, /*with_times=*/false));
  }
  page.CloseFold();
}

void AddAblations(const std::vector<CaseResult>& cases,
                  report::HtmlPage& page) {
  if (cases.front().ablations.empty()) return;
  page.OpenFold("What each decision is worth");
  page.AddParagraph(
      "The same records corrected with one decision taken differently. A large "
      "duality gap means that the fits are not exact.");
  for (const CaseResult& result : cases) {
    page.AddTable(AblationTable(result));
  }
  page.CloseFold();
}

void AddResponses(const std::vector<CaseResult>& cases, const Figures& figures,
                  report::HtmlPage& page) {
  page.OpenFold("Gains and dead times");
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
  page.CloseFold();
}

void AddLoops(const std::vector<CaseResult>& cases, const Figures& figures,
              report::HtmlPage& page) {
  page.OpenFold("The loop under control");
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
  page.CloseFold();
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
  page.SetVerdict(VerdictOn(cases));
  if (const report::Table table = PaperTable(cases); !table.rows.empty()) {
    page.AddHeading("The paper says · we find · why");
    page.AddTable(table);
  }
  AddFigure(figures, "overview", page);
  AddDistances(cases, figures, page);
  AddEstimators(cases, page);
  AddAblations(cases, page);
  AddResponses(cases, figures, page);
  AddLoops(cases, figures, page);
  AddCertificates(cases, page);
  page.AddLastFolds({}, run_again);
  return page.Render();
}

namespace {

using Json = nlohmann::ordered_json;

Json FopdtRows(const RunResult& run, int num_outputs, int num_inputs) {
  Json rows = Json::array();
  for (int i = 0; i < num_outputs; ++i) {
    Json row = Json::array();
    for (int j = 0; j < num_inputs; ++j) {
      const FopdtFit& fit = run.judgement.fopdt[i * num_inputs + j];
      row.push_back({{"gain", fit.gain},
                     {"time_constant", fit.time_constant},
                     {"delay", fit.delay}});
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Json FailureJson(const absl::Status& status) {
  return {{"failure", std::string(status.message())}};
}

Json EstimatorsJson(const std::vector<MethodRun>& estimators) {
  Json json = Json::object();
  for (const MethodRun& one : estimators) {
    json[one.name] = one.status.ok()
                         ? Json{{"E", one.E},
                                {"change_proposed", one.change_proposed},
                                {"p_value", one.p_value}}
                         : FailureJson(one.status);
  }
  return json;
}

Json AblationsJson(const std::vector<AblationResult>& results) {
  Json json = Json::object();
  for (const AblationResult& result : results) {
    Json runs = Json::array();
    for (const MethodRun& run : result.runs) {
      runs.push_back(run.status.ok() ? Json{{"lambda_star", run.lambda},
                                            {"E", run.E},
                                            {"max_relative_duality_gap",
                                             run.max_relative_gap}}
                                     : FailureJson(run.status));
    }
    json[result.ablation->name] = std::move(runs);
  }
  return json;
}

Json ToJson(const RunResult& run, const ProcessModel& plant) {
  Json json = {
      {"seed", run.seed},
      {"lambda_star", run.lambda_star},
      {"E_star", run.E_star},
      {"E_zero", run.E_zero},
      {"lambda_oracle", run.lambda_oracle},
      {"E_oracle", run.E_oracle},
      {"max_relative_duality_gap", run.max_relative_gap},
      {"static_gain_error", MatrixJson(run.judgement.static_gain_error)},
      {"delay_impulse_peak", MatrixJson(run.judgement.delay_impulse_peak)},
      {"fopdt", FopdtRows(run, plant.num_outputs(), plant.num_inputs())}};
  if (!run.estimators.empty()) {
    json["estimators"] = EstimatorsJson(run.estimators);
    if (run.E_limit > 0.0) json["E_limit"] = run.E_limit;
  }
  if (run.other_rule.has_value()) {
    json["other_rule"] = {{"selection", run.other_rule->name},
                          {"lambda", run.other_rule->lambda},
                          {"E", run.other_rule->E}};
  }
  if (run.selection.penalised_loss.size() > 0) {
    json["lambda_star_penalised_loss"] = run.selection.lambda_star_penalised;
  }
  const Eigen::VectorXd& each = run.selection.lambda_star;
  if ((each.array() != each(0)).any()) {
    json["lambda_star_per_output"] =
        std::vector<double>(each.data(), each.data() + each.size());
  }
  return json;
}

Json ToJson(const experiment::Distribution& values) {
  return {{"mean", values.mean},
          {"worst", values.max},
          {"best", values.min},
          {"standard_deviation", values.deviation}};
}

Json Summary(const CaseResult& result) {
  const int p = result.plant.num_outputs();
  const int m = result.plant.num_inputs();
  Eigen::MatrixXd static_gain(p, m), fopdt_gain(p, m), fopdt_delay(p, m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      const ElementErrors& e = result.elements[i * m + j];
      static_gain(i, j) = e.static_gain_error_rms;
      fopdt_gain(i, j) = e.fopdt_gain_error_rms;
      fopdt_delay(i, j) = e.fopdt_delay_error_rms;
    }
  }
  return {{"E_star", ToJson(result.E_star)},
          {"E_zero", ToJson(result.E_zero)},
          {"E_oracle", ToJson(result.E_oracle)},
          {"lambda_star", ToJson(result.lambda_star)},
          {"static_gain_error_rms", MatrixJson(static_gain)},
          {"fopdt_gain_error_rms", MatrixJson(fopdt_gain)},
          {"fopdt_delay_error_rms", MatrixJson(fopdt_delay)},
          {"max_relative_duality_gap", result.max_relative_gap}};
}

std::string FormatDistances(const RunResult& run,
                            const Eigen::VectorXd& lambdas) {
  const SelectionSummary& selection = run.selection;
  std::string csv = "lambda,E,selection_loss,penalised_loss\n";
  Eigen::Index next = 0;  // losses may be known at some λ only
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    absl::StrAppendFormat(&csv, "%.9g,%.12g,", lambdas(i),
                          run.squared_distance(i));
    if (next < selection.lambdas.size() &&
        selection.lambdas(next) == lambdas(i)) {
      absl::StrAppendFormat(&csv, "%.12g", selection.loss(next));
      if (selection.penalised_loss.size() > 0) {
        absl::StrAppendFormat(&csv, ",%.12g", selection.penalised_loss(next));
      } else {
        csv += ',';
      }
      ++next;
    } else {
      csv += ',';
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace

std::string FormatResults(const std::vector<CaseResult>& cases) {
  Json list = Json::array();
  for (const CaseResult& result : cases) {
    Json runs = Json::array();
    for (const RunResult& run : result.runs) {
      runs.push_back(ToJson(run, result.plant));
    }
    list.push_back({{"name", result.name},
                    {"E_initial", result.E_initial},
                    {"runs", std::move(runs)},
                    {"summary", Summary(result)},
                    {"closed_loop", ClosedLoopJson(result.ClosedLoops())}});
    if (!result.ablations.empty()) {
      list.back()["ablations"] = AblationsJson(result.ablations);
    }
  }
  const Json document = {{"version", 1},
                         {"program", "mle_reproduce"},
                         {"program_version", std::string(LibraryVersion())},
                         {"cases", std::move(list)}};
  return FormatJson(document);
}

std::vector<File> FormatCurves(const std::vector<CaseResult>& cases,
                               const Eigen::VectorXd& lambdas) {
  std::vector<File> files;
  for (const CaseResult& result : cases) {
    const RunResult& first = result.runs.front();
    files.emplace_back(absl::StrCat("curve_", result.name, ".csv"),
                       FormatDistances(first, lambdas));
    files.emplace_back(
        absl::StrCat("step_response_", result.name, ".csv"),
        FormatStepResponses(result.plant, result.truth.sample_time,
                            {{"initial", result.initial.values},
                             {"true", result.truth.values},
                             {"corrected", first.corrected.values},
                             {"unregularised", first.unregularised.values}}));
  }
  return files;
}

}  // namespace mle::reproduce
