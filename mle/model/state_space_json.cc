#include "mle/model/state_space_json.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/model/json_matrix.h"
#include "mle/model/json_node.h"
#include "mle/model/json_text.h"
#include "mle/model/strict_json.h"

namespace mle {
namespace {

constexpr int kFormatVersion = 1;
// More states than any model has; a file that asks for more is broken.
constexpr int kMaxOrder = 100'000;

absl::StatusOr<std::vector<int>> ReadDelays(const JsonNode& node, int wanted,
                                            const char* kind) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> entries, node.Elements());
  if (static_cast<int>(entries.size()) != wanted) {
    return node.Fault(absl::StrCat("must be a list of ", wanted,
                                   " whole numbers, one for each ", kind,
                                   ", is one of ", entries.size()));
  }
  std::vector<int> delays;
  for (const JsonNode& entry : entries) {
    MLE_ASSIGN_OR_RETURN(const std::int64_t delay,
                         entry.Integer(0, kMaxStateSpaceDelay));
    delays.push_back(static_cast<int>(delay));
  }
  return delays;
}

absl::Status CheckErrors(const char* name, const std::vector<double>& errors,
                         int num_outputs) {
  bool valid = static_cast<int>(errors.size()) == num_outputs;
  for (const double error : errors) {
    valid = valid && std::isfinite(error) && error >= 0.0;
  }
  if (valid) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("accuracy: ", name, " must hold ", num_outputs,
                   " finite numbers ≥ 0, one for each output"));
}

absl::StatusOr<StateSpaceAccuracy> ReadAccuracy(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"error_bounds", "largest_differences"}, {}));
  StateSpaceAccuracy accuracy;
  MLE_ASSIGN_OR_RETURN(accuracy.error_bounds,
                       node.At("error_bounds").Numbers());
  MLE_ASSIGN_OR_RETURN(accuracy.largest_differences,
                       node.At("largest_differences").Numbers());
  return accuracy;
}

absl::Status ReadMatrices(const JsonNode& top, int n, int p, int m,
                          DiscreteStateSpace& system) {
  const std::string states = "one for each state";
  const std::string inputs = "one for each input";
  const std::string outputs = "one for each output";
  MLE_ASSIGN_OR_RETURN(system.A, ReadMatrix(top.At("A"), n, n, states, states));
  MLE_ASSIGN_OR_RETURN(system.B, ReadMatrix(top.At("B"), n, m, states, inputs));
  MLE_ASSIGN_OR_RETURN(system.C,
                       ReadMatrix(top.At("C"), p, n, outputs, states));
  MLE_ASSIGN_OR_RETURN(system.D,
                       ReadMatrix(top.At("D"), p, m, outputs, inputs));
  return absl::OkStatus();
}

absl::StatusOr<NamedStateSpace> ParseNamed(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"version", "name", "time_unit", "sample_time", "order", "outputs",
       "inputs", "input_delays", "output_delays", "A", "B", "C", "D"},
      {"program_version", "accuracy"}));
  MLE_RETURN_IF_ERROR(
      top.At("version").Integer(kFormatVersion, kFormatVersion).status());
  NamedStateSpace named;
  MLE_ASSIGN_OR_RETURN(named.name, top.At("name").String());
  MLE_ASSIGN_OR_RETURN(named.time_unit, top.At("time_unit").String());
  MLE_ASSIGN_OR_RETURN(named.outputs, top.At("outputs").Strings());
  MLE_ASSIGN_OR_RETURN(named.inputs, top.At("inputs").Strings());
  DiscreteStateSpace& system = named.system;
  MLE_ASSIGN_OR_RETURN(system.sample_time, top.At("sample_time").Number());
  MLE_ASSIGN_OR_RETURN(const std::int64_t order,
                       top.At("order").Integer(1, kMaxOrder));
  const int p = static_cast<int>(named.outputs.size());
  const int m = static_cast<int>(named.inputs.size());
  MLE_ASSIGN_OR_RETURN(system.input_delays,
                       ReadDelays(top.At("input_delays"), m, "input"));
  MLE_ASSIGN_OR_RETURN(system.output_delays,
                       ReadDelays(top.At("output_delays"), p, "output"));
  MLE_RETURN_IF_ERROR(ReadMatrices(top, static_cast<int>(order), p, m, system));
  if (top.Has("accuracy")) {
    MLE_ASSIGN_OR_RETURN(named.accuracy, ReadAccuracy(top.At("accuracy")));
  }
  if (const absl::Status status = named.Validate(); !status.ok()) {
    return top.Fault(std::string(status.message()));
  }
  return named;
}

}  // namespace

absl::Status NamedStateSpace::Validate() const {
  MLE_RETURN_IF_ERROR(system.Validate());
  MLE_RETURN_IF_ERROR(CheckChannelNames(outputs, system.num_outputs(), inputs,
                                        system.num_inputs()));
  if (!accuracy.has_value()) return absl::OkStatus();
  MLE_RETURN_IF_ERROR(CheckErrors("error_bounds", accuracy->error_bounds,
                                  system.num_outputs()));
  return CheckErrors("largest_differences", accuracy->largest_differences,
                     system.num_outputs());
}

absl::StatusOr<NamedStateSpace> ParseStateSpace(std::string_view json,
                                                std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, source));
  return ParseNamed(JsonNode(top, std::string(source)));
}

std::string FormatStateSpace(const NamedStateSpace& named) {
  using Json = nlohmann::ordered_json;
  const DiscreteStateSpace& system = named.system;
  Json json = {{"version", kFormatVersion},
               {"program_version", std::string(LibraryVersion())},
               {"name", named.name},
               {"time_unit", named.time_unit},
               {"sample_time", system.sample_time},
               {"order", system.order()},
               {"outputs", named.outputs},
               {"inputs", named.inputs}};
  if (named.accuracy.has_value()) {
    json["accuracy"] = {
        {"error_bounds", named.accuracy->error_bounds},
        {"largest_differences", named.accuracy->largest_differences}};
  }
  json["input_delays"] = system.input_delays;
  json["output_delays"] = system.output_delays;
  json["A"] = MatrixJson(system.A);
  json["B"] = MatrixJson(system.B);
  json["C"] = MatrixJson(system.C);
  json["D"] = MatrixJson(system.D);
  return FormatJson(json);
}

absl::StatusOr<NamedStateSpace> ReadStateSpace(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseStateSpace(text, path);
}

}  // namespace mle
