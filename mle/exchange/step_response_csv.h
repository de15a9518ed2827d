// Step-response models as CSV (docs/formats.md). Internal to mle/exchange.

#ifndef MLE_EXCHANGE_STEP_RESPONSE_CSV_H_
#define MLE_EXCHANGE_STEP_RESPONSE_CSV_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "mle/exchange/model_table.h"
#include "mle/exchange/step_response_model.h"

namespace mle {

// Whether the header is that of step responses.
bool HoldsStepResponses(const ModelTable& table);

// A table whose header is "time" and "<output>/<input>" for each pair. Errors
// name file, line and column.
absl::StatusOr<StepResponseModel> StepResponsesOf(const ModelTable& table);

absl::StatusOr<StepResponseModel> ParseStepResponseCsv(std::string_view csv,
                                                       std::string_view source);

}  // namespace mle

#endif  // MLE_EXCHANGE_STEP_RESPONSE_CSV_H_
