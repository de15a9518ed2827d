#include "sim/ageing_json.h"

#include <algorithm>
#include <initializer_list>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::sim {
namespace {

using Json = nlohmann::json;
using Keys = std::vector<std::string>;

absl::Status Fault(const std::string& place, const std::string& message) {
  return absl::InvalidArgumentError(
      absl::StrCat(place, place.empty() ? "" : ": ", message));
}

// An object with all of `required` and nothing beyond these and `optional`.
absl::Status CheckKeys(const Json& json, const std::string& place,
                       const Keys& required, const Keys& optional) {
  if (!json.is_object()) return Fault(place, "must be an object");
  Keys allowed = required;
  allowed.insert(allowed.end(), optional.begin(), optional.end());
  for (const auto& item : json.items()) {
    if (std::find(allowed.begin(), allowed.end(), item.key()) ==
        allowed.end()) {
      return Fault(
          place, absl::StrCat("unknown key \"", item.key(), "\"; allowed are ",
                              absl::StrJoin(allowed, ", ")));
    }
  }
  for (const std::string& key : required) {
    if (!json.contains(key)) {
      return Fault(place, absl::StrCat("key \"", key, "\" is missing"));
    }
  }
  return absl::OkStatus();
}

// The place of a named channel among `channels`.
template <typename Channel>
absl::StatusOr<int> FindChannel(const Json& json, const std::string& place,
                                const char* kind,
                                const std::vector<Channel>& channels) {
  const Json& name = json[kind];
  if (!name.is_string()) {
    return Fault(place, absl::StrCat(kind, " must be a string"));
  }
  const std::string& text = name.get_ref<const std::string&>();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == text) return static_cast<int>(i);
  }
  return Fault(place,
               absl::StrCat("the model has no ", kind, " \"", text, "\""));
}

absl::StatusOr<Schedule> ParseSchedule(const Json& json,
                                       const std::string& place,
                                       double time_factor) {
  if (json.is_number()) return Schedule(json.get<double>());
  const absl::Status wrong =
      Fault(place, "must be a number, or a list of points [time, value]");
  if (!json.is_array()) return wrong;
  std::vector<Schedule::Point> points;
  for (const Json& point : json) {
    if (!point.is_array() || point.size() != 2 || !point[0].is_number() ||
        !point[1].is_number()) {
      return wrong;
    }
    points.push_back(
        {time_factor * point[0].get<double>(), point[1].get<double>()});
  }
  absl::StatusOr<Schedule> schedule = Schedule::Create(std::move(points));
  if (!schedule.ok()) {
    return Fault(place, std::string(schedule.status().message()));
  }
  return schedule;
}

absl::StatusOr<ElementAgeing> ParseElement(const Json& json,
                                           const std::string& place,
                                           const ProcessModel& model,
                                           double time_factor) {
  MLE_RETURN_IF_ERROR(CheckKeys(json, place, {"output", "input"},
                                {"gain", "time_constant", "delay"}));
  ElementAgeing element;
  MLE_ASSIGN_OR_RETURN(element.output,
                       FindChannel(json, place, "output", model.outputs()));
  MLE_ASSIGN_OR_RETURN(element.input,
                       FindChannel(json, place, "input", model.inputs()));
  const std::initializer_list<std::pair<const char*, Schedule*>> schedules = {
      {"gain", &element.gain},
      {"time_constant", &element.time_constant},
      {"delay", &element.delay}};
  for (const auto& [key, schedule] : schedules) {
    if (!json.contains(key)) continue;
    MLE_ASSIGN_OR_RETURN(
        *schedule,
        ParseSchedule(json[key], absl::StrCat(place, ".", key), time_factor));
  }
  return element;
}

absl::StatusOr<AgeingSchedule> ParseAgeing(const Json& json,
                                           const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(CheckKeys(json, "", {"elements"}, {"time_factor"}));
  double time_factor = 1.0;
  if (json.contains("time_factor")) {
    if (json["time_factor"].is_number()) {
      time_factor = json["time_factor"].get<double>();
    }
    if (!json["time_factor"].is_number() || !(time_factor > 0.0)) {
      return Fault("time_factor", "must be a positive number");
    }
  }
  if (!json["elements"].is_array()) {
    return Fault("elements", "must be a list of objects");
  }
  AgeingSchedule ageing;
  for (std::size_t i = 0; i < json["elements"].size(); ++i) {
    MLE_ASSIGN_OR_RETURN(
        ElementAgeing element,
        ParseElement(json["elements"][i], absl::StrCat("elements[", i, "]"),
                     model, time_factor));
    ageing.elements.push_back(std::move(element));
  }
  MLE_RETURN_IF_ERROR(ageing.Validate(model));
  return ageing;
}

}  // namespace

absl::StatusOr<AgeingSchedule> ParseAgeingSchedule(std::string_view json,
                                                   std::string_view source,
                                                   const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const Json parsed, ParseStrictJson(json, source));
  absl::StatusOr<AgeingSchedule> ageing = ParseAgeing(parsed, model);
  if (!ageing.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(std::string(source), ": ", ageing.status().message()));
  }
  return ageing;
}

absl::StatusOr<AgeingSchedule> ReadAgeingSchedule(const std::string& path,
                                                  const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  return ParseAgeingSchedule(json, path, model);
}

}  // namespace mle::sim
