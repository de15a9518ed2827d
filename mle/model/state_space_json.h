// Discrete state-space models as JSON files (docs/formats.md,
// state_space.json): the model, the names of its channels, its unit of time
// and how near it is to the model that it was made of.
//
//   MLE_ASSIGN_OR_RETURN(const NamedStateSpace named,
//                        ReadStateSpace("correction/state_space.json"));
//   named.system.Simulate(inputs);

#ifndef MLE_MODEL_STATE_SPACE_JSON_H_
#define MLE_MODEL_STATE_SPACE_JSON_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space.h"

namespace mle {

// The errors of each output (p), relative to the largest value of a step
// response: the bound of the error at any frequency, and the largest difference
// of a step response or static gain (balanced_reduction.h). Finite and ≥ 0.
struct StateSpaceAccuracy {
  std::vector<double> error_bounds;
  std::vector<double> largest_differences;
};

struct NamedStateSpace {
  std::string name;  // of the process
  std::string time_unit;
  std::vector<std::string> outputs;  // p names
  std::vector<std::string> inputs;   // m names
  DiscreteStateSpace system;
  std::optional<StateSpaceAccuracy> accuracy;
  std::vector<std::string> output_units;  // p, or empty: not known
  std::vector<std::string> input_units;   // m, or empty
  std::vector<std::string> disturbances;  // names of inputs that are such
  std::optional<DisturbanceForm> disturbance_model;  // of the outputs

  // That were left out when the model was read, as no input reaches them and
  // they are unstable or integrate twice (a disturbance model).
  int unreached_states = 0;

  // A valid model with a name for each channel; names are not empty and
  // distinct over inputs and outputs; an accuracy has p values of each kind,
  // units are one for each channel, disturbances are names of inputs; a
  // disturbance model is valid for p outputs.
  absl::Status Validate() const;

  // The channels as those of a process model, all elements zero.
  ProcessModel Channels() const;
  // Takes names, units, roles and unit of time of `channels`.
  void SetChannels(const ProcessModel& channels);
};

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
