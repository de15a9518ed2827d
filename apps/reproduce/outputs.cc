#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/reproduce/report.h"
#include "mle/base/version.h"
#include "mle/data/csv_rows.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::reproduce {
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

std::string FormatStepResponses(const CaseResult& result) {
  const RunResult& run = result.runs.front();
  const std::pair<const char*, const StepResponse*> models[] = {
      {"initial", &result.initial},
      {"true", &result.truth},
      {"corrected", &run.corrected},
      {"unregularised", &run.unregularised}};
  std::string csv = "time";
  for (const auto& [name, response] : models) {
    for (const OutputChannel& output : result.plant.outputs()) {
      for (const InputChannel& input : result.plant.inputs()) {
        absl::StrAppend(&csv, ",",
                        QuoteCsvField(absl::StrCat(output.name, "/", input.name,
                                                   " ", name)));
      }
    }
  }
  csv += '\n';
  for (int k = 0; k < result.truth.samples(); ++k) {
    absl::StrAppendFormat(&csv, "%.12g", k * result.truth.sample_time);
    for (const auto& [name, response] : models) {
      for (Eigen::Index column = 0; column < response->values.cols();
           ++column) {
        absl::StrAppendFormat(&csv, ",%.12g", response->values(k, column));
      }
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
    files.emplace_back(absl::StrCat("curve_", result.name, ".csv"),
                       FormatDistances(result.runs.front(), lambdas));
    files.emplace_back(absl::StrCat("step_response_", result.name, ".csv"),
                       FormatStepResponses(result));
  }
  return files;
}

}  // namespace mle::reproduce
