// The JSON form of a transform (docs/formats.md): {"kind": "log", "at": 4.2}.
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_TRANSFORM_JSON_H_
#define MLE_MODEL_TRANSFORM_JSON_H_

#include <string>

#include "absl/status/statusor.h"
#include "mle/model/json_node.h"
#include "mle/model/transform.h"

namespace mle {

// Valid, or errors that name the key.
absl::StatusOr<Transform> ParseTransform(const JsonNode& node);

// {"kind": …}; of a transform that is not kNone.
std::string FormatTransform(const Transform& transform);

}  // namespace mle

#endif  // MLE_MODEL_TRANSFORM_JSON_H_
