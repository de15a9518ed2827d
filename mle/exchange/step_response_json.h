// Step-response models as JSON (docs/formats.md). Internal to mle/exchange.

#ifndef MLE_EXCHANGE_STEP_RESPONSE_JSON_H_
#define MLE_EXCHANGE_STEP_RESPONSE_JSON_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "mle/exchange/step_response_model.h"

namespace mle {

// `source` (a file's name) opens every message; unknown, missing or repeated
// keys, wrong types, unknown channels, pairs that stand twice and coefficients
// of unequal numbers are errors that name the key.
absl::StatusOr<StepResponseModel> ParseStepResponseJson(
    std::string_view json, std::string_view source);

}  // namespace mle

#endif  // MLE_EXCHANGE_STEP_RESPONSE_JSON_H_
