#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/channels_json.h"
#include "mle/model/json_node.h"
#include "mle/model/process_model.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

using Json = nlohmann::json;
using Keys = std::vector<std::string>;

// K e^{-Ls} / (T s + 1), or of an integrating element K e^{-Ls} / (s (T s +
// 1)), where T may be left out.
absl::StatusOr<TransferFunction> ParseGainForm(const JsonNode& node,
                                               bool integrating, double delay) {
  MLE_ASSIGN_OR_RETURN(const double gain, node.At("gain").Number());
  double time_constant = 0.0;
  if (node.Has("time_constant")) {
    MLE_ASSIGN_OR_RETURN(time_constant,
                         node.At("time_constant")
                             .Number(integrating ? kNotNegative : kPositive));
  }
  return integrating ? TransferFunction::Integrator(gain, time_constant, delay)
                     : TransferFunction::FirstOrder(gain, time_constant, delay);
}

// The transfer function of an element, in either of its two forms.
absl::StatusOr<TransferFunction> ParseDynamics(const JsonNode& node) {
  bool integrating = false;
  if (node.Has("integrating")) {
    MLE_ASSIGN_OR_RETURN(integrating, node.At("integrating").Boolean());
    if (!node.Has("gain")) {
      return node.Fault(
          "has integrating without gain; with numerator and denominator an "
          "integrator is a denominator that ends with 0");
    }
  }
  const bool has_gain = node.Has("gain");
  const bool has_time_constant = node.Has("time_constant");
  const bool has_numerator = node.Has("numerator");
  const bool has_denominator = node.Has("denominator");
  const bool gain_form = has_gain && (has_time_constant || integrating) &&
                         !has_numerator && !has_denominator;
  const bool rational =
      has_numerator && has_denominator && !has_gain && !has_time_constant;
  if (!gain_form && !rational) {
    Keys found;
    if (has_gain) found.push_back("gain");
    if (has_time_constant) found.push_back("time_constant");
    if (has_numerator) found.push_back("numerator");
    if (has_denominator) found.push_back("denominator");
    return node.Fault(
        "needs either gain and time_constant or numerator and "
        "denominator, has ",
        found.empty() ? std::string("none of them")
                      : absl::StrJoin(found, ", "));
  }
  MLE_ASSIGN_OR_RETURN(const double delay, node.At("delay").Number());
  TransferFunction g;
  if (gain_form) {
    MLE_ASSIGN_OR_RETURN(g, ParseGainForm(node, integrating, delay));
  } else {
    MLE_ASSIGN_OR_RETURN(std::vector<double> numerator,
                         node.At("numerator").Numbers());
    MLE_ASSIGN_OR_RETURN(std::vector<double> denominator,
                         node.At("denominator").Numbers());
    g = TransferFunction(std::move(numerator), std::move(denominator), delay);
  }
  MLE_RETURN_IF_ERROR(node.Check(g.Validate()));
  return g;
}

absl::Status ParseElements(const JsonNode& top, ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("elements").ElementsOrNone());
  std::set<std::pair<int, int>> seen;
  for (const JsonNode& node : nodes) {
    MLE_RETURN_IF_ERROR(node.CheckKeys(
        {"output", "input", "delay"},
        {"gain", "time_constant", "integrating", "numerator", "denominator"}));
    MLE_ASSIGN_OR_RETURN(const int output, FindOutput(node, model));
    MLE_ASSIGN_OR_RETURN(const int input, FindInput(node, model));
    if (!seen.insert({output, input}).second) {
      return node.Fault("the element of output ",
                        QuotedJson(model.outputs()[output].name), ", input ",
                        QuotedJson(model.inputs()[input].name),
                        " is duplicated; give each pair once");
    }
    MLE_ASSIGN_OR_RETURN(model.element(output, input), ParseDynamics(node));
  }
  return absl::OkStatus();
}

absl::StatusOr<ProcessModel> ParseModel(const JsonNode& top) {
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "inputs", "outputs", "elements"}, {}));
  MLE_ASSIGN_OR_RETURN(ProcessModel model, ReadChannels(top));
  MLE_RETURN_IF_ERROR(ParseElements(top, model));
  return model;
}

std::string FormatDynamics(const TransferFunction& g) {
  std::string text;
  // Other elements of these forms would not come back to the last bit.
  const bool integrator = g.IsIntegratorWithLag();
  if ((g.IsFirstOrder() || integrator) &&
      g.denominator()[g.denominator().size() - (integrator ? 2 : 1)] == 1.0) {
    text =
        absl::StrCat("\"gain\": ", ShortestNumber(g.StaticGain()),
                     ", \"time_constant\": ", ShortestNumber(g.TimeConstant()),
                     integrator ? ", \"integrating\": true" : "");
  } else {
    text = absl::StrCat("\"numerator\": ", FormatNumbers(g.numerator()),
                        ", \"denominator\": ", FormatNumbers(g.denominator()));
  }
  return absl::StrCat(text, ", \"delay\": ", ShortestNumber(g.delay()));
}

}  // namespace

absl::StatusOr<ProcessModel> ParseProcessModel(std::string_view json,
                                               std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const Json top, ParseStrictJson(json, source));
  return ParseModel(JsonNode(top, std::string(source)));
}

std::string FormatProcessModel(const ProcessModel& model) {
  std::vector<std::string> elements;
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& g = model.element(i, j);
    if (g.IsZero()) continue;
    elements.push_back(absl::StrCat(
        "\"output\": ", QuotedJson(model.outputs()[i].name), ", \"input\": ",
        QuotedJson(model.inputs()[j].name), ", ", FormatDynamics(g)));
  }
  return absl::StrCat("{\n", FormatChannels(model),
                      ",\n  \"elements\": ", FormatJsonObjects(elements),
                      "\n}\n");
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
