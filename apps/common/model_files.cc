#include "apps/common/model_files.h"

#include <iostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/exchange/model_file.h"

namespace mle {

absl::Status AboutOption(const std::string& option,
                         const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", option, ": ", status.message()));
}

absl::StatusOr<ProcessModel> ReadModel(const std::string& option,
                                       const std::string& path) {
  absl::StatusOr<ModelFile> file = ReadModelFile(path);
  if (!file.ok()) return AboutOption(option, file.status());
  for (const std::string& difference : NotableDifferences(*file)) {
    std::cerr << "warning: --" << option << ": " << difference << "\n";
  }
  return std::move(file->process);
}

absl::StatusOr<ProcessModel> ReadModelLike(const ProcessModel& model,
                                           const std::string& model_path,
                                           const std::string& option,
                                           const std::string& path) {
  MLE_ASSIGN_OR_RETURN(ProcessModel other, ReadModel(option, path));
  const absl::Status same = CheckSameChannels(model, model_path, other, path);
  if (!same.ok()) return AboutOption(option, same);
  return other;
}

absl::Status CheckMoves(const ProcessModel& model, const std::string& path,
                        const std::string& nothing) {
  if (SettlingTime(model) > 0.0 || IsIntegrating(model)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "--model: ", path,
      " has no element with a time constant or a dead time: there is ",
      nothing));
}

}  // namespace mle
