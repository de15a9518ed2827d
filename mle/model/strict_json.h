// Strict parsing of JSON files.
//
// A key may stand only once in an object, a number must be representable as a
// double, nesting is limited to 64 levels. Errors name `source` (a file), line
// and column, or for a repeated key its place, as in elements[2].
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_STRICT_JSON_H_
#define MLE_MODEL_STRICT_JSON_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"

namespace mle {

absl::StatusOr<nlohmann::json> ParseStrictJson(std::string_view text,
                                               std::string_view source);

}  // namespace mle

#endif  // MLE_MODEL_STRICT_JSON_H_
