#include "mle/model/json_node.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace mle {
namespace {

using Json = nlohmann::json;

}  // namespace

std::string QuotedJson(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

absl::Status JsonFault(const JsonNode& node, std::string_view message) {
  return absl::InvalidArgumentError(absl::StrCat(
      node.place, node.place.empty() ? "" : ": ", std::string(message)));
}

std::string FoundJson(const Json& value) {
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    return absl::StrCat("the string ",
                        text.size() <= 40 ? QuotedJson(text) : "it holds");
  }
  if (value.is_number()) return absl::StrCat("the number ", value.dump());
  if (value.is_boolean()) return value.dump();
  return value.type_name();
}

absl::Status CheckJsonKeys(const JsonNode& node,
                           const std::vector<std::string>& required,
                           const std::vector<std::string>& optional) {
  if (!node.json.is_object()) {
    return JsonFault(
        node, absl::StrCat("must be an object, is ", FoundJson(node.json)));
  }
  std::vector<std::string> allowed = required;
  allowed.insert(allowed.end(), optional.begin(), optional.end());
  for (const auto& item : node.json.items()) {
    if (std::find(allowed.begin(), allowed.end(), item.key()) ==
        allowed.end()) {
      return JsonFault(
          node, absl::StrCat("unknown key ", QuotedJson(item.key()),
                             "; allowed are ", absl::StrJoin(allowed, ", ")));
    }
  }
  for (const std::string& key : required) {
    if (!node.json.contains(key)) {
      return JsonFault(node, absl::StrCat("key \"", key, "\" is missing"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> GetJsonString(const JsonNode& node,
                                          const std::string& key) {
  const Json& value = node.json.find(key).value();
  if (!value.is_string()) {
    return JsonFault(
        node, absl::StrCat(key, " must be a string, is ", FoundJson(value)));
  }
  return value.get<std::string>();
}

absl::StatusOr<double> GetJsonNumber(const JsonNode& node,
                                     const std::string& key) {
  const Json& value = node.json.find(key).value();
  if (!value.is_number()) {
    return JsonFault(
        node, absl::StrCat(key, " must be a number, is ", FoundJson(value)));
  }
  return value.get<double>();
}

absl::StatusOr<int> GetJsonInteger(const JsonNode& node, const std::string& key,
                                   int low, int high) {
  const Json& value = node.json.find(key).value();
  // 5.0 is a whole number too; compared as double, nothing can overflow.
  const double number = value.is_number() ? value.get<double>() : 0.5;
  if (!(number >= low && number <= high) || number != std::floor(number)) {
    return JsonFault(
        node, absl::StrCat(key, " must be a whole number from ", low, " to ",
                           high, ", is ", FoundJson(value)));
  }
  return static_cast<int>(number);
}

absl::StatusOr<std::vector<double>> GetJsonNumbers(const JsonNode& node,
                                                   const std::string& key) {
  const Json& value = node.json.find(key).value();
  if (!value.is_array() || value.empty()) {
    return JsonFault(
        node, absl::StrCat(key, " must be a list of numbers, is ",
                           value.is_array() ? "empty" : FoundJson(value)));
  }
  std::vector<double> numbers;
  for (const Json& entry : value) {
    if (!entry.is_number()) {
      return JsonFault(node, absl::StrCat(key, " must hold numbers only, has ",
                                          FoundJson(entry)));
    }
    numbers.push_back(entry.get<double>());
  }
  return numbers;
}

absl::StatusOr<std::vector<std::string>> GetJsonStrings(
    const JsonNode& node, const std::string& key) {
  const Json& value = node.json.find(key).value();
  if (!value.is_array() || value.empty()) {
    return JsonFault(
        node, absl::StrCat(key, " must be a list of strings, is ",
                           value.is_array() ? "empty" : FoundJson(value)));
  }
  std::vector<std::string> strings;
  for (const Json& entry : value) {
    if (!entry.is_string()) {
      return JsonFault(node, absl::StrCat(key, " must hold strings only, has ",
                                          FoundJson(entry)));
    }
    strings.push_back(entry.get<std::string>());
  }
  return strings;
}

absl::StatusOr<std::vector<JsonNode>> GetJsonObjects(const JsonNode& node,
                                                     const std::string& key) {
  const Json& value = node.json.find(key).value();
  if (!value.is_array()) {
    return JsonFault(node, absl::StrCat(key, " must be a list of objects, is ",
                                        FoundJson(value)));
  }
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < value.size(); ++i) {
    nodes.push_back({value[i], absl::StrCat(key, "[", i, "]")});
  }
  return nodes;
}

}  // namespace mle
