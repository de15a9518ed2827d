// Process models that options name, and step responses that commands write.

#ifndef APPS_COMMON_MODEL_FILES_H_
#define APPS_COMMON_MODEL_FILES_H_

#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"

namespace mle {

// From any file that model_file.h reads. Errors name the option and the file;
// what is described with notable differences is told to standard error.
absl::StatusOr<ProcessModel> ReadModel(const std::string& option,
                                       const std::string& path);

// The same, of a model with the channels of `model`, which came from
// `model_path`.
absl::StatusOr<ProcessModel> ReadModelLike(const ProcessModel& model,
                                           const std::string& model_path,
                                           const std::string& option,
                                           const std::string& path);

// Step responses as CSV: the time, then a column "output/input NAME" for each
// pair of the channels and each curve (samples × pm). What is not finite is an
// empty field.
using NamedResponses = std::vector<std::pair<std::string, Eigen::MatrixXd>>;
std::string FormatStepResponses(const ProcessModel& channels,
                                double sample_time,
                                const NamedResponses& curves);

// A model whose outputs move at all: with a time constant or a dead time. If
// not, the message says that there is `nothing` ("nothing to correct").
absl::Status CheckMoves(const ProcessModel& model, const std::string& path,
                        const std::string& nothing);

}  // namespace mle

#endif  // APPS_COMMON_MODEL_FILES_H_
