#include "mle/model/arx_model_json.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/model/json_node.h"
#include "mle/model/json_text.h"
#include "mle/model/strict_json.h"

namespace mle {
namespace {

constexpr int kFormatVersion = 1;
// More lags than any model has; a file that asks for more is broken.
constexpr int kMaxOrder = 1'000'000;

absl::Status CheckNames(const std::vector<std::string>& names, int wanted,
                        const char* kind, std::set<std::string>& seen) {
  if (static_cast<int>(names.size()) != wanted) {
    return absl::InvalidArgumentError(
        absl::StrCat(names.size(), " names for ", wanted, " ", kind, "s"));
  }
  for (const std::string& name : names) {
    if (name.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("an ", kind, " has an empty name"));
    }
    if (!seen.insert(name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("the name ", QuotedJson(name),
                       " stands twice; each channel needs its own"));
    }
  }
  return absl::OkStatus();
}

// R, a list of p rows of d(p+m) numbers.
absl::StatusOr<Eigen::MatrixXd> ParseMatrix(const JsonNode& node,
                                            int num_outputs,
                                            int num_regressors) {
  const nlohmann::json& rows = node.json();
  if (!rows.is_array() ||
      rows.size() != static_cast<std::size_t>(num_outputs)) {
    return node.Fault(absl::StrCat(
        "must be a list of ", num_outputs, " rows, one for each output, is ",
        rows.is_array() ? absl::StrCat("one of ", rows.size()) : node.Found()));
  }
  // Rows are as long as they should be before memory is taken for them.
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> row_nodes, node.Elements());
  for (const JsonNode& row : row_nodes) {
    if (!row.json().is_array() ||
        row.json().size() != static_cast<std::size_t>(num_regressors)) {
      return row.Fault(absl::StrCat(
          "must be a list of ", num_regressors,
          " numbers, order × channels, is ",
          row.json().is_array() ? absl::StrCat("one of ", row.json().size())
                                : row.Found()));
    }
  }
  Eigen::MatrixXd R(num_outputs, num_regressors);
  for (int i = 0; i < num_outputs; ++i) {
    MLE_ASSIGN_OR_RETURN(const std::vector<double> row, row_nodes[i].Numbers());
    R.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), num_regressors);
  }
  return R;
}

absl::StatusOr<NamedArxModel> ParseNamed(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(
      top.CheckKeys({"version", "name", "time_unit", "sample_time", "order",
                     "outputs", "inputs", "R"},
                    {"program_version"}));
  MLE_RETURN_IF_ERROR(
      top.At("version").Integer(kFormatVersion, kFormatVersion).status());
  NamedArxModel named;
  MLE_ASSIGN_OR_RETURN(named.name, top.At("name").String());
  MLE_ASSIGN_OR_RETURN(named.time_unit, top.At("time_unit").String());
  MLE_ASSIGN_OR_RETURN(named.outputs, top.At("outputs").Strings());
  MLE_ASSIGN_OR_RETURN(named.inputs, top.At("inputs").Strings());
  ArxModel& model = named.model;
  MLE_ASSIGN_OR_RETURN(model.sample_time, top.At("sample_time").Number());
  MLE_ASSIGN_OR_RETURN(const std::int64_t order,
                       top.At("order").Integer(1, kMaxOrder));
  model.order = static_cast<int>(order);
  const std::size_t channels = named.outputs.size() + named.inputs.size();
  if (channels > static_cast<std::size_t>(kMaxOrder / model.order)) {
    return top.Fault(absl::StrCat(model.order, " lags of ", channels,
                                  " channels are more than ", kMaxOrder,
                                  " regressors"));
  }
  model.num_outputs = static_cast<int>(named.outputs.size());
  model.num_inputs = static_cast<int>(named.inputs.size());
  MLE_ASSIGN_OR_RETURN(model.R, ParseMatrix(top.At("R"), model.num_outputs,
                                            model.num_regressors()));
  if (const absl::Status status = named.Validate(); !status.ok()) {
    return top.Fault(std::string(status.message()));
  }
  return named;
}

}  // namespace

absl::Status NamedArxModel::Validate() const {
  MLE_RETURN_IF_ERROR(model.Validate());
  std::set<std::string> seen;
  MLE_RETURN_IF_ERROR(CheckNames(outputs, model.num_outputs, "output", seen));
  return CheckNames(inputs, model.num_inputs, "input", seen);
}

absl::StatusOr<NamedArxModel> ParseArxModel(std::string_view json,
                                            std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, source));
  return ParseNamed(JsonNode(top, std::string(source)));
}

std::string FormatArxModel(const NamedArxModel& named) {
  using Json = nlohmann::ordered_json;
  const Json json = {
      {"version", kFormatVersion},    {"name", named.name},
      {"time_unit", named.time_unit}, {"sample_time", named.model.sample_time},
      {"order", named.model.order},   {"outputs", named.outputs},
      {"inputs", named.inputs},       {"R", MatrixJson(named.model.R)}};
  return FormatJson(json);
}

absl::StatusOr<NamedArxModel> ReadArxModel(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseArxModel(text, path);
}

}  // namespace mle
