#include "mle/model/state_space_json.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/model/json_matrix.h"
#include "mle/model/json_node.h"
#include "mle/model/json_text.h"
#include "mle/model/process_model.h"
#include "mle/model/strict_json.h"
#include "mle/model/unreached_states.h"

namespace mle {
namespace {

constexpr int kStateSpaceFormatVersion = 1;
// More states than any model has; a file that asks for more is broken.
constexpr int kMaxStates = 100'000;

absl::StatusOr<std::vector<int>> ReadDelays(const JsonNode& node, int wanted,
                                            const char* kind) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> entries, node.Elements());
  if (static_cast<int>(entries.size()) != wanted) {
    return node.Fault("must be a list of ", wanted,
                      " whole numbers, one for each ", kind, ", is one of ",
                      entries.size());
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
  return InvalidArgument("accuracy: ", name, " must hold ", num_outputs,
                         " finite numbers ≥ 0, one for each output");
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

// Dead times are 0 where there is no `key`.
absl::Status ReadDelays(const JsonNode& top, const char* key, int wanted,
                        const char* kind, std::vector<int>& delays) {
  delays.assign(wanted, 0);
  if (!top.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(delays, ReadDelays(top.At(key), wanted, kind));
  return absl::OkStatus();
}

absl::Status ReadWords(const JsonNode& top, const char* key,
                       std::vector<std::string>& words) {
  if (!top.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At(key).ElementsOrNone());
  for (const JsonNode& node : nodes) {
    MLE_ASSIGN_OR_RETURN(std::string word, node.String());
    words.push_back(std::move(word));
  }
  return absl::OkStatus();
}

absl::Status CheckUnits(const char* key, const std::vector<std::string>& units,
                        std::size_t channels) {
  if (units.empty() || units.size() == channels) return absl::OkStatus();
  return InvalidArgument(key, " has ", units.size(), " units, must have ",
                         channels);
}

absl::StatusOr<DisturbanceForm> ReadDisturbanceModel(const JsonNode& node,
                                                     int p) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"A", "C", "K", "Q", "R"}, {}));
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> rows,
                       node.At("A").Elements());
  if (rows.size() > kMaxStates) {
    return node.At("A").Fault("has ", rows.size(), " rows, at most ",
                              kMaxStates, " are supported");
  }
  const auto n = static_cast<int>(rows.size());
  const std::string states = "one for each state";
  const std::string outputs = "one for each output";
  DisturbanceForm form;
  MLE_ASSIGN_OR_RETURN(form.A, ReadMatrix(node.At("A"), n, n, states, states));
  MLE_ASSIGN_OR_RETURN(form.C, ReadMatrix(node.At("C"), p, n, outputs, states));
  MLE_ASSIGN_OR_RETURN(form.K, ReadMatrix(node.At("K"), n, p, states, outputs));
  MLE_ASSIGN_OR_RETURN(form.Q, ReadMatrix(node.At("Q"), n, n, states, states));
  MLE_ASSIGN_OR_RETURN(const std::vector<double> variances,
                       node.At("R").Numbers());
  if (static_cast<int>(variances.size()) != p) {
    return node.At("R").Fault("must be a list of ", p, " numbers, ", outputs,
                              ", is one of ", variances.size());
  }
  form.R = Eigen::Map<const Eigen::VectorXd>(
      variances.data(), static_cast<Eigen::Index>(variances.size()));
  return form;
}

// States that the file counts, or that A has rows.
absl::StatusOr<std::int64_t> ReadOrder(const JsonNode& top) {
  if (top.Has("order")) return top.At("order").Integer(1, kMaxStates);
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> rows,
                       top.At("A").Elements());
  return static_cast<std::int64_t>(rows.size());
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
  system.D = Eigen::MatrixXd::Zero(p, m);
  if (!top.Has("D")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(system.D,
                       ReadMatrix(top.At("D"), p, m, outputs, inputs));
  return absl::OkStatus();
}

absl::StatusOr<NamedStateSpace> ParseNamedStateSpace(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "sample_time", "outputs", "inputs", "A", "B", "C"},
      {"version", "program_version", "order", "accuracy", "output_units",
       "input_units", "disturbances", "disturbance_model", "input_delays",
       "output_delays", "D"}));
  if (top.Has("version")) {
    MLE_RETURN_IF_ERROR(
        top.At("version")
            .Integer(kStateSpaceFormatVersion, kStateSpaceFormatVersion)
            .status());
  }
  NamedStateSpace named;
  MLE_ASSIGN_OR_RETURN(named.name, top.At("name").String());
  MLE_ASSIGN_OR_RETURN(named.time_unit, top.At("time_unit").String());
  MLE_ASSIGN_OR_RETURN(named.outputs, top.At("outputs").Strings());
  MLE_ASSIGN_OR_RETURN(named.inputs, top.At("inputs").Strings());
  DiscreteStateSpace& system = named.system;
  MLE_ASSIGN_OR_RETURN(system.sample_time, top.At("sample_time").Number());
  MLE_ASSIGN_OR_RETURN(const std::int64_t order, ReadOrder(top));
  const int p = static_cast<int>(named.outputs.size());
  const int m = static_cast<int>(named.inputs.size());
  MLE_RETURN_IF_ERROR(
      ReadDelays(top, "input_delays", m, "input", system.input_delays));
  MLE_RETURN_IF_ERROR(
      ReadDelays(top, "output_delays", p, "output", system.output_delays));
  MLE_RETURN_IF_ERROR(ReadWords(top, "output_units", named.output_units));
  MLE_RETURN_IF_ERROR(ReadWords(top, "input_units", named.input_units));
  MLE_RETURN_IF_ERROR(ReadWords(top, "disturbances", named.disturbances));
  MLE_RETURN_IF_ERROR(ReadMatrices(top, static_cast<int>(order), p, m, system));
  if (top.Has("accuracy")) {
    MLE_ASSIGN_OR_RETURN(named.accuracy, ReadAccuracy(top.At("accuracy")));
  }
  if (top.Has("disturbance_model")) {
    MLE_ASSIGN_OR_RETURN(named.disturbance_model,
                         ReadDisturbanceModel(top.At("disturbance_model"), p));
  }
  const absl::Status status = named.Validate();
  if (status.ok()) return named;
  // The fault may lie in states that no input reaches.
  NamedStateSpace reached = named;
  reached.unreached_states = LeaveOutUnreachedStates(reached.system);
  if (reached.unreached_states > 0 && reached.Validate().ok()) return reached;
  return top.Check(status);
}

}  // namespace

absl::Status NamedStateSpace::Validate() const {
  MLE_RETURN_IF_ERROR(system.Validate());
  MLE_RETURN_IF_ERROR(CheckChannelNames(outputs, system.num_outputs(), inputs,
                                        system.num_inputs()));
  MLE_RETURN_IF_ERROR(CheckUnits("output_units", output_units, outputs.size()));
  MLE_RETURN_IF_ERROR(CheckUnits("input_units", input_units, inputs.size()));
  for (const std::string& input : disturbances) {
    if (std::find(inputs.begin(), inputs.end(), input) != inputs.end())
      continue;
    return InvalidArgument("disturbances: ", QuotedJson(input),
                           " is not an input; the inputs are ",
                           absl::StrJoin(inputs, ", "));
  }
  if (disturbance_model.has_value()) {
    MLE_RETURN_IF_ERROR(disturbance_model->Validate(system.num_outputs()));
  }
  if (!accuracy.has_value()) return absl::OkStatus();
  MLE_RETURN_IF_ERROR(CheckErrors("error_bounds", accuracy->error_bounds,
                                  system.num_outputs()));
  return CheckErrors("largest_differences", accuracy->largest_differences,
                     system.num_outputs());
}

ProcessModel NamedStateSpace::Channels() const {
  std::vector<InputChannel> its_inputs;
  for (std::size_t j = 0; j < inputs.size(); ++j) {
    const bool disturbance = std::find(disturbances.begin(), disturbances.end(),
                                       inputs[j]) != disturbances.end();
    its_inputs.push_back(
        {inputs[j], input_units.empty() ? "" : input_units[j],
         disturbance ? InputRole::kDisturbance : InputRole::kManipulated});
  }
  std::vector<OutputChannel> its_outputs;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    its_outputs.push_back(
        {outputs[i], output_units.empty() ? "" : output_units[i]});
  }
  return {name, time_unit, std::move(its_inputs), std::move(its_outputs)};
}

void NamedStateSpace::SetChannels(const ProcessModel& channels) {
  name = channels.name();
  time_unit = channels.time_unit();
  outputs.clear();
  inputs.clear();
  output_units.clear();
  input_units.clear();
  disturbances.clear();
  for (const OutputChannel& output : channels.outputs()) {
    outputs.push_back(output.name);
    output_units.push_back(output.unit);
  }
  for (const InputChannel& input : channels.inputs()) {
    inputs.push_back(input.name);
    input_units.push_back(input.unit);
    if (input.role == InputRole::kDisturbance) {
      disturbances.push_back(input.name);
    }
  }
}

absl::StatusOr<NamedStateSpace> ParseStateSpace(std::string_view json,
                                                std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, source));
  return ParseNamedStateSpace(JsonNode(top, std::string(source)));
}

std::string FormatStateSpace(const NamedStateSpace& named) {
  using Json = nlohmann::ordered_json;
  const DiscreteStateSpace& system = named.system;
  Json json = {{"version", kStateSpaceFormatVersion},
               {"program_version", std::string(LibraryVersion())},
               {"name", named.name},
               {"time_unit", named.time_unit},
               {"sample_time", system.sample_time},
               {"order", system.order()},
               {"outputs", named.outputs},
               {"inputs", named.inputs}};
  if (!named.output_units.empty()) json["output_units"] = named.output_units;
  if (!named.input_units.empty()) json["input_units"] = named.input_units;
  if (!named.disturbances.empty()) json["disturbances"] = named.disturbances;
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
  if (named.disturbance_model.has_value()) {
    const DisturbanceForm& form = *named.disturbance_model;
    json["disturbance_model"] = {
        {"A", MatrixJson(form.A)},
        {"C", MatrixJson(form.C)},
        {"K", MatrixJson(form.K)},
        {"Q", MatrixJson(form.Q)},
        {"R", std::vector<double>(form.R.begin(), form.R.end())}};
  }
  return FormatJson(json);
}

absl::StatusOr<NamedStateSpace> ReadStateSpace(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseStateSpace(text, path);
}

}  // namespace mle
