// Parts that the JSON files of models share: name, unit of time, inputs and
// outputs; numbers and lists as text.
// Internal to the project: it shows the JSON library's type.

#ifndef MLE_MODEL_CHANNELS_JSON_H_
#define MLE_MODEL_CHANNELS_JSON_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/json_node.h"
#include "mle/model/process_model.h"

namespace mle {

// A model of zero elements with the name, time_unit, inputs and outputs of
// `top`, which are there. Errors name key and channel.
absl::StatusOr<ProcessModel> ReadChannels(const JsonNode& top);

// The index of the channel that the key "output" or "input" of `node` names.
absl::StatusOr<int> FindOutput(const JsonNode& node,
                               const ProcessModel& channels);
absl::StatusOr<int> FindInput(const JsonNode& node,
                              const ProcessModel& channels);

// The shortest decimal that reads back as `value`; −0, which JSON takes for a
// whole number, as 0.
std::string ShortestNumber(double value);

// "[1, 2.5]", and a list of objects, each on a line.
std::string FormatNumbers(const std::vector<double>& values);
std::string FormatJsonObjects(const std::vector<std::string>& objects);

// The four keys of ReadChannels(), two blanks before each.
std::string FormatChannels(const ProcessModel& model);

}  // namespace mle

#endif  // MLE_MODEL_CHANNELS_JSON_H_
