#include "mle/model/transform_json.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/model/channels_json.h"

namespace mle {
namespace {

// A key and the field that it gives.
struct NumberKey {
  const char* name;
  double Transform::*field;
  bool required = true;
};

struct TransformForm {
  const char* name;
  TransformKind kind;
  std::vector<NumberKey> numbers;  // beside `at`
};

const std::vector<TransformForm>& Forms() {
  static const auto* const forms = new std::vector<TransformForm>{
      {"exponential",
       TransformKind::kExponential,
       {{"curvature", &Transform::curvature}}},
      {"equal_percentage",
       TransformKind::kEqualPercentage,
       {{"rangeability", &Transform::rangeability},
        {"closed", &Transform::low},
        {"open", &Transform::high}}},
      {"quick_opening",
       TransformKind::kQuickOpening,
       {{"closed", &Transform::low}, {"open", &Transform::high}}},
      {"log", TransformKind::kLogarithm, {{"zero", &Transform::zero, false}}},
      {"power",
       TransformKind::kPower,
       {{"exponent", &Transform::exponent}, {"zero", &Transform::zero, false}}},
      {"sinh", TransformKind::kSinh, {{"curvature", &Transform::curvature}}},
      {"tanh", TransformKind::kTanh, {{"curvature", &Transform::curvature}}},
      {"piecewise_linear", TransformKind::kPiecewiseLinear, {}}};
  return *forms;
}

absl::StatusOr<std::vector<std::pair<double, double>>> ParsePoints(
    const JsonNode& node) {
  std::vector<std::pair<double, double>> points;
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes, node.Elements());
  for (const JsonNode& point : nodes) {
    MLE_ASSIGN_OR_RETURN(const std::vector<double> numbers, point.Numbers());
    if (numbers.size() != 2) {
      return point.Fault("has ", numbers.size(),
                         " numbers, a point has two: [value, transformed]");
    }
    points.emplace_back(numbers[0], numbers[1]);
  }
  return points;
}

}  // namespace

absl::StatusOr<Transform> ParseTransform(const JsonNode& node) {
  if (!node.json().is_object() || !node.Has("kind")) {
    return node.Fault(R"(must be an object with kind, as {"kind": "log", )",
                      R"("at": 4.2}, is )", node.Found());
  }
  MLE_ASSIGN_OR_RETURN(const std::string kind, node.At("kind").String());
  const auto form =
      std::find_if(Forms().begin(), Forms().end(),
                   [&](const TransformForm& one) { return kind == one.name; });
  if (form == Forms().end()) {
    return node.At("kind").Fault(
        "is ", QuotedJson(kind), ", must be one of ",
        absl::StrJoin(Forms(), ", ",
                      [](std::string* out, const TransformForm& one) {
                        absl::StrAppend(out, one.name);
                      }));
  }
  std::vector<std::string> required = {"kind", "at"};
  std::vector<std::string> optional;
  for (const NumberKey& key : form->numbers) {
    (key.required ? required : optional).emplace_back(key.name);
  }
  Transform transform;
  transform.kind = form->kind;
  const bool has_points = form->kind == TransformKind::kPiecewiseLinear;
  if (has_points) required.emplace_back("points");
  MLE_RETURN_IF_ERROR(node.CheckKeys(required, optional));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "at", kAnyNumber, transform.at));
  for (const NumberKey& key : form->numbers) {
    MLE_RETURN_IF_ERROR(
        ReadNumber(node, key.name, kAnyNumber, transform.*key.field));
  }
  if (has_points) {
    MLE_ASSIGN_OR_RETURN(transform.points, ParsePoints(node.At("points")));
  }
  MLE_RETURN_IF_ERROR(node.Check(transform.Validate()));
  return transform;
}

std::string FormatTransform(const Transform& transform) {
  const auto form = std::find_if(
      Forms().begin(), Forms().end(),
      [&](const TransformForm& one) { return transform.kind == one.kind; });
  std::string text = absl::StrCat("{\"kind\": \"", form->name, "\"");
  for (const NumberKey& key : form->numbers) {
    const double value = transform.*key.field;
    if (!key.required && value == 0.0) continue;
    absl::StrAppend(&text, ", \"", key.name, "\": ", ShortestNumber(value));
  }
  if (transform.kind == TransformKind::kPiecewiseLinear) {
    absl::StrAppend(
        &text, ", \"points\": [",
        absl::StrJoin(
            transform.points, ", ",
            [](std::string* out, const auto& point) {
              absl::StrAppend(out, FormatNumbers({point.first, point.second}));
            }),
        "]");
  }
  absl::StrAppend(&text, ", \"at\": ", ShortestNumber(transform.at), "}");
  return text;
}

}  // namespace mle
