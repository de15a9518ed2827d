#include "mle/exchange/step_response_json.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/model/channels_json.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

absl::StatusOr<bool> ReadIsRamp(const JsonNode& node) {
  if (!node.Has("end")) return false;
  MLE_ASSIGN_OR_RETURN(const std::string end, node.At("end").String());
  if (end == "steady" || end == "ramp") return end == "ramp";
  return node.At("end").Fault(
      absl::StrCat("is ", QuotedJson(end), ", must be \"steady\" or \"ramp\""));
}

// One entry of step_responses; the first says how many coefficients there are.
absl::Status ReadPair(const JsonNode& node, StepResponseModel& model) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"output", "input", "coefficients"}, {"end"}));
  PairResponse pair;
  MLE_ASSIGN_OR_RETURN(pair.output, FindOutput(node, model.channels));
  MLE_ASSIGN_OR_RETURN(pair.input, FindInput(node, model.channels));
  for (const PairResponse& other : model.pairs) {
    if (other.output != pair.output || other.input != pair.input) continue;
    return node.Fault(absl::StrCat(
        "the pair ", PairName(model.channels, pair.output, pair.input),
        " stands twice; each pair may stand once"));
  }
  MLE_ASSIGN_OR_RETURN(pair.is_ramp, ReadIsRamp(node));
  MLE_ASSIGN_OR_RETURN(const std::vector<double> numbers,
                       node.At("coefficients").Numbers());
  const auto length = static_cast<int>(numbers.size());
  if (!model.pairs.empty() && length != model.length()) {
    return node.At("coefficients")
        .Fault(absl::StrCat("has ", length,
                            " coefficients, the first pair has ",
                            model.length(), "; all must have as many"));
  }
  pair.coefficients = Eigen::Map<const Eigen::VectorXd>(numbers.data(), length);
  model.pairs.push_back(std::move(pair));
  return absl::OkStatus();
}

absl::Status CheckSteadyState(const JsonNode& top,
                              const StepResponseModel& model) {
  if (!top.Has("time_to_steady_state")) return absl::OkStatus();
  const JsonNode node = top.At("time_to_steady_state");
  MLE_ASSIGN_OR_RETURN(const double stated, node.Number(kPositive));
  const absl::Status status = model.CheckSteadyState(stated);
  return status.ok() ? status : node.Fault(std::string(status.message()));
}

}  // namespace

absl::StatusOr<StepResponseModel> ParseStepResponseJson(
    std::string_view json, std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json parsed,
                       ParseStrictJson(json, source));
  const JsonNode top(parsed, std::string(source));
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "inputs", "outputs", "interval", "step_responses"},
      {"time_to_steady_state"}));
  StepResponseModel model;
  MLE_ASSIGN_OR_RETURN(model.channels, ReadChannels(top));
  MLE_ASSIGN_OR_RETURN(model.interval, top.At("interval").Number(kPositive));
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("step_responses").Elements());
  for (const JsonNode& node : nodes) {
    MLE_RETURN_IF_ERROR(ReadPair(node, model));
  }
  MLE_RETURN_IF_ERROR(CheckSteadyState(top, model));
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return top.Fault(std::string(status.message()));
  }
  return model;
}

std::string FormatStepResponseJson(const StepResponseModel& model) {
  std::vector<std::string> pairs;
  for (const PairResponse& pair : model.pairs) {
    pairs.push_back(absl::StrCat(
        "\"output\": ", QuotedJson(model.channels.outputs()[pair.output].name),
        ", \"input\": ", QuotedJson(model.channels.inputs()[pair.input].name),
        pair.is_ramp ? ", \"end\": \"ramp\"" : "", ",\n     \"coefficients\": ",
        FormatNumbers({pair.coefficients.begin(), pair.coefficients.end()})));
  }
  return absl::StrCat("{\n", FormatChannels(model.channels),
                      ",\n  \"interval\": ", ShortestNumber(model.interval),
                      ",\n  \"time_to_steady_state\": ",
                      ShortestNumber(model.time_to_steady_state()),
                      ",\n  \"step_responses\": ", FormatJsonObjects(pairs),
                      "\n}\n");
}

}  // namespace mle
