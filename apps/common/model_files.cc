#include "apps/common/model_files.h"

#include <cmath>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/option_table.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/model_file.h"

namespace mle {

absl::StatusOr<ProcessModel> ReadModel(const std::string& option,
                                       const std::string& path) {
  MLE_ASSIGN_OR_RETURN(ModelFile file,
                       AboutOption(option, ReadModelFile(path)));
  for (const std::string& difference : NotableDifferences(file)) {
    std::cerr << "warning: --" << option << ": " << difference << "\n";
  }
  return std::move(file.process);
}

absl::StatusOr<ProcessModel> ReadModelLike(const ProcessModel& model,
                                           const std::string& model_path,
                                           const std::string& option,
                                           const std::string& path) {
  MLE_ASSIGN_OR_RETURN(ProcessModel other, ReadModel(option, path));
  MLE_RETURN_IF_ERROR(
      AboutOption(option, CheckSameChannels(model, model_path, other, path)));
  return other;
}

std::string FormatStepResponses(const ProcessModel& channels,
                                double sample_time,
                                const NamedResponses& curves) {
  std::string csv = "time";
  for (const auto& [name, values] : curves) {
    for (const OutputChannel& output : channels.outputs()) {
      for (const InputChannel& input : channels.inputs()) {
        absl::StrAppend(&csv, ",",
                        QuoteCsvField(absl::StrCat(output.name, "/", input.name,
                                                   " ", name)));
      }
    }
  }
  csv += '\n';
  for (Eigen::Index k = 0; k < curves.front().second.rows(); ++k) {
    absl::StrAppendFormat(&csv, "%.12g", static_cast<double>(k) * sample_time);
    for (const auto& [name, values] : curves) {
      for (const double value : values.row(k)) {
        csv += ',';
        if (std::isfinite(value)) absl::StrAppendFormat(&csv, "%.12g", value);
      }
    }
    csv += '\n';
  }
  return csv;
}

absl::Status CheckMoves(const ProcessModel& model, const std::string& path,
                        const std::string& nothing) {
  if (SettlingTime(model) > 0.0 || IsIntegrating(model)) {
    return absl::OkStatus();
  }
  return InvalidArgument(
      "--model: ", path,
      " has no element with a time constant or a dead time: there is ",
      nothing);
}

}  // namespace mle
