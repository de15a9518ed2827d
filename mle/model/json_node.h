// Typed access to a JSON file that a person wrote: every fault names the place
// in the file, what stands there and what would be right.
//
//   MLE_RETURN_IF_ERROR(CheckJsonKeys(node, {"name", "unit"}, {"role"}));
//   MLE_ASSIGN_OR_RETURN(input.name, GetJsonString(node, "name"));
//
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_JSON_NODE_H_
#define MLE_MODEL_JSON_NODE_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"

namespace mle {

// An object of the file and where it stands, to be named in messages.
struct JsonNode {
  const nlohmann::json& json;
  std::string place;  // "" at the top, else as in elements[2]
};

// `text` in quotes, as JSON has it.
std::string QuotedJson(const std::string& text);

// What was found, in a few characters.
std::string FoundJson(const nlohmann::json& value);

// InvalidArgument that opens with the place.
absl::Status JsonFault(const JsonNode& node, std::string_view message);

// An object with all of `required` and nothing beyond these and `optional`.
absl::Status CheckJsonKeys(const JsonNode& node,
                           const std::vector<std::string>& required,
                           const std::vector<std::string>& optional);

// The value of a key that is there; a fault where it is of another type, or a
// list is empty.
absl::StatusOr<std::string> GetJsonString(const JsonNode& node,
                                          const std::string& key);
absl::StatusOr<double> GetJsonNumber(const JsonNode& node,
                                     const std::string& key);
// A whole number from `low` to `high`.
absl::StatusOr<int> GetJsonInteger(const JsonNode& node, const std::string& key,
                                   int low, int high);
absl::StatusOr<std::vector<double>> GetJsonNumbers(const JsonNode& node,
                                                   const std::string& key);
absl::StatusOr<std::vector<std::string>> GetJsonStrings(const JsonNode& node,
                                                        const std::string& key);
// The entries of a list; may be empty.
absl::StatusOr<std::vector<JsonNode>> GetJsonObjects(const JsonNode& node,
                                                     const std::string& key);

}  // namespace mle

#endif  // MLE_MODEL_JSON_NODE_H_
