// Discrete state-space models as JSON files (docs/formats.md,
// state_space.json): the model, the names of its channels, its unit of time
// and how near it is to the model that it was made of.
//
//   MLE_ASSIGN_OR_RETURN(const NamedStateSpace named,
//                        ReadStateSpace("correction/state_space.json"));
//   named.system.Simulate(inputs);

#ifndef MLE_MODEL_STATE_SPACE_JSON_H_
#define MLE_MODEL_STATE_SPACE_JSON_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "mle/model/state_space.h"

namespace mle {

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types, and matrices that do not fit order and channels are errors that name
// the key, what was found and what would be right.
absl::StatusOr<NamedStateSpace> ParseStateSpace(std::string_view json,
                                                std::string_view source);
// Reads back as the same numbers, bit by bit. The model is valid.
std::string FormatStateSpace(const NamedStateSpace& named);
absl::StatusOr<NamedStateSpace> ReadStateSpace(const std::string& path);

}  // namespace mle

#endif  // MLE_MODEL_STATE_SPACE_JSON_H_
