// JSON as it is written here: keys in the order in which they were set, doubles
// with the fewest digits that read back as the same, null for numbers that are
// not finite. Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_JSON_TEXT_H_
#define MLE_MODEL_JSON_TEXT_H_

#include <string>

#include "Eigen/Core"
#include "nlohmann/json.hpp"

namespace mle {

// The text of a file: one blank for each level, a line end at the end. What is
// not UTF-8 becomes U+FFFD.
std::string FormatJson(const nlohmann::ordered_json& json);

// Row by row.
nlohmann::ordered_json MatrixJson(const Eigen::MatrixXd& matrix);

}  // namespace mle

#endif  // MLE_MODEL_JSON_TEXT_H_
