#include "apps/lifecycle/store.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "apps/common/sha256.h"
#include "mle/base/double_limits.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::lifecycle {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 2;

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

Json KeyJson(const LifeKey& key, const Settings& settings) {
  return {{"version", kVersion},
          {"policy", key.policy},
          {"ageing_rate", key.ageing_rate},
          {"seed", key.seed},
          {"settings", settings}};
}

constexpr std::string_view kSumKey = "\n \"sha256\": \"";
constexpr std::size_t kSumLength = 64;

// `text` with its checksum in place of the 64 characters there; unchanged
// where it has no place for one.
std::string WithChecksum(std::string text) {
  const std::size_t found = text.rfind(kSumKey);
  if (found == std::string::npos) return text;
  const std::size_t at = found + kSumKey.size();
  text.replace(at, kSumLength, kSumLength, '0');
  return text.replace(at, kSumLength, Sha256Of(text));
}

}  // namespace

std::string LifeKey::FileName() const {
  return absl::StrFormat("%s_rate%.15g_seed%d.json",
                         absl::StrReplaceAll(policy, {{":", "-"}}), ageing_rate,
                         seed);
}

std::string FormatLife(const LifeKey& key, const Settings& settings,
                       const Life& life) {
  Json json = KeyJson(key, settings);
  json["ended"] = life.ended;
  Json rows = Json::array();
  for (const ChangeRow& row : life.rows) rows.push_back(StoredJson(row));
  json["rows"] = std::move(rows);
  json["sha256"] = std::string(kSumLength, '0');
  return WithChecksum(FormatJson(json));
}

absl::StatusOr<std::optional<Life>> ParseLife(const std::string& json,
                                              const std::string& source,
                                              const LifeKey& key,
                                              const Settings& settings) {
  // The only file format here that we write and read ourselves: whatever else
  // is found is said to be damaged, and why.
  try {
    const Json parsed = Json::parse(json);
    const bool is_current =
        parsed.is_object() && parsed.value("version", Json()) == kVersion;
    // Earlier versions wrote none.
    if (parsed.contains("sha256") ? WithChecksum(json) != json
                                  : is_current || !parsed.is_object()) {
      return absl::DataLossError(
          absl::StrCat(source, ": the checksum is not that of the content"));
    }
    if (!is_current) return std::nullopt;
    // Compared as they are written.
    const Json wanted = Json::parse(FormatJson(KeyJson(key, settings)));
    for (const auto& item : wanted.items()) {
      if (parsed.at(item.key()) != item.value()) return std::nullopt;
    }
    Life life;
    life.ended = parsed.at("ended").get<std::string>();
    for (const Json& row : parsed.at("rows")) {
      MLE_ASSIGN_OR_RETURN(ChangeRow read, ToRow(row));
      life.rows.push_back(std::move(read));
    }
    return life;
  } catch (const Json::exception& error) {
    return absl::DataLossError(absl::StrCat(
        source, ": is not a stored life of a policy: ", error.what()));
  }
}

absl::StatusOr<std::optional<Life>> LoadLife(const std::string& folder,
                                             const LifeKey& key,
                                             const Settings& settings) {
  const std::string path = absl::StrCat(folder, "/runs/", key.FileName());
  const absl::StatusOr<std::string> content = ReadFile(path);
  if (content.status().code() == absl::StatusCode::kNotFound) {
    return std::nullopt;
  }
  MLE_RETURN_IF_ERROR(content.status());
  return ParseLife(*content, path, key, settings);
}

absl::Status StoreLife(const std::string& folder, const LifeKey& key,
                       const Settings& settings, const Life& life) {
  return WriteFileAtomically(absl::StrCat(folder, "/runs/", key.FileName()),
                             FormatLife(key, settings, life));
}

}  // namespace mle::lifecycle
