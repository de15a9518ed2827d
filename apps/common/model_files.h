// Process models that options name.

#ifndef APPS_COMMON_MODEL_FILES_H_
#define APPS_COMMON_MODEL_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"

namespace mle {

// "--option: message", as an InvalidArgument error.
absl::Status AboutOption(const std::string& option, const absl::Status& status);

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

// A model whose outputs move at all: with a time constant or a dead time. If
// not, the message says that there is `nothing` ("nothing to correct").
absl::Status CheckMoves(const ProcessModel& model, const std::string& path,
                        const std::string& nothing);

}  // namespace mle

#endif  // APPS_COMMON_MODEL_FILES_H_
