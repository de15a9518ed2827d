#include "sim/ageing_json.h"

#include <initializer_list>
#include <utility>
#include <vector>

#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::sim {
namespace {

// The place of a named channel among `channels`.
template <typename Channel>
absl::StatusOr<int> FindChannel(const JsonNode& node, const std::string& kind,
                                const std::vector<Channel>& channels) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.At(kind).String());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return static_cast<int>(i);
  }
  return node.Fault("the model has no ", kind, " ", QuotedJson(name));
}

absl::StatusOr<Schedule> ParseSchedule(const JsonNode& node,
                                       double time_factor) {
  const nlohmann::json& json = node.json();
  if (json.is_number()) return Schedule(json.get<double>());
  const absl::Status wrong =
      node.Fault("must be a number, or a list of points [time, value]");
  if (!json.is_array()) return wrong;
  std::vector<Schedule::Point> points;
  for (const nlohmann::json& point : json) {
    if (!point.is_array() || point.size() != 2 || !point[0].is_number() ||
        !point[1].is_number()) {
      return wrong;
    }
    points.push_back(
        {time_factor * point[0].get<double>(), point[1].get<double>()});
  }
  return node.Check(Schedule::Create(std::move(points)));
}

absl::StatusOr<ElementAgeing> ParseElement(const JsonNode& node,
                                           const ProcessModel& model,
                                           double time_factor) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"output", "input"}, {"gain", "time_constant", "delay", "falling"}));
  ElementAgeing element;
  MLE_ASSIGN_OR_RETURN(element.output,
                       FindChannel(node, "output", model.outputs()));
  MLE_ASSIGN_OR_RETURN(element.input,
                       FindChannel(node, "input", model.inputs()));
  const std::initializer_list<std::pair<const char*, Schedule*>> schedules = {
      {"gain", &element.gain},
      {"time_constant", &element.time_constant},
      {"delay", &element.delay}};
  for (const auto& [key, schedule] : schedules) {
    if (!node.Has(key)) continue;
    MLE_ASSIGN_OR_RETURN(*schedule, ParseSchedule(node.At(key), time_factor));
  }
  MLE_RETURN_IF_ERROR(ReadNumber(node, "falling", kPositive, element.falling));
  return element;
}

absl::StatusOr<AgeingSchedule> ParseAgeing(const JsonNode& top,
                                           const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(top.CheckKeys({"elements"}, {"time_factor"}));
  double time_factor = 1.0;
  MLE_RETURN_IF_ERROR(ReadNumber(top, "time_factor", kPositive, time_factor));
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("elements").ElementsOrNone());
  AgeingSchedule ageing;
  for (const JsonNode& node : nodes) {
    MLE_ASSIGN_OR_RETURN(ElementAgeing element,
                         ParseElement(node, model, time_factor));
    ageing.elements.push_back(std::move(element));
  }
  MLE_RETURN_IF_ERROR(top.Check(ageing.Validate(model)));
  return ageing;
}

absl::Status ParseFactors(const JsonNode& top,
                          const std::vector<AgeingFactor>& factors) {
  std::vector<std::string> keys = {"time_factor"};
  for (const AgeingFactor& ageing : factors) keys.push_back(ageing.name);
  MLE_RETURN_IF_ERROR(top.CheckKeys({}, keys));
  double time_factor = 1.0;
  MLE_RETURN_IF_ERROR(ReadNumber(top, "time_factor", kPositive, time_factor));
  for (const AgeingFactor& ageing : factors) {
    if (!top.Has(ageing.name)) continue;
    const JsonNode node = top.At(ageing.name);
    MLE_ASSIGN_OR_RETURN(*ageing.factor, ParseSchedule(node, time_factor));
    if (!(ageing.factor->Min() > 0.0)) {
      return node.Fault("falls to ", ageing.factor->Min(),
                        "; the factor must stay positive");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<AgeingSchedule> ParseAgeingSchedule(std::string_view json,
                                                   std::string_view source,
                                                   const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, source));
  return ParseAgeing(JsonNode(top, std::string(source)), model);
}

absl::StatusOr<AgeingSchedule> ReadAgeingSchedule(const std::string& path,
                                                  const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  return ParseAgeingSchedule(json, path, model);
}

absl::Status ReadAgeingFactors(const std::string& path,
                               const std::vector<AgeingFactor>& factors) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  MLE_ASSIGN_OR_RETURN(const nlohmann::json top, ParseStrictJson(json, path));
  return ParseFactors(JsonNode(top, path), factors);
}

}  // namespace mle::sim
