// Parts that JSON files of models share: matrices, and names of channels.
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_JSON_MATRIX_H_
#define MLE_MODEL_JSON_MATRIX_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/json_node.h"

namespace mle {

// A list of `rows` rows of `columns` numbers each, both at least 1; memory is
// taken only once every row is as long as it should be. `row_meaning` and
// `column_meaning` ("one for each output", "order × channels") say in the
// errors what the sizes follow from.
absl::StatusOr<Eigen::MatrixXd> ReadMatrix(const JsonNode& node, int rows,
                                           int columns,
                                           const std::string& row_meaning,
                                           const std::string& column_meaning);

// As many names as there are outputs and inputs, none empty, none twice.
absl::Status CheckChannelNames(const std::vector<std::string>& outputs,
                               int num_outputs,
                               const std::vector<std::string>& inputs,
                               int num_inputs);

}  // namespace mle

#endif  // MLE_MODEL_JSON_MATRIX_H_
