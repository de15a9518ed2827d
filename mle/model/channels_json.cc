#include "mle/model/channels_json.h"

#include <charconv>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/model/transform_json.h"

namespace mle {
namespace {

// More pairs than any plant has; a file that asks for more is broken.
constexpr std::size_t kMaxPairs = 250'000;

absl::StatusOr<Sampling> ParseSampling(const JsonNode& node, bool is_output) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {}, is_output ? std::vector<std::string>{"period", "held", "late_by",
                                               "average", "stamp"}
                    : std::vector<std::string>{"late_by", "average", "stamp"}));
  Sampling sampling;
  MLE_RETURN_IF_ERROR(ReadNumber(node, "period", kPositive, sampling.period));
  MLE_RETURN_IF_ERROR(ReadBoolean(node, "held", sampling.held));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "late_by", kAnyNumber, sampling.late_by));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "average", kPositive, sampling.average));
  if (sampling.held && !node.Has("period")) {
    return node.Fault("has held without period: how often it is measured");
  }
  if (node.Has("average") != node.Has("stamp")) {
    return node.Fault(
        "needs average, the time that means are over, and stamp (\"start\" or "
        "\"end\" of it) together");
  }
  if (node.Has("stamp")) {
    MLE_ASSIGN_OR_RETURN(const std::string stamp, node.At("stamp").String());
    if (stamp != "start" && stamp != "end") {
      return node.At("stamp").Fault("is ", QuotedJson(stamp),
                                    ", must be \"start\" or \"end\"");
    }
    sampling.stamped_at_end = stamp == "end";
  }
  return sampling;
}

absl::StatusOr<InputChannel> ParseInput(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"name", "unit"}, {"role", "sampling", "transform"}));
  InputChannel input;
  MLE_ASSIGN_OR_RETURN(input.name, node.At("name").String());
  MLE_ASSIGN_OR_RETURN(input.unit, node.At("unit").String());
  if (node.Has("role")) {
    MLE_ASSIGN_OR_RETURN(const std::string role, node.At("role").String());
    if (role != "manipulated" && role != "disturbance") {
      return node.At("role").Fault(
          "is ", QuotedJson(role),
          ", must be \"manipulated\" or \"disturbance\"");
    }
    if (role == "disturbance") input.role = InputRole::kDisturbance;
  }
  if (node.Has("sampling")) {
    MLE_ASSIGN_OR_RETURN(input.sampling,
                         ParseSampling(node.At("sampling"), false));
  }
  if (node.Has("transform")) {
    MLE_ASSIGN_OR_RETURN(input.transform, ParseTransform(node.At("transform")));
  }
  return input;
}

absl::StatusOr<OutputChannel> ParseOutput(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"name", "unit"}, {"sampling", "transform"}));
  OutputChannel output;
  MLE_ASSIGN_OR_RETURN(output.name, node.At("name").String());
  MLE_ASSIGN_OR_RETURN(output.unit, node.At("unit").String());
  if (node.Has("sampling")) {
    MLE_ASSIGN_OR_RETURN(output.sampling,
                         ParseSampling(node.At("sampling"), true));
  }
  if (node.Has("transform")) {
    MLE_ASSIGN_OR_RETURN(output.transform,
                         ParseTransform(node.At("transform")));
  }
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
  return node.At(key).Fault(
      QuotedJson(name), " is unknown; the ", key, "s are ",
      absl::StrJoin(channels, ", ",
                    [](std::string* out, const Channel& channel) {
                      absl::StrAppend(out, QuotedJson(channel.name));
                    }));
}

// The key and its value, after a comma; empty where nothing is declared.
std::string FormatSampling(const Sampling& sampling) {
  std::vector<std::string> keys;
  const auto add = [&](const char* key, double value) {
    if (value == 0.0) return;
    keys.push_back(absl::StrCat("\"", key, "\": ", ShortestNumber(value)));
  };
  add("period", sampling.period);
  if (sampling.held) keys.emplace_back("\"held\": true");
  add("late_by", sampling.late_by);
  add("average", sampling.average);
  if (sampling.average > 0.0) {
    keys.emplace_back(sampling.stamped_at_end ? "\"stamp\": \"end\""
                                              : "\"stamp\": \"start\"");
  }
  if (keys.empty()) return "";
  return absl::StrCat(", \"sampling\": {", absl::StrJoin(keys, ", "), "}");
}

// The key and its value, after a comma; empty where there is none.
std::string TransformKey(const Transform& transform) {
  if (transform.IsNone()) return "";
  return absl::StrCat(", \"transform\": ", FormatTransform(transform));
}

}  // namespace

absl::StatusOr<ProcessModel> ReadChannels(const JsonNode& top) {
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
    return top.Fault(inputs.size(), " inputs and ", outputs.size(),
                     " outputs make more than ", kMaxPairs, " pairs");
  }
  ProcessModel model(std::move(name), std::move(time_unit), std::move(inputs),
                     std::move(outputs));
  MLE_RETURN_IF_ERROR(top.Check(model.Validate()));
  return model;
}

absl::StatusOr<int> FindOutput(const JsonNode& node,
                               const ProcessModel& channels) {
  return FindChannel(node, "output", channels.outputs());
}

absl::StatusOr<int> FindInput(const JsonNode& node,
                              const ProcessModel& channels) {
  return FindChannel(node, "input", channels.inputs());
}

std::string ShortestNumber(double value) {
  if (value == 0.0) return "0";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return std::string(buffer, end);
}

std::string FormatNumbers(const std::vector<double>& values) {
  return absl::StrCat("[",
                      absl::StrJoin(values, ", ",
                                    [](std::string* out, double value) {
                                      absl::StrAppend(out,
                                                      ShortestNumber(value));
                                    }),
                      "]");
}

std::string FormatJsonObjects(const std::vector<std::string>& objects) {
  if (objects.empty()) return "[]";
  return absl::StrCat("[\n    {", absl::StrJoin(objects, "},\n    {"),
                      "}\n  ]");
}

std::string FormatChannels(const ProcessModel& model) {
  std::vector<std::string> inputs;
  for (const InputChannel& input : model.inputs()) {
    inputs.push_back(absl::StrCat(
        "\"name\": ", QuotedJson(input.name),
        ", \"unit\": ", QuotedJson(input.unit),
        input.role == InputRole::kDisturbance ? ", \"role\": \"disturbance\""
                                              : "",
        FormatSampling(input.sampling), TransformKey(input.transform)));
  }
  std::vector<std::string> outputs;
  for (const OutputChannel& output : model.outputs()) {
    outputs.push_back(absl::StrCat("\"name\": ", QuotedJson(output.name),
                                   ", \"unit\": ", QuotedJson(output.unit),
                                   FormatSampling(output.sampling),
                                   TransformKey(output.transform)));
  }
  return absl::StrCat("  \"name\": ", QuotedJson(model.name()),
                      ",\n  \"time_unit\": ", QuotedJson(model.time_unit()),
                      ",\n  \"inputs\": ", FormatJsonObjects(inputs),
                      ",\n  \"outputs\": ", FormatJsonObjects(outputs));
}

}  // namespace mle
