// A process model from any of the files that plants have: transfer functions
// (JSON, MAT), elements of first and second order (CSV), or step responses
// (CSV, JSON, MAT), discrete transfer functions and state spaces (JSON), which
// transfer functions describe.
//
//   MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile("column.csv"));
//   use(file.process);                            // what can be estimated with
//   use(FormatCorrected(file, corrected)->text);  // in the form of the file
//
// The content of a file tells its type: JSON begins with a brace, a MAT file
// with its version; CSV is a table.

#ifndef MLE_EXCHANGE_MODEL_FILE_H_
#define MLE_EXCHANGE_MODEL_FILE_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/exchange/description.h"
#include "mle/exchange/discrete_model.h"
#include "mle/exchange/element_table.h"
#include "mle/exchange/step_response_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"

namespace mle {

enum class ModelForm {
  kTransferFunctions,
  kElementTable,
  kStepResponses,
  kDiscreteTransferFunctions,
  kStateSpace
};

// "step_responses", as in result.json.
std::string_view NameOf(ModelForm form);

enum class ModelFileType { kJson, kCsv, kMat };

struct ModelFile {
  ModelForm form = ModelForm::kTransferFunctions;
  ModelFileType type = ModelFileType::kJson;
  // The model itself, or what describes it.
  ProcessModel process;
  ElementTable elements;  // of kElementTable: the file's content
  // For forms that are described: the file's content, in the member of its
  // form; its step responses, which are the content of kStepResponses; and how
  // near `process` is to these.
  DiscreteModel discrete;
  NamedStateSpace state_space;
  StepResponseModel step_responses;
  std::vector<PairDescription> descriptions;
};

// Parses JSON or CSV. `source` (a file's name) opens every message.
absl::StatusOr<ModelFile> ParseModelFile(std::string_view text,
                                         std::string_view source);
absl::StatusOr<ModelFile> ReadModelFile(const std::string& path);

// A sentence for states that are left out, and for each pair described with a
// difference of more than kUnremarkableDifference.
std::vector<std::string> NotableDifferences(const ModelFile& file);

// The ModelFile of step responses, with their description.
absl::StatusOr<ModelFile> OfStepResponses(StepResponseModel model,
                                          std::string_view source);

absl::StatusOr<ModelFile> OfStateSpace(NamedStateSpace named,
                                       std::string_view source);

// The step responses of `file`, which is of kStepResponses, with the correction
// from `file.process` to `corrected` (the same channels).
StepResponseModel CorrectedStepResponses(const ModelFile& file,
                                         const ProcessModel& corrected);

// The state space of `file`, which is of kStateSpace, with that correction: its
// states are kept, and more are added. Errors as of WithChange().
absl::StatusOr<NamedStateSpace> CorrectedStateSpace(
    const ModelFile& file, const ProcessModel& corrected);

// A file in the form of the one that was read.
struct FormattedModel {
  std::string name;  // "model_corrected.csv"
  std::string text;
  // Pairs that the form does not hold exactly.
  std::vector<PairDescription> differences;
};

// "model_corrected.csv"; "" for transfer functions, which have files of their
// own (model.json, model.mat).
std::string CorrectedName(const ModelFile& file);

// The content of `file`, which has a CorrectedName(), with the correction from
// `file.process` to `corrected` (the same channels). Pairs whose elements are
// the same keep their numbers to the last bit; of a state space, whose pairs
// share them, the states are kept, and more are added
// (state_space_correction.h). A table of elements gets, of other shapes, the
// nearest of its own. Internal as FormatMat(), InvalidArgument as WithChange().
absl::StatusOr<FormattedModel> FormatCorrected(const ModelFile& file,
                                               const ProcessModel& corrected);

}  // namespace mle

#endif  // MLE_EXCHANGE_MODEL_FILE_H_
