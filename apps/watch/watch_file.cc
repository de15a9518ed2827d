#include "apps/watch/watch_file.h"

#include <cstring>
#include <filesystem>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "apps/common/option_json.h"
#include "apps/common/shared_options.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
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
constexpr int kMostDaysBetweenUpdates = 36'500;
constexpr double kMostOperatingHours = 8784.0;  // of a leap year
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

// Whoever writes the list would otherwise have any library of the machine
// loaded by the runs: drivers and sources are those of odbcinst.ini and
// odbc.ini.
bool HasOdbcPath(const std::string& records) {
  const absl::string_view place = records;
  if (!absl::StartsWithIgnoreCase(place, "odbc:")) return false;
  for (const absl::string_view part :
       absl::StrSplit(place, absl::ByAnyChar(":;"))) {
    const absl::string_view key =
        absl::StripAsciiWhitespace(part.substr(0, part.find('=')));
    const bool names_code = absl::EqualsIgnoreCase(key, "driver") ||
                            absl::EqualsIgnoreCase(key, "filedsn");
    if (names_code && absl::StrContains(part, '/')) return true;
  }
  return false;
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
  if (HasOdbcPath(controller.records)) {
    return node.At("records").Fault(
        "a driver or source of ODBC is named as in odbcinst.ini or odbc.ini, "
        "not by a path");
  }
  MLE_RETURN_IF_ERROR(node.Check(
      RecordSources({controller.records}, database, HistorianOptions())
          .status()));
  if (!database.query.empty() &&
      database.query.find(kBeginPlace) == std::string::npos) {
    return node.At("query").Fault(
        "it must have ", kBeginPlace, " in it, as in WHERE time >= '",
        kBeginPlace, "': a run reads what is new, not the whole table");
  }
  return absl::OkStatus();
}

absl::Status ReadPrices(const JsonNode& node, Valuation& valuation) {
  std::vector<Option> options =
      Only(OptionsOf(valuation.prices),
           {"price_squared_error", "price_absolute_error", "price_violation",
            "price_movement", "price_engineer_hour", "hours_per_update"});
  options.insert(
      options.end(),
      {{"allowed_error", ForEachOutput(&valuation.allowed_error, ""), "", "",
        kNotNegative},
       {"currency", &valuation.currency, ""},
       {"days_between_updates", &valuation.days_between_updates, "", "",
        Between(1, kMostDaysBetweenUpdates)},
       {"operating_hours",
        &valuation.operating_hours,
        "",
        "",
        {.min = 0.0, .max = kMostOperatingHours, .open_min = true}}});
  MLE_RETURN_IF_ERROR(ReadOptionsOnly(node, {"price_engineer_hour"}, options));
  if (node.Has("currency")) {
    MLE_RETURN_IF_ERROR(
        node.At("currency").Check(CheckCurrency(valuation.currency)));
  }
  control::Prices& prices = valuation.prices;
  // Without this price nothing is a violation, and the reverse.
  if (node.Has("price_violation") != node.Has("allowed_error")) {
    return node.Fault(
        "price_violation and allowed_error belong together: the price of a "
        "unit for an hour, and the error beyond which it is due");
  }
  // A price that is not given is 0.
  for (Eigen::VectorXd* price : {&prices.squared_error, &prices.absolute_error,
                                 &prices.violation, &prices.movement}) {
    if (price->size() == 0) *price = Eigen::VectorXd::Zero(1);
  }
  if (prices.squared_error.isZero(0.0) && prices.absolute_error.isZero(0.0) &&
      prices.violation.isZero(0.0)) {
    return node.Fault(
        "no error of an output has a price; price_squared_error, "
        "price_absolute_error or price_violation must be > 0");
  }
  return absl::OkStatus();
}

absl::Status ReadTuning(const JsonNode& node, control::MpcOptions& tuning) {
  MLE_RETURN_IF_ERROR(
      ReadOptionsOnly(node,
                      {"control_period", "prediction_horizon",
                       "control_horizon", "output_weight", "move_weight"},
                      OptionsOf(tuning)));
  if (tuning.control_horizon <= tuning.prediction_horizon) {
    return absl::OkStatus();
  }
  return node.At("control_horizon")
      .Fault("is ", tuning.control_horizon,
             "; it must be at most prediction_horizon, ",
             tuning.prediction_horizon);
}

// The options of a plan by the names that they have in the list.
absl::Status ReadPlan(const JsonNode& node, correct::NextMoveOptions& plan) {
  std::vector<Option> options =
      Only(correct::OptionsOf(plan),
           {"plan_error", "plan_longest", "plan_quiet", "plan_min_output",
            "plan_max_output", "plan_min_input", "plan_max_input"});
  std::vector<std::string> keys = {"set_points"};
  for (Option& option : options) {
    option.name.erase(0, std::strlen("plan_"));
    keys.push_back(option.name);
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys({}, keys));
  if (node.Has("set_points")) {
    MLE_ASSIGN_OR_RETURN(plan.set_points, node.At("set_points").Strings());
  }
  plan.wanted = true;
  return ReadOptions(node, options);
}

absl::Status FitValues(const std::string& key, int channels,
                       Eigen::VectorXd& values) {
  absl::StatusOr<Eigen::VectorXd> fit = FitToChannels(values, channels);
  if (!fit.ok()) return WithPrefix(fit.status(), absl::StrCat(key, ": "));
  values = *std::move(fit);
  return absl::OkStatus();
}

absl::Status FitDiagonal(const std::string& key, int channels,
                         Eigen::MatrixXd& matrix) {
  Eigen::VectorXd values = matrix.diagonal();
  MLE_RETURN_IF_ERROR(FitValues(key, channels, values));
  matrix = values.asDiagonal();
  return absl::OkStatus();
}

absl::StatusOr<Controller> ParseController(
    const JsonNode& node, const std::string& list,
    const std::filesystem::path& folder) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"name", "model", "records"},
      {"query", "table", "columns", "begin", "overlap_days", "tag_file",
       "time_zone", "sample_time", "reference_days", "level", "least_change",
       "model_error", "prices", "tuning", "plan"}));
  Controller controller;
  controller.list = list;
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
  MLE_RETURN_IF_ERROR(node.Check(options.Validate()));
  if (node.Has("prices")) {
    MLE_RETURN_IF_ERROR(
        ReadPrices(node.At("prices"), controller.valuation.emplace()));
  }
  if (node.Has("tuning")) {
    MLE_RETURN_IF_ERROR(
        ReadTuning(node.At("tuning"), controller.tuning.emplace()));
  }
  if (node.Has("plan")) {
    MLE_RETURN_IF_ERROR(ReadPlan(node.At("plan"), controller.plan.emplace()));
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
    MLE_ASSIGN_OR_RETURN(Controller controller,
                         ParseController(node, path, folder));
    if (!names.insert(controller.name).second) {
      return node.Fault("the name ", QuotedJson(controller.name),
                        " is duplicated; names must differ");
    }
    controllers.push_back(std::move(controller));
  }
  return controllers;
}

absl::StatusOr<std::vector<Controller>> ReadWatchFile(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  return ParseWatchFile(json, path);
}

absl::Status FitToModel(const ProcessModel& model, Controller& controller) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  const auto fit = [&]() -> absl::Status {
    if (controller.valuation.has_value()) {
      control::Prices& prices = controller.valuation->prices;
      MLE_RETURN_IF_ERROR(
          FitValues("prices.price_squared_error", p, prices.squared_error));
      MLE_RETURN_IF_ERROR(
          FitValues("prices.price_absolute_error", p, prices.absolute_error));
      MLE_RETURN_IF_ERROR(
          FitValues("prices.price_violation", p, prices.violation));
      MLE_RETURN_IF_ERROR(FitValues("prices.allowed_error", p,
                                    controller.valuation->allowed_error));
      MLE_RETURN_IF_ERROR(
          FitValues("prices.price_movement", m, prices.movement));
    }
    if (controller.plan.has_value()) {
      correct::NextMoveOptions& plan = *controller.plan;
      MLE_RETURN_IF_ERROR(FitValues("plan.min_output", p, plan.min_output));
      MLE_RETURN_IF_ERROR(FitValues("plan.max_output", p, plan.max_output));
      MLE_RETURN_IF_ERROR(FitValues("plan.min_input", m, plan.min_input));
      MLE_RETURN_IF_ERROR(FitValues("plan.max_input", m, plan.max_input));
      MLE_RETURN_IF_ERROR(
          WithPrefix(correct::CheckNextMove(plan, model), "plan: "));
    }
    if (!controller.tuning.has_value()) return absl::OkStatus();
    control::MpcOptions& tuning = *controller.tuning;
    MLE_RETURN_IF_ERROR(
        FitDiagonal("tuning.output_weight", p, tuning.output_weight));
    MLE_RETURN_IF_ERROR(
        FitDiagonal("tuning.move_weight", m, tuning.move_weight));
    return WithPrefix(tuning.Validate(p, m), "tuning: ");
  };
  return WithPrefix(fit(), absl::StrCat(controller.list, ": controller ",
                                        QuotedJson(controller.name), ": "));
}

}  // namespace mle::watch
