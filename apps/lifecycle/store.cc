#include "apps/lifecycle/store.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/sha256.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "nlohmann/json.hpp"

namespace mle::lifecycle {
namespace {

using Json = nlohmann::ordered_json;

Json StoredJson(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

Json StoredJson(const control::OperationSums& sums) {
  return {{"time", sums.time},
          {"squared_error", StoredJson(sums.squared_error)},
          {"absolute_error", StoredJson(sums.absolute_error)},
          {"violation", StoredJson(sums.violation)},
          {"movement", StoredJson(sums.movement)}};
}

Json StoredJson(const ChangeRow& row) {
  return {{"time", row.event.time},
          {"output", row.event.output},
          {"before", StoredJson(row.event.before)},
          {"after", StoredJson(row.event.after)},
          {"quiet", StoredJson(row.quiet)},
          {"transient", StoredJson(row.transient)},
          {"test", StoredJson(row.test)},
          {"watch", StoredJson(row.watch)},
          {"distance", row.error.distance},
          {"gain_error", row.error.gain},
          {"delay_error", row.error.delay},
          {"index", row.index},
          {"outcome", std::string(NameOf(row.outcome))},
          {"reason", row.reason},
          {"held_out_gain", row.held_out_gain}};
}

Eigen::VectorXd ToVector(const Json& json) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(json.size()));
  for (std::size_t i = 0; i < json.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = json.at(i).get<double>();
  }
  return values;
}

double ToNumber(const Json& json) {
  return json.is_null() ? kNaN : json.get<double>();
}

control::OperationSums ToSums(const Json& json) {
  control::OperationSums sums;
  sums.time = json.at("time").get<double>();
  sums.squared_error = ToVector(json.at("squared_error"));
  sums.absolute_error = ToVector(json.at("absolute_error"));
  sums.violation = ToVector(json.at("violation"));
  sums.movement = ToVector(json.at("movement"));
  return sums;
}

absl::StatusOr<ChangeRow> ToRow(const Json& json) {
  ChangeRow row;
  row.event.time = json.at("time").get<double>();
  row.event.output = json.at("output").get<int>();
  row.event.before = ToVector(json.at("before"));
  row.event.after = ToVector(json.at("after"));
  row.quiet = ToSums(json.at("quiet"));
  row.transient = ToSums(json.at("transient"));
  row.test = ToSums(json.at("test"));
  row.watch = ToSums(json.at("watch"));
  row.error.distance = json.at("distance").get<double>();
  row.error.gain = ToNumber(json.at("gain_error"));
  row.error.delay = ToNumber(json.at("delay_error"));
  row.index = ToNumber(json.at("index"));
  MLE_ASSIGN_OR_RETURN(row.outcome,
                       ParseOutcome(json.at("outcome").get<std::string>()));
  row.reason = json.at("reason").get<std::string>();
  row.held_out_gain = ToNumber(json.at("held_out_gain"));
  return row;
}

}  // namespace

std::string LifeKey::LineStart(const Settings& settings) const {
  std::string text;
  for (const auto& [name, value] : settings) {
    // With their lengths, so that no two settings are the same text.
    absl::StrAppend(&text, name.size(), " ", name, value.size(), " ", value);
  }
  return absl::StrFormat("%s,%.17g,%d,%s,", policy, ageing_rate, seed,
                         Sha256Of(text).substr(0, 16));
}

std::string FormatLife(const std::string& line_start, const Life& life) {
  Json rows = Json::array();
  for (const ChangeRow& row : life.rows) rows.push_back(StoredJson(row));
  const Json json = {{"ended", life.ended}, {"rows", std::move(rows)}};
  return absl::StrCat(
      line_start, json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

absl::StatusOr<Life> ParseLife(std::string_view line) {
  // The only file format here that we write and read ourselves: whatever else
  // is found is said to be damaged, and why.
  try {
    const Json parsed =
        Json::parse(line.substr(std::min(line.find('{'), line.size())));
    Life life;
    life.ended = parsed.at("ended").get<std::string>();
    for (const Json& row : parsed.at("rows")) {
      MLE_ASSIGN_OR_RETURN(ChangeRow read, ToRow(row));
      life.rows.push_back(std::move(read));
    }
    return life;
  } catch (const Json::exception& error) {
    return absl::DataLossError(
        absl::StrCat("is not a stored life of a policy: ", error.what()));
  }
}

}  // namespace mle::lifecycle
