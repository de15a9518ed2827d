#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>

#include "apps/common/model_files.h"
#include "apps/common/sha256.h"
#include "apps/correct/report.h"
#include "apps/correct/request.h"
#include "apps/correct/result_json.h"
#include "apps/report/drawing.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/mat_file.h"
#include "mle/model/arx_model_json.h"
#include "mle/model/json_text.h"
#include "mle/nonlinear/distributions.h"
#include "nlohmann/json.hpp"

namespace mle::correct {
namespace {

using Json = nlohmann::ordered_json;

Json FileJson(const DataFile& file) {
  return {{"path", file.path}, {"sha256", file.sha256}, {"bytes", file.bytes}};
}

// A model in memory is hashed as the file it would be.
absl::StatusOr<DataFile> GivenModel(const Result& result) {
  const std::string& path = result.request.model_path;
  if (!path.empty()) return ReadDataFile(path);
  const std::string text = FormatProcessModel(result.initial);
  return DataFile{"", Sha256Of(text), static_cast<std::int64_t>(text.size())};
}

absl::StatusOr<Json> InputsJson(const Result& result) {
  Json inputs;
  MLE_ASSIGN_OR_RETURN(const DataFile model, GivenModel(result));
  inputs["model"] = FileJson(model);
  if (!result.request.truth_path.empty()) {
    MLE_ASSIGN_OR_RETURN(const DataFile truth,
                         ReadDataFile(result.request.truth_path));
    inputs["truth"] = FileJson(truth);
  }
  Json data = Json::array();
  for (const DataFile& file : result.files) {
    data.push_back(FileJson(file));
  }
  inputs["data"] = std::move(data);
  return inputs;
}

NamedResponses CurvesOf(const Result& result) {
  NamedResponses curves = {{"initial", result.initial_response.values},
                           {"corrected", result.corrected.response.values}};
  if (result.true_response.has_value()) {
    curves.emplace_back("true", result.true_response->values);
  }
  if (result.corrected.errors.has_value()) {
    const Eigen::MatrixXd half_width =
        BandFactor(result) * result.corrected.errors->values;
    const Eigen::MatrixXd& middle = result.corrected.response.values;
    curves.emplace_back("corrected_lower", middle - half_width);
    curves.emplace_back("corrected_upper", middle + half_width);
  }
  return curves;
}

}  // namespace

double BandFactor(const Result& result) {
  return StudentTwoSidedQuantile(
      1.0 - result.options.estimation.output_error.confidence,
      std::numeric_limits<double>::infinity());
}

absl::StatusOr<std::string> FormatResult(
    const Result& result, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags) {
  Json json = {{"version", 3},
               {"program", "mle_correct"},
               {"program_version", std::string(LibraryVersion())},
               {"command", command}};
  Json flag_values = Json::object();
  for (const auto& [name, value] : flags) flag_values[name] = value;
  json["flags"] = std::move(flag_values);
  MLE_ASSIGN_OR_RETURN(json["inputs"], InputsJson(result));
  AddFindings(result, json);
  AddDiagnostics(result, json);
  return FormatJson(json);
}

std::string FormatArx(const ArxModel& model, const ProcessModel& channels) {
  return FormatArxModel({channels.name(), channels.time_unit(),
                         NamesOf(channels.outputs()),
                         NamesOf(channels.inputs()), model});
}

std::string FormatStepResponses(const Result& result) {
  return mle::FormatStepResponses(
      result.initial, result.initial_response.sample_time, CurvesOf(result));
}

namespace {

// Names that pictures may have and none of `files` has: there may be some of a
// former run.
std::vector<std::string> OtherPictures(
    const std::vector<std::pair<std::string, std::string>>& files) {
  std::vector<std::string> others;
  for (const std::string_view figure : kFigureNames) {
    for (const char* const extension : {".svg", ".png", ".pdf"}) {
      std::string name = std::string(figure).append(extension);
      const bool written =
          std::any_of(files.begin(), files.end(),
                      [&](const auto& file) { return file.first == name; });
      if (!written) others.push_back(std::move(name));
    }
  }
  return others;
}

}  // namespace

absl::Status WriteResult(const Result& result, const std::string& json,
                         const report::RunAgain& again) {
  std::vector<report::DrawnFigure> figures;
  if (result.request.figures) {
    figures = report::DrawFigures(MakeFigures(result), result.options.threads);
  }
  std::string page = FormatPage(result, figures, again);
  const ProcessModel& initial = result.initial;
  std::vector<std::pair<std::string, std::string>> files = {
      {"model.json", FormatProcessModel(result.model)},
      {"fopdt.json", FormatProcessModel(result.fopdt_model)},
      {"step_response.csv", FormatStepResponses(result)},
      {"report.html", std::move(page)},
      {"result.json", json}};
  const bool state_space = result.state_space.model.has_value();
  if (state_space) {
    files.emplace_back("state_space.json",
                       FormatStateSpace(*result.state_space.model));
  }
  const bool arx = result.corrected.has_arx();
  if (arx) {
    files.emplace_back("arx.json", FormatArx(result.corrected.arx, initial));
  }
  MLE_ASSIGN_OR_RETURN(std::string mat,
                       FormatMat(result.model, &result.corrected.response));
  files.emplace_back("model.mat", std::move(mat));
  const std::string given_name = CorrectedName(result.request.model_file);
  if (!given_name.empty()) {
    MLE_ASSIGN_OR_RETURN(
        FormattedModel as_given,
        FormatCorrected(result.request.model_file,
                        InWholeModel(result.request, result.model)));
    files.emplace_back(given_name, std::move(as_given.text));
  }
  report::AddPictures(figures, files);
  std::vector<std::string> obsolete = OtherPictures(files);
  // Those of a former run would be of another model.
  if (!arx) obsolete.emplace_back("arx.json");
  if (!state_space) obsolete.emplace_back("state_space.json");
  for (const char* name :
       {"model_corrected.csv", "model_corrected.json", "model_corrected.mat"}) {
    if (given_name != name) obsolete.emplace_back(name);
  }
  return WriteFilesTogether(result.request.out, files, obsolete);
}

}  // namespace mle::correct
