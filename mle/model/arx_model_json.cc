#include "mle/model/arx_model_json.h"

#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_matrix.h"
#include "mle/model/json_node.h"
#include "mle/model/json_text.h"
#include "mle/model/strict_json.h"

namespace mle {
namespace {

constexpr int kArxFormatVersion = 1;
// More lags than any model has; a file that asks for more is broken.
constexpr int kMaxArxOrder = 1'000'000;

absl::StatusOr<NamedArxModel> ParseNamedArx(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(
      top.CheckKeys({"version", "name", "time_unit", "sample_time", "order",
                     "outputs", "inputs", "R"},
                    {"program_version"}));
  MLE_RETURN_IF_ERROR(
      top.At("version").Integer(kArxFormatVersion, kArxFormatVersion).status());
  NamedArxModel named;
  MLE_ASSIGN_OR_RETURN(named.name, top.At("name").String());
  MLE_ASSIGN_OR_RETURN(named.time_unit, top.At("time_unit").String());
  MLE_ASSIGN_OR_RETURN(named.outputs, top.At("outputs").Strings());
  MLE_ASSIGN_OR_RETURN(named.inputs, top.At("inputs").Strings());
  ArxModel& model = named.model;
  MLE_ASSIGN_OR_RETURN(model.sample_time, top.At("sample_time").Number());
  MLE_ASSIGN_OR_RETURN(const std::int64_t order,
                       top.At("order").Integer(1, kMaxArxOrder));
  model.order = static_cast<int>(order);
  const std::size_t channels = named.outputs.size() + named.inputs.size();
  if (channels > static_cast<std::size_t>(kMaxArxOrder / model.order)) {
    return top.Fault(model.order, " lags of ", channels,
                     " channels are more than ", kMaxArxOrder, " regressors");
  }
  model.num_outputs = static_cast<int>(named.outputs.size());
  model.num_inputs = static_cast<int>(named.inputs.size());
  MLE_ASSIGN_OR_RETURN(
      model.R,
      ReadMatrix(top.At("R"), model.num_outputs, model.num_regressors(),
                 "one for each output", "order × channels"));
  MLE_RETURN_IF_ERROR(top.Check(named.Validate()));
  return named;
}

}  // namespace

absl::Status NamedArxModel::Validate() const {
  MLE_RETURN_IF_ERROR(model.Validate());
  return CheckChannelNames(outputs, model.num_outputs, inputs,
                           model.num_inputs);
}

absl::StatusOr<NamedArxModel> ParseArxModel(std::string_view json,
                                            std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, source));
  return ParseNamedArx(JsonNode(top, std::string(source)));
}

std::string FormatArxModel(const NamedArxModel& named) {
  using Json = nlohmann::ordered_json;
  const Json json = {
      {"version", kArxFormatVersion}, {"name", named.name},
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
