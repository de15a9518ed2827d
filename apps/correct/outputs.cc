#include "apps/correct/outputs.h"

#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/command_line.h"
#include "apps/common/sha256.h"
#include "apps/correct/advice.h"
#include "apps/correct/checksum.h"
#include "apps/correct/result_json.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/model/arx_model_json.h"
#include "mle/model/json_text.h"
#include "mle/nonlinear/distributions.h"
#include "nlohmann/json.hpp"

namespace mle::correct {
namespace {

using Json = nlohmann::ordered_json;

absl::StatusOr<Json> FileJson(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const FileChecksum checksum, ChecksumOf(path));
  return Json{
      {"path", path}, {"sha256", checksum.sha256}, {"bytes", checksum.bytes}};
}

// A model in memory is hashed as the file it would be.
absl::StatusOr<Json> ModelJson(const Result& result) {
  const std::string& path = result.request.model_path;
  if (!path.empty()) return FileJson(path);
  const std::string text = FormatProcessModel(result.initial);
  return Json{{"path", ""}, {"sha256", Sha256Of(text)}, {"bytes", text.size()}};
}

absl::StatusOr<Json> InputsJson(const Result& result) {
  Json inputs;
  MLE_ASSIGN_OR_RETURN(inputs["model"], ModelJson(result));
  if (!result.request.truth_path.empty()) {
    MLE_ASSIGN_OR_RETURN(inputs["truth"], FileJson(result.request.truth_path));
  }
  Json data = Json::array();
  for (const DataFile& file : result.files) {
    data.push_back(
        {{"path", file.path}, {"sha256", file.sha256}, {"bytes", file.bytes}});
  }
  inputs["data"] = std::move(data);
  return inputs;
}

// The columns of one model.
struct Curve {
  std::string name;
  Eigen::MatrixXd values;
};

std::vector<Curve> CurvesOf(const Result& result) {
  std::vector<Curve> curves = {{"initial", result.initial_response.values},
                               {"corrected", result.corrected.response.values}};
  if (result.true_response.has_value()) {
    curves.push_back({"true", result.true_response->values});
  }
  if (result.corrected.errors.has_value()) {
    const Eigen::MatrixXd half_width =
        BandFactor(result) * result.corrected.errors->values;
    const Eigen::MatrixXd& middle = result.corrected.response.values;
    curves.push_back({"corrected_lower", middle - half_width});
    curves.push_back({"corrected_upper", middle + half_width});
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
               {"program_version", std::string(Version())},
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
  NamedArxModel named = {channels.name(), channels.time_unit(), {}, {}, model};
  for (const InputChannel& input : channels.inputs()) {
    named.inputs.push_back(input.name);
  }
  for (const OutputChannel& output : channels.outputs()) {
    named.outputs.push_back(output.name);
  }
  return FormatArxModel(named);
}

std::string FormatStepResponses(const Result& result) {
  const ProcessModel& model = result.initial;
  const std::vector<Curve> curves = CurvesOf(result);
  std::string csv = "time";
  for (const Curve& curve : curves) {
    for (const OutputChannel& output : model.outputs()) {
      for (const InputChannel& input : model.inputs()) {
        absl::StrAppend(&csv, ",",
                        QuoteCsvField(absl::StrCat(output.name, "/", input.name,
                                                   " ", curve.name)));
      }
    }
  }
  csv += '\n';
  for (int k = 0; k < result.initial_response.samples(); ++k) {
    absl::StrAppendFormat(&csv, "%.12g",
                          k * result.initial_response.sample_time);
    for (const Curve& curve : curves) {
      for (const double value : curve.values.row(k)) {
        if (std::isfinite(value)) {
          absl::StrAppendFormat(&csv, ",%.12g", value);
        } else {
          csv += ',';  // not determined
        }
      }
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace mle::correct
