#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/exchange/discrete_model.h"
#include "mle/model/channels_json.h"
#include "mle/model/json_node.h"
#include "mle/model/state_space.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

constexpr char kInverseZName[] = "z^-1";

absl::StatusOr<DiscreteVariable> ReadVariable(const JsonNode& top) {
  if (!top.Has("variable")) return DiscreteVariable::kZ;
  const JsonNode node = top.At("variable");
  MLE_ASSIGN_OR_RETURN(const std::string name, node.String());
  if (name == "z") return DiscreteVariable::kZ;
  if (name == kInverseZName) return DiscreteVariable::kInverseZ;
  return node.Fault(
      "is ", QuotedJson(name),
      ", must be \"z\" (coefficients in falling powers of z) or \"z^-1\" (in "
      "rising powers of z^-1)");
}

absl::Status ReadElement(const JsonNode& node, DiscreteModel& model) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"output", "input", "numerator", "denominator"}, {"delay"}));
  DiscreteElement element;
  MLE_ASSIGN_OR_RETURN(element.output, FindOutput(node, model.channels));
  MLE_ASSIGN_OR_RETURN(element.input, FindInput(node, model.channels));
  const std::string name =
      PairName(model.channels, element.output, element.input);
  for (const DiscreteElement& other : model.elements) {
    if (other.output != element.output || other.input != element.input) {
      continue;
    }
    return node.Fault("the pair ", name, " is duplicated; give each pair once");
  }
  MLE_ASSIGN_OR_RETURN(element.numerator, node.At("numerator").Numbers());
  MLE_ASSIGN_OR_RETURN(element.denominator, node.At("denominator").Numbers());
  if (node.Has("delay")) {
    MLE_ASSIGN_OR_RETURN(const std::int64_t delay,
                         node.At("delay").Integer(0, kMaxStateSpaceDelay));
    element.delay = static_cast<int>(delay);
  }
  if (model.variable == DiscreteVariable::kZ &&
      element.numerator.size() > element.denominator.size()) {
    return node.Fault(
        "the numerator has ", element.numerator.size(),
        " coefficients, the denominator ", element.denominator.size(),
        "; in powers of z the numerator's degree must not be the larger "
        "(\"variable\": \"z^-1\" is for powers of z^-1)");
  }
  model.elements.push_back(std::move(element));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DiscreteModel> ParseDiscreteModel(std::string_view json,
                                                 std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json parsed,
                       ParseStrictJson(json, source));
  const JsonNode top(parsed, std::string(source));
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "sample_time", "inputs", "outputs", "elements"},
      {"variable"}));
  DiscreteModel model;
  MLE_ASSIGN_OR_RETURN(model.channels, ReadChannels(top));
  MLE_ASSIGN_OR_RETURN(model.sample_time,
                       top.At("sample_time").Number(kPositive));
  MLE_ASSIGN_OR_RETURN(model.variable, ReadVariable(top));
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("elements").Elements());
  for (const JsonNode& node : nodes) {
    MLE_RETURN_IF_ERROR(ReadElement(node, model));
  }
  MLE_RETURN_IF_ERROR(top.Check(model.Validate()));
  return model;
}

std::string FormatDiscreteModel(const DiscreteModel& model) {
  std::vector<std::string> elements;
  for (const DiscreteElement& element : model.elements) {
    elements.push_back(
        absl::StrCat("\"output\": ",
                     QuotedJson(model.channels.outputs()[element.output].name),
                     ", \"input\": ",
                     QuotedJson(model.channels.inputs()[element.input].name),
                     ", \"numerator\": ", FormatNumbers(element.numerator),
                     ", \"denominator\": ", FormatNumbers(element.denominator),
                     ", \"delay\": ", element.delay));
  }
  return absl::StrCat(
      "{\n", FormatChannels(model.channels),
      ",\n  \"sample_time\": ", ShortestNumber(model.sample_time),
      model.variable == DiscreteVariable::kInverseZ
          ? absl::StrCat(",\n  \"variable\": \"", kInverseZName, "\"")
          : std::string(),
      ",\n  \"elements\": ", FormatJsonObjects(elements), "\n}\n");
}

}  // namespace mle
