#include "apps/watch/watch_file.h"

#include <filesystem>
#include <set>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

constexpr int kVersion = 1;
constexpr int kMostReferenceDays = 366;

std::string From(const std::filesystem::path& folder, const std::string& path) {
  return (folder / path).lexically_normal().string();
}

absl::Status ReadText(const JsonNode& object, const std::string& key,
                      std::string& text) {
  if (!object.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(text, object.At(key).Text());
  return absl::OkStatus();
}

absl::StatusOr<Controller> ParseController(
    const JsonNode& node, const std::filesystem::path& folder) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"name", "model", "records"},
                     {"tag_file", "time_zone", "sample_time", "reference_days",
                      "level", "least_change", "model_error"}));
  Controller controller;
  MLE_ASSIGN_OR_RETURN(controller.name, node.At("name").Name());
  MLE_RETURN_IF_ERROR(ReadText(node, "model", controller.model));
  MLE_RETURN_IF_ERROR(ReadText(node, "records", controller.records));
  MLE_RETURN_IF_ERROR(ReadText(node, "tag_file", controller.tag_file));
  MLE_RETURN_IF_ERROR(ReadText(node, "time_zone", controller.time_zone));
  controller.model = From(folder, controller.model);
  controller.records = From(folder, controller.records);
  if (!controller.tag_file.empty()) {
    controller.tag_file = From(folder, controller.tag_file);
  }
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "sample_time", kPositive, controller.sample_time));
  if (node.Has("reference_days")) {
    MLE_ASSIGN_OR_RETURN(
        const std::int64_t days,
        node.At("reference_days").Integer(2, kMostReferenceDays));
    controller.reference_days = static_cast<int>(days);
  }
  WatchOptions& options = controller.options;
  MLE_RETURN_IF_ERROR(ReadNumber(node, "level", kAnyNumber, options.level));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "least_change", kAnyNumber, options.least_change));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "model_error", kAnyNumber, options.model_error));
  if (const absl::Status status = options.Validate(); !status.ok()) {
    return node.Fault(std::string(status.message()));
  }
  return controller;
}

}  // namespace

absl::StatusOr<std::vector<Controller>> ParseWatchFile(
    std::string_view json, const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json parsed,
                       ParseStrictJson(json, path));
  const JsonNode top(parsed, path);
  MLE_RETURN_IF_ERROR(top.CheckKeys({"version", "controllers"}, {}));
  MLE_RETURN_IF_ERROR(top.At("version").Integer(kVersion, kVersion).status());
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("controllers").Elements());
  const std::filesystem::path folder =
      std::filesystem::path(path).parent_path();
  std::vector<Controller> controllers;
  std::set<std::string> names;
  for (const JsonNode& node : nodes) {
    MLE_ASSIGN_OR_RETURN(Controller controller, ParseController(node, folder));
    if (!names.insert(controller.name).second) {
      return node.Fault(absl::StrCat("the name ", QuotedJson(controller.name),
                                     " stands twice; names must differ"));
    }
    controllers.push_back(std::move(controller));
  }
  return controllers;
}

absl::StatusOr<std::vector<Controller>> ReadWatchFile(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  return ParseWatchFile(json, path);
}

}  // namespace mle::watch
