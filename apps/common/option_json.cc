#include "apps/common/option_json.h"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// The largest whole number that every JSON reader keeps exactly.
constexpr double kLargestInteger = 9'007'199'254'740'991.0;
// What options of limits read as no limit.
constexpr char kNoLimit[] = "none";

// A name, or numbers, as on the command line.
absl::StatusOr<std::string> TextOfNode(const JsonNode& node,
                                       const Option& option,
                                       const TextValue& value) {
  if (!value.known.empty()) return node.Text();
  std::vector<JsonNode> numbers = {node};
  if (node.json().is_array()) {
    MLE_ASSIGN_OR_RETURN(numbers, node.Elements());
  }
  std::vector<std::string> texts;
  for (const JsonNode& one : numbers) {
    if (one.json() == kNoLimit) {
      texts.emplace_back(kNoLimit);
      continue;
    }
    MLE_ASSIGN_OR_RETURN(const double number, one.Number(option.range));
    texts.push_back(ReadableNumber(number));
  }
  return absl::StrJoin(texts, ",");
}

absl::Status ReadText(const JsonNode& node, const Option& option,
                      const TextValue& value) {
  MLE_ASSIGN_OR_RETURN(const std::string text, TextOfNode(node, option, value));
  const absl::Status status = value.read(text, option.range);
  if (status.ok()) return status;
  return node.Fault(value.known.empty() ? std::string(status.message())
                                        : absl::StrCat("is ", node.Found(),
                                                       "; ", status.message()));
}

template <typename Integer>
absl::Status ReadWhole(const JsonNode& node, const NumberRange& range,
                       Integer& field) {
  using Limits = std::numeric_limits<Integer>;
  const auto bounded = [](double bound) {
    return static_cast<std::int64_t>(std::clamp(
        bound, static_cast<double>(Limits::min()),
        std::min(static_cast<double>(Limits::max()), kLargestInteger)));
  };
  MLE_ASSIGN_OR_RETURN(const std::int64_t number,
                       node.Integer(bounded(range.min), bounded(range.max)));
  field = static_cast<Integer>(number);
  return absl::OkStatus();
}

absl::Status ReadJsonOption(const JsonNode& node, const Option& option) {
  return std::visit(
      [&](const auto& field) -> absl::Status {
        using Field = std::decay_t<decltype(field)>;
        if constexpr (std::is_same_v<Field, TextValue>) {
          return ReadText(node, option, field);
        } else if constexpr (std::is_same_v<Field, bool*>) {
          MLE_ASSIGN_OR_RETURN(*field, node.Boolean());
        } else if constexpr (std::is_same_v<Field, double*>) {
          MLE_ASSIGN_OR_RETURN(*field, node.Number(option.range));
        } else if constexpr (std::is_same_v<Field, std::string*>) {
          MLE_ASSIGN_OR_RETURN(*field, node.Text());
        } else {
          return ReadWhole(node, option.range, *field);
        }
        return absl::OkStatus();
      },
      option.value);
}

}  // namespace

absl::Status ReadOptions(const JsonNode& object,
                         const std::vector<Option>& options) {
  for (const Option& option : options) {
    if (!object.Has(option.name)) continue;
    MLE_RETURN_IF_ERROR(ReadJsonOption(object.At(option.name), option));
  }
  return absl::OkStatus();
}

absl::Status ReadOptionsOnly(const JsonNode& object,
                             const std::vector<std::string>& required,
                             const std::vector<Option>& options) {
  std::vector<std::string> optional;
  for (const Option& option : options) {
    if (std::count(required.begin(), required.end(), option.name) == 0) {
      optional.push_back(option.name);
    }
  }
  MLE_RETURN_IF_ERROR(object.CheckKeys(required, optional));
  return ReadOptions(object, options);
}

}  // namespace mle
