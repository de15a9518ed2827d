// Ageing schedules as JSON files (docs/formats.md).
//
//   {
//     "time_factor": 43200,
//     "elements": [
//       {"output": "overhead", "input": "reflux",
//        "gain": [[0, 1.0], [24, 0.5]], "delay": [[12, 0.0], [12, 4.0]]}
//     ]
//   }
//
// `gain` and `time_constant` are factors, `delay` is added; each is one number,
// or a list of [time, value]. `falling`, a number, is a factor of the time
// constants while the element's output falls. Times are multiplied by
// `time_factor` (1 if absent), so that a schedule may be written in months of
// 43200 min.

#ifndef SIM_AGEING_JSON_H_
#define SIM_AGEING_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"

namespace mle::sim {

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types, unknown channels and schedules that do not hold for `model` are errors
// that name key and element.
absl::StatusOr<AgeingSchedule> ParseAgeingSchedule(std::string_view json,
                                                   std::string_view source,
                                                   const ProcessModel& model);
absl::StatusOr<AgeingSchedule> ReadAgeingSchedule(const std::string& path,
                                                  const ProcessModel& model);

// The same for a plant with factors of its own (plant_at_rest.h); those that
// the file does not name stay as they are:
//
//   {"time_factor": 720, "activity": [[0, 1.0], [12, 0.7]], "heat_transfer":
//   0.9}
absl::Status ReadAgeingFactors(const std::string& path,
                               const std::vector<AgeingFactor>& factors);

}  // namespace mle::sim

#endif  // SIM_AGEING_JSON_H_
