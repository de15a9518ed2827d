#include "mle/model/json_text.h"

#include <utility>

namespace mle {

std::string FormatJson(const nlohmann::ordered_json& json) {
  return json.dump(1, ' ', false,
                   nlohmann::ordered_json::error_handler_t::replace) +
         "\n";
}

nlohmann::ordered_json MatrixJson(const Eigen::MatrixXd& matrix) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (const double value : matrix.row(i)) row.push_back(value);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace mle
