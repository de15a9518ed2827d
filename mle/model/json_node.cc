#include "mle/model/json_node.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kShown = 40;

}  // namespace

std::string QuotedJson(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string FoundJson(const Json& value) {
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    return text.size() <= kShown
               ? absl::StrCat("the string ", QuotedJson(text))
               : absl::StrFormat("a string of %d characters", text.size());
  }
  if (value.is_number()) return absl::StrCat("the number ", value.dump());
  if (value.is_boolean()) return value.dump();
  if (value.is_null()) return "null";
  return absl::StrCat("an ", value.type_name());
}

absl::Status JsonNode::FaultHere(const std::string& message) const {
  return InvalidArgument(source_, path_.empty() ? "" : ": ", path_, ": ",
                         message);
}

absl::Status JsonNode::CheckKeys(
    const std::vector<std::string>& required,
    const std::vector<std::string>& optional) const {
  if (!json_->is_object()) {
    return Fault("must be an object, is ", Found());
  }
  std::vector<std::string> allowed = required;
  allowed.insert(allowed.end(), optional.begin(), optional.end());
  for (const auto& item : json_->items()) {
    if (std::find(allowed.begin(), allowed.end(), item.key()) ==
        allowed.end()) {
      return Fault("unknown key ", QuotedJson(item.key()), "; allowed are ",
                   absl::StrJoin(allowed, ", "));
    }
  }
  for (const std::string& key : required) {
    if (!json_->contains(key)) {
      return Fault("key \"", key, "\" is missing");
    }
  }
  return absl::OkStatus();
}

JsonNode JsonNode::At(const std::string& key) const {
  JsonNode node((*json_).at(key), source_);
  node.path_ = path_.empty() ? key : absl::StrCat(path_, ".", key);
  return node;
}

absl::StatusOr<std::vector<JsonNode>> JsonNode::ElementsOrNone() const {
  if (!json_->is_array()) {
    return Fault("must be a list, is ", Found());
  }
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < json_->size(); ++i) {
    nodes.emplace_back((*json_)[i], source_);
    nodes.back().path_ = absl::StrCat(path_, "[", i, "]");
  }
  return nodes;
}

absl::StatusOr<std::vector<JsonNode>> JsonNode::Elements() const {
  if (json_->is_array() && json_->empty()) {
    return Fault("is an empty list; it must have one element or more");
  }
  return ElementsOrNone();
}

absl::StatusOr<std::vector<double>> JsonNode::Numbers() const {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes, Elements());
  std::vector<double> numbers(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    MLE_ASSIGN_OR_RETURN(numbers[i], nodes[i].Number());
  }
  return numbers;
}

absl::StatusOr<std::vector<std::string>> JsonNode::Strings() const {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes, Elements());
  std::vector<std::string> strings(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    MLE_ASSIGN_OR_RETURN(strings[i], nodes[i].String());
  }
  return strings;
}

absl::StatusOr<std::string> JsonNode::String() const {
  if (json_->is_string()) return json_->get<std::string>();
  return Fault("must be a string, is ", Found());
}

absl::StatusOr<std::string> JsonNode::Text() const {
  if (!json_->is_string() || json_->get_ref<const std::string&>().empty()) {
    return Fault("must be a string that is not empty, is ", Found());
  }
  return json_->get<std::string>();
}

absl::StatusOr<std::string> JsonNode::Name() const {
  MLE_ASSIGN_OR_RETURN(const std::string name, Text());
  const bool plain =
      name.size() <= 100 && name.front() != ' ' && name.back() != ' ' &&
      name.find_first_not_of(
          "abcdefghijklmnopqrstuvwxyz"
          "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 ._-+:") == std::string::npos;
  if (plain) return name;
  return Fault(
      "must be a name of at most 100 letters, digits, blanks and "
      ". _ - + :, is ",
      Found());
}

absl::StatusOr<double> JsonNode::Number(const NumberRange& range) const {
  const double value = json_->is_number()
                           ? json_->get<double>()
                           : std::numeric_limits<double>::quiet_NaN();
  if (range.Contains(value)) return value;
  const std::string bounds = range.Describe();
  return Fault("must be a number", bounds.empty() ? "" : " ", bounds, ", is ",
               Found());
}

absl::StatusOr<std::int64_t> JsonNode::Integer(std::int64_t min,
                                               std::int64_t max) const {
  constexpr double kExact = 9007199254740992.0;  // 2⁵³: all below are exact
  std::optional<std::int64_t> value;
  if (json_->is_number_float()) {
    const auto number = json_->get<double>();
    if (std::abs(number) <= kExact && number == std::floor(number)) {
      value = static_cast<std::int64_t>(number);
    }
  } else if (json_->is_number_unsigned()) {
    const auto number = json_->get<std::uint64_t>();
    if (number <=
        static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      value = static_cast<std::int64_t>(number);
    }
  } else if (json_->is_number_integer()) {
    value = json_->get<std::int64_t>();
  }
  if (value.has_value() && *value >= min && *value <= max) return *value;
  return Fault("must be a whole number from ", min, " to ", max, ", is ",
               Found());
}

absl::StatusOr<bool> JsonNode::Boolean() const {
  if (json_->is_boolean()) return json_->get<bool>();
  return Fault("must be true or false, is ", Found());
}

absl::Status ReadNumber(const JsonNode& object, const std::string& key,
                        const NumberRange& range, double& value) {
  if (!object.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(value, object.At(key).Number(range));
  return absl::OkStatus();
}

absl::Status ReadBoolean(const JsonNode& object, const std::string& key,
                         bool& value) {
  if (!object.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(value, object.At(key).Boolean());
  return absl::OkStatus();
}

}  // namespace mle
