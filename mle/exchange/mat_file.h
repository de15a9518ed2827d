// Models as MAT files (version 5), which MATLAB and Octave load with one line
// (docs/formats.md):
//
//   >> load column.mat
//   >> plot(interval * (1:size(step_responses, 1)), step_responses(:, 1, 2))
//
// Written and read with libmatio.

#ifndef MLE_EXCHANGE_MAT_FILE_H_
#define MLE_EXCHANGE_MAT_FILE_H_

#include <string>
#include <string_view>
#include <variant>

#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"

namespace mle {

// Whether a file that begins so is a MAT file.
bool IsMatFile(std::string_view start);

// The bytes of a file; the same model gives the same bytes. Internal where no
// temporary file can be written.
// `response`: its step responses at 0, Δt, …, or null.
absl::StatusOr<std::string> FormatMat(const ProcessModel& model,
                                      const StepResponse* response = nullptr);
absl::StatusOr<std::string> FormatMat(const StepResponseModel& model);

// A model of transfer functions or of step responses, whichever the variables
// are of. Other variables are not read. Errors name file and variable.
using MatModel = std::variant<ProcessModel, StepResponseModel>;
absl::StatusOr<MatModel> ReadMatModel(const std::string& path);

}  // namespace mle

#endif  // MLE_EXCHANGE_MAT_FILE_H_
