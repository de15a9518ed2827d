#include "mle/model/json_matrix.h"

#include <set>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle {
namespace {

absl::Status CheckNames(const std::vector<std::string>& names, int wanted,
                        const char* kind, std::set<std::string>& seen) {
  if (static_cast<int>(names.size()) != wanted) {
    return InvalidArgument(names.size(), " names for ", wanted, " ", kind, "s");
  }
  for (const std::string& name : names) {
    if (name.empty()) {
      return InvalidArgument("an ", kind, " has an empty name");
    }
    if (!seen.insert(name).second) {
      return InvalidArgument("the name ", QuotedJson(name),
                             " is duplicated; each channel needs its own");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Eigen::MatrixXd> ReadMatrix(const JsonNode& node, int rows,
                                           int columns,
                                           const std::string& row_meaning,
                                           const std::string& column_meaning) {
  const nlohmann::json& list = node.json();
  if (!list.is_array() || list.size() != static_cast<std::size_t>(rows)) {
    return node.Fault(
        "must be a list of ", rows, " rows, ", row_meaning, ", is ",
        list.is_array() ? absl::StrCat("one of ", list.size()) : node.Found());
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> row_nodes, node.Elements());
  for (const JsonNode& row : row_nodes) {
    if (!row.json().is_array() ||
        row.json().size() != static_cast<std::size_t>(columns)) {
      return row.Fault(
          "must be a list of ", columns, " numbers, ", column_meaning, ", is ",
          row.json().is_array() ? absl::StrCat("one of ", row.json().size())
                                : row.Found());
    }
  }
  Eigen::MatrixXd matrix(rows, columns);
  for (int i = 0; i < rows; ++i) {
    MLE_ASSIGN_OR_RETURN(const std::vector<double> row, row_nodes[i].Numbers());
    matrix.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), columns);
  }
  return matrix;
}

absl::Status CheckChannelNames(const std::vector<std::string>& outputs,
                               int num_outputs,
                               const std::vector<std::string>& inputs,
                               int num_inputs) {
  std::set<std::string> seen;
  MLE_RETURN_IF_ERROR(CheckNames(outputs, num_outputs, "output", seen));
  return CheckNames(inputs, num_inputs, "input", seen);
}

}  // namespace mle
