#include <algorithm>
#include <charconv>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_node.h"
#include "mle/model/process_model.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

using Json = nlohmann::json;
using Keys = std::vector<std::string>;

// More pairs than any plant has; a file that asks for more is broken.
constexpr std::size_t kMaxPairs = 250'000;

absl::StatusOr<InputChannel> ParseInput(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name", "unit"}, {"role"}));
  InputChannel input;
  MLE_ASSIGN_OR_RETURN(input.name, node.At("name").String());
  MLE_ASSIGN_OR_RETURN(input.unit, node.At("unit").String());
  if (node.Has("role")) {
    MLE_ASSIGN_OR_RETURN(const std::string role, node.At("role").String());
    if (role != "manipulated" && role != "disturbance") {
      return node.At("role").Fault(
          absl::StrCat("is ", QuotedJson(role),
                       ", must be \"manipulated\" or \"disturbance\""));
    }
    if (role == "disturbance") input.role = InputRole::kDisturbance;
  }
  return input;
}

absl::StatusOr<OutputChannel> ParseOutput(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name", "unit"}, {}));
  OutputChannel output;
  MLE_ASSIGN_OR_RETURN(output.name, node.At("name").String());
  MLE_ASSIGN_OR_RETURN(output.unit, node.At("unit").String());
  return output;
}

// The index of the channel that `key` names.
template <typename Channel>
absl::StatusOr<int> FindChannel(const JsonNode& node, const std::string& key,
                                const std::vector<Channel>& channels) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.At(key).String());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return static_cast<int>(i);
  }
  return node.At(key).Fault(absl::StrCat(
      QuotedJson(name), " is unknown; the ", key, "s are ",
      absl::StrJoin(channels, ", ",
                    [](std::string* out, const Channel& channel) {
                      absl::StrAppend(out, QuotedJson(channel.name));
                    })));
}

// The transfer function of an element, in either of its two forms.
absl::StatusOr<TransferFunction> ParseDynamics(const JsonNode& node) {
  const bool has_gain = node.Has("gain");
  const bool has_time_constant = node.Has("time_constant");
  const bool has_numerator = node.Has("numerator");
  const bool has_denominator = node.Has("denominator");
  const bool first_order =
      has_gain && has_time_constant && !has_numerator && !has_denominator;
  const bool rational =
      has_numerator && has_denominator && !has_gain && !has_time_constant;
  if (!first_order && !rational) {
    Keys found;
    if (has_gain) found.push_back("gain");
    if (has_time_constant) found.push_back("time_constant");
    if (has_numerator) found.push_back("numerator");
    if (has_denominator) found.push_back("denominator");
    return node.Fault(
        absl::StrCat("needs either gain and time_constant or numerator and "
                     "denominator, has ",
                     found.empty() ? std::string("none of them")
                                   : absl::StrJoin(found, ", ")));
  }
  MLE_ASSIGN_OR_RETURN(const double delay, node.At("delay").Number());
  TransferFunction g;
  if (first_order) {
    MLE_ASSIGN_OR_RETURN(const double gain, node.At("gain").Number());
    MLE_ASSIGN_OR_RETURN(const double time_constant,
                         node.At("time_constant").Number(kPositive));
    g = TransferFunction::FirstOrder(gain, time_constant, delay);
  } else {
    MLE_ASSIGN_OR_RETURN(std::vector<double> numerator,
                         node.At("numerator").Numbers());
    MLE_ASSIGN_OR_RETURN(std::vector<double> denominator,
                         node.At("denominator").Numbers());
    g = TransferFunction(std::move(numerator), std::move(denominator), delay);
  }
  if (const absl::Status status = g.Validate(); !status.ok()) {
    return node.Fault(std::string(status.message()));
  }
  return g;
}

absl::Status ParseElements(const JsonNode& top, ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("elements").ElementsOrNone());
  std::set<std::pair<int, int>> seen;
  for (const JsonNode& node : nodes) {
    MLE_RETURN_IF_ERROR(
        node.CheckKeys({"output", "input", "delay"},
                       {"gain", "time_constant", "numerator", "denominator"}));
    MLE_ASSIGN_OR_RETURN(const int output,
                         FindChannel(node, "output", model.outputs()));
    MLE_ASSIGN_OR_RETURN(const int input,
                         FindChannel(node, "input", model.inputs()));
    if (!seen.insert({output, input}).second) {
      return node.Fault(absl::StrCat(
          "the element of output ", QuotedJson(model.outputs()[output].name),
          ", input ", QuotedJson(model.inputs()[input].name),
          " stands twice; each pair may stand once"));
    }
    MLE_ASSIGN_OR_RETURN(model.element(output, input), ParseDynamics(node));
  }
  return absl::OkStatus();
}

absl::StatusOr<ProcessModel> ParseModel(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "inputs", "outputs", "elements"}, {}));
  MLE_ASSIGN_OR_RETURN(std::string name, top.At("name").String());
  MLE_ASSIGN_OR_RETURN(std::string time_unit, top.At("time_unit").String());
  std::vector<InputChannel> inputs;
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> input_nodes,
                       top.At("inputs").ElementsOrNone());
  for (const JsonNode& node : input_nodes) {
    MLE_ASSIGN_OR_RETURN(InputChannel input, ParseInput(node));
    inputs.push_back(std::move(input));
  }
  std::vector<OutputChannel> outputs;
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> output_nodes,
                       top.At("outputs").ElementsOrNone());
  for (const JsonNode& node : output_nodes) {
    MLE_ASSIGN_OR_RETURN(OutputChannel output, ParseOutput(node));
    outputs.push_back(std::move(output));
  }
  if (!inputs.empty() && outputs.size() > kMaxPairs / inputs.size()) {
    return top.Fault(absl::StrCat(inputs.size(), " inputs and ", outputs.size(),
                                  " outputs make more than ", kMaxPairs,
                                  " pairs"));
  }
  ProcessModel model(std::move(name), std::move(time_unit), std::move(inputs),
                     std::move(outputs));
  if (const absl::Status names = model.Validate(); !names.ok()) {
    return top.Fault(std::string(names.message()));
  }
  MLE_RETURN_IF_ERROR(ParseElements(top, model));
  return model;
}

// The shortest decimal that reads back as `value`; −0, which JSON takes for a
// whole number, as 0.
std::string Shortest(double value) {
  if (value == 0.0) return "0";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return std::string(buffer, end);
}

std::string FormatList(const std::vector<double>& values) {
  return absl::StrCat("[",
                      absl::StrJoin(values, ", ",
                                    [](std::string* out, double value) {
                                      absl::StrAppend(out, Shortest(value));
                                    }),
                      "]");
}

std::string FormatDynamics(const TransferFunction& g) {
  std::string text;
  // Other first-order elements would not come back to the last bit.
  if (g.IsFirstOrder() && g.denominator()[1] == 1.0) {
    text = absl::StrCat("\"gain\": ", Shortest(g.StaticGain()),
                        ", \"time_constant\": ", Shortest(g.TimeConstant()));
  } else {
    text = absl::StrCat("\"numerator\": ", FormatList(g.numerator()),
                        ", \"denominator\": ", FormatList(g.denominator()));
  }
  return absl::StrCat(text, ", \"delay\": ", Shortest(g.delay()));
}

std::string FormatObjects(const std::vector<std::string>& objects) {
  if (objects.empty()) return "[]";
  return absl::StrCat("[\n    {", absl::StrJoin(objects, "},\n    {"),
                      "}\n  ]");
}

}  // namespace

absl::StatusOr<ProcessModel> ParseProcessModel(std::string_view json,
                                               std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const Json top, ParseStrictJson(json, source));
  return ParseModel(JsonNode(top, std::string(source)));
}

std::string FormatProcessModel(const ProcessModel& model) {
  std::vector<std::string> inputs;
  for (const InputChannel& input : model.inputs()) {
    inputs.push_back(absl::StrCat("\"name\": ", QuotedJson(input.name),
                                  ", \"unit\": ", QuotedJson(input.unit),
                                  input.role == InputRole::kDisturbance
                                      ? ", \"role\": \"disturbance\""
                                      : ""));
  }
  std::vector<std::string> outputs;
  for (const OutputChannel& output : model.outputs()) {
    outputs.push_back(absl::StrCat("\"name\": ", QuotedJson(output.name),
                                   ", \"unit\": ", QuotedJson(output.unit)));
  }
  std::vector<std::string> elements;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& g = model.element(i, j);
      if (g.IsZero()) continue;
      elements.push_back(absl::StrCat(
          "\"output\": ", QuotedJson(model.outputs()[i].name), ", \"input\": ",
          QuotedJson(model.inputs()[j].name), ", ", FormatDynamics(g)));
    }
  }
  return absl::StrCat("{\n  \"name\": ", QuotedJson(model.name()),
                      ",\n  \"time_unit\": ", QuotedJson(model.time_unit()),
                      ",\n  \"inputs\": ", FormatObjects(inputs),
                      ",\n  \"outputs\": ", FormatObjects(outputs),
                      ",\n  \"elements\": ", FormatObjects(elements), "\n}\n");
}

absl::StatusOr<ProcessModel> ReadProcessModel(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseProcessModel(text, path);
}

absl::Status WriteProcessModel(const ProcessModel& model,
                               const std::string& path) {
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return absl::Status(status.code(),
                        absl::StrCat("process model to be written to '", path,
                                     "': ", status.message()));
  }
  return WriteFileAtomically(path, FormatProcessModel(model));
}

}  // namespace mle
