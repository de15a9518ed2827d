#include "apps/watch/watch_file.h"

#include <cstring>
#include <filesystem>
#include <set>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

constexpr int kVersion = 1;
constexpr int kMostReferenceDays = 366;
constexpr int kMostOverlapDays = 60;
constexpr char kSqlite[] = "sqlite:";

std::string From(const std::filesystem::path& folder, const std::string& path) {
  return (folder / path).lexically_normal().string();
}

absl::Status ReadText(const JsonNode& object, const std::string& key,
                      std::string& text) {
  if (!object.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(text, object.At(key).Text());
  return absl::OkStatus();
}

absl::Status ReadDays(const JsonNode& node, const std::string& key, int least,
                      int most, int& days) {
  if (!node.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::int64_t read,
                       node.At(key).Integer(least, most));
  days = static_cast<int>(read);
  return absl::OkStatus();
}

// Where the records are: a folder, or a database and what of it.
absl::Status ReadRecords(const JsonNode& node,
                         const std::filesystem::path& folder,
                         Controller& controller) {
  MLE_RETURN_IF_ERROR(ReadText(node, "records", controller.records));
  DatabaseOptions& database = controller.database;
  MLE_RETURN_IF_ERROR(ReadText(node, "query", database.query));
  MLE_RETURN_IF_ERROR(ReadText(node, "table", database.table));
  if (node.Has("columns")) {
    MLE_ASSIGN_OR_RETURN(database.columns, node.At("columns").Strings());
  }
  MLE_RETURN_IF_ERROR(ReadText(node, "begin", controller.begin));
  MLE_RETURN_IF_ERROR(ReadDays(node, "overlap_days", 0, kMostOverlapDays,
                               controller.overlap_days));
  if (!IsDatabase(controller.records)) {
    if (node.Has("overlap_days")) {
      return node.At("overlap_days")
          .Fault("it is for databases; files that have changed are read again");
    }
    controller.records = From(folder, controller.records);
  } else if (const std::string& name = controller.records;
             name.starts_with(kSqlite) && !name.starts_with("sqlite://")) {
    controller.records =
        absl::StrCat(kSqlite, From(folder, name.substr(std::strlen(kSqlite))));
  }
  const absl::Status status =
      RecordSources({controller.records}, database, HistorianOptions())
          .status();
  if (!status.ok()) return node.Fault(std::string(status.message()));
  if (!database.query.empty() &&
      database.query.find(kBeginPlace) == std::string::npos) {
    return node.At("query").Fault(absl::StrCat(
        "it must have ", kBeginPlace, " in it, as in WHERE time >= '",
        kBeginPlace, "': a run reads what is new, not the whole table"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Controller> ParseController(
    const JsonNode& node, const std::filesystem::path& folder) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"name", "model", "records"},
                     {"query", "table", "columns", "begin", "overlap_days",
                      "tag_file", "time_zone", "sample_time", "reference_days",
                      "level", "least_change", "model_error"}));
  Controller controller;
  MLE_ASSIGN_OR_RETURN(controller.name, node.At("name").Name());
  MLE_RETURN_IF_ERROR(ReadText(node, "model", controller.model));
  MLE_RETURN_IF_ERROR(ReadRecords(node, folder, controller));
  MLE_RETURN_IF_ERROR(ReadText(node, "tag_file", controller.tag_file));
  MLE_RETURN_IF_ERROR(ReadText(node, "time_zone", controller.time_zone));
  controller.model = From(folder, controller.model);
  if (!controller.tag_file.empty()) {
    controller.tag_file = From(folder, controller.tag_file);
  }
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "sample_time", kPositive, controller.sample_time));
  MLE_RETURN_IF_ERROR(ReadDays(node, "reference_days", 2, kMostReferenceDays,
                               controller.reference_days));
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
