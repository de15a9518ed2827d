#include "mle/exchange/transform_line.h"

#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/model/json_node.h"
#include "mle/model/transform_json.h"
#include "nlohmann/json.hpp"

namespace mle {

absl::StatusOr<Transform> ReadTransformLine(const ModelTable& table,
                                            const TableLine& line) {
  const std::vector<std::string>& fields = line.fields;
  if (fields.size() < 3) {
    return table.Fault(line.line,
                       "a transform has a channel, a kind, and keys with their "
                       "numbers, as transform,steam,log,at,4.2");
  }
  nlohmann::json json = {{"kind", fields[2]}};
  nlohmann::json points;
  const auto number = [&](std::size_t column) -> absl::StatusOr<double> {
    if (column >= fields.size()) {
      return table.Fault(line.line,
                         absl::StrCat("'", ShowCsvText(fields.back()),
                                      "' is the last field, and lacks a "
                                      "number"));
    }
    return table.Number(line, static_cast<int>(column));
  };
  for (std::size_t column = 3; column < fields.size();) {
    const std::string& key = fields[column];
    MLE_ASSIGN_OR_RETURN(const double value, number(column + 1));
    if (key == "point") {
      MLE_ASSIGN_OR_RETURN(const double transformed, number(column + 2));
      points.push_back({value, transformed});
      column += 3;
      continue;
    }
    if (key == "points" || !json.emplace(key, value).second) {
      return table.Fault(
          line, static_cast<int>(column),
          key == "points" ? "a point is point,x,f" : "the key is given twice");
    }
    column += 2;
  }
  if (!points.is_null()) json["points"] = std::move(points);
  return ParseTransform(
      JsonNode(json, absl::StrCat(table.source, ": line ", line.line,
                                  ": transform of ", ShowCsvText(fields[1]))));
}

std::string FormatTransformLine(const std::string& channel,
                                const Transform& transform) {
  if (transform.IsNone()) return "";
  const auto json = nlohmann::ordered_json::parse(FormatTransform(transform));
  std::string text = absl::StrCat("transform,", QuoteCsvField(channel));
  for (const auto& [key, value] : json.items()) {
    if (key == "kind") {
      absl::StrAppend(&text, ",", value.get<std::string>());
    } else if (key == "points") {
      for (const auto& point : value) {
        absl::StrAppend(&text, ",point,", TableNumber(point[0].get<double>()),
                        ",", TableNumber(point[1].get<double>()));
      }
    } else {
      absl::StrAppend(&text, ",", key, ",", TableNumber(value.get<double>()));
    }
  }
  return text + "\n";
}

}  // namespace mle
