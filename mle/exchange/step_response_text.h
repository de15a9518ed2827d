// Step-response models as CSV and JSON (docs/formats.md). Internal to
// mle/exchange.

#ifndef MLE_EXCHANGE_STEP_RESPONSE_TEXT_H_
#define MLE_EXCHANGE_STEP_RESPONSE_TEXT_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "mle/exchange/element_table.h"
#include "mle/exchange/model_table.h"
#include "mle/exchange/step_response_model.h"

namespace mle {

// JSON. `source` (a file's name) opens every message; unknown, missing or
// repeated keys, wrong types, unknown channels, duplicated pairs and
// coefficients of unequal numbers are errors that name the key.
absl::StatusOr<StepResponseModel> ParseStepResponseJson(
    std::string_view json, std::string_view source);

// Whether the header is that of step responses.
bool HoldsStepResponses(const ModelTable& table);

// A table whose header is "time" and "<output>/<input>" for each pair. Errors
// name file, line and column.
absl::StatusOr<StepResponseModel> StepResponsesOf(const ModelTable& table);

absl::StatusOr<StepResponseModel> ParseStepResponseCsv(std::string_view csv,
                                                       std::string_view source);

// Whether the first character that is not blank is a brace: JSON, not CSV.
inline bool IsJsonText(std::string_view text) {
  const std::size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return start != std::string_view::npos && text[start] == '{';
}

// Tables of elements, read from tables of any kind. Internal to mle/exchange.

absl::StatusOr<ElementTable> ElementsOf(const ModelTable& table);

}  // namespace mle

#endif  // MLE_EXCHANGE_STEP_RESPONSE_TEXT_H_
