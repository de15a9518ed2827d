// A value of a JSON file written by hand. The node knows its path in the file,
// so that every error names the path, what was found and what would be right:
//
//   campaign.json: seeds.count: must be a whole number from 1 to 1000000, is
//   the string "many"
//
//   const JsonNode top(json, "plant.json");
//   MLE_RETURN_IF_ERROR(top.CheckKeys({"name", "unit"}, {"role"}));
//   MLE_ASSIGN_OR_RETURN(input.name, top.At("name").String());
//
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_JSON_NODE_H_
#define MLE_MODEL_JSON_NODE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "mle/base/number_range.h"
#include "nlohmann/json.hpp"

namespace mle {

// `text` in quotes, as JSON has it.
std::string QuotedJson(const std::string& text);

// A short description of `value` for error messages.
std::string FoundJson(const nlohmann::json& value);

class JsonNode {
 public:
  // The whole of `json`, which must outlive the node; `source` names the file.
  JsonNode(const nlohmann::json& json, std::string source)
      : json_(&json), source_(std::move(source)) {}

  const nlohmann::json& json() const { return *json_; }

  // InvalidArgument: "source: path: message"; the parts of the message come one
  // after the other.
  template <typename... Parts>
  absl::Status Fault(const Parts&... parts) const {
    return FaultHere(absl::StrCat(parts...));
  }
  // The same of an error that was found in what the node holds; a good status
  // or value stays as it is.
  absl::Status Check(const absl::Status& status) const {
    return status.ok() ? status : Fault(status.message());
  }
  template <typename Value>
  absl::StatusOr<Value> Check(absl::StatusOr<Value> value) const {
    if (value.ok()) return value;
    return Fault(value.status().message());
  }

  // An object with all of `required` and nothing beyond these and `optional`.
  absl::Status CheckKeys(const std::vector<std::string>& required,
                         const std::vector<std::string>& optional) const;
  bool Has(const std::string& key) const { return json_->contains(key); }
  JsonNode At(const std::string& key) const;  // which is there

  // The elements of a list; of a list that is not empty.
  absl::StatusOr<std::vector<JsonNode>> ElementsOrNone() const;
  absl::StatusOr<std::vector<JsonNode>> Elements() const;
  absl::StatusOr<std::vector<double>> Numbers() const;       // not empty
  absl::StatusOr<std::vector<std::string>> Strings() const;  // not empty

  absl::StatusOr<std::string> String() const;
  absl::StatusOr<std::string> Text() const;  // a string that is not empty
  // For names that go into tables and files: letters, digits, blanks and
  // . _ - + : at most 100, no blank at either end.
  absl::StatusOr<std::string> Name() const;
  absl::StatusOr<double> Number(const NumberRange& range = kAnyNumber) const;
  // 5.0 is a whole number too.
  absl::StatusOr<std::int64_t> Integer(std::int64_t min,
                                       std::int64_t max) const;
  absl::StatusOr<bool> Boolean() const;

  // A short description of this value for error messages.
  std::string Found() const { return FoundJson(*json_); }

 private:
  absl::Status FaultHere(const std::string& message) const;

  const nlohmann::json* json_;
  std::string source_;
  std::string path_;
};

// Fields of an object that keep their default where the key is absent.
absl::Status ReadNumber(const JsonNode& object, const std::string& key,
                        const NumberRange& range, double& value);
absl::Status ReadBoolean(const JsonNode& object, const std::string& key,
                         bool& value);

}  // namespace mle

#endif  // MLE_MODEL_JSON_NODE_H_
