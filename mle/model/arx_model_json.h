// ARX models as JSON files (docs/formats.md, arx.json): the model, the names of
// its channels and its unit of time.
//
//   MLE_ASSIGN_OR_RETURN(const NamedArxModel named,
//                        ReadArxModel("correction/arx.json"));
//   named.model.ComputeStepResponse(/*samples=*/501);

#ifndef MLE_MODEL_ARX_MODEL_JSON_H_
#define MLE_MODEL_ARX_MODEL_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/arx_model.h"

namespace mle {

struct NamedArxModel {
  std::string name;  // of the process
  std::string time_unit;
  std::vector<std::string> outputs;  // p names
  std::vector<std::string> inputs;   // m names
  ArxModel model;

  // A valid model with a name for each channel; names are not empty and
  // distinct over inputs and outputs.
  absl::Status Validate() const;
};

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types, and a matrix that does not fit the channels are errors that name the
// key, what was found and what would be right.
absl::StatusOr<NamedArxModel> ParseArxModel(std::string_view json,
                                            std::string_view source);
// Reads back as the same numbers, bit by bit. The model is valid.
std::string FormatArxModel(const NamedArxModel& named);
absl::StatusOr<NamedArxModel> ReadArxModel(const std::string& path);

}  // namespace mle

#endif  // MLE_MODEL_ARX_MODEL_JSON_H_
