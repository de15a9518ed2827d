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

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"
#include "sim/schedule.h"

namespace mle::sim {

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types, unknown channels and schedules that do not hold for `model` are errors
// that name key and element.
absl::StatusOr<AgeingSchedule> ParseAgeingSchedule(std::string_view json,
                                                   std::string_view source,
                                                   const ProcessModel& model);
absl::StatusOr<AgeingSchedule> ReadAgeingSchedule(const std::string& path,
                                                  const ProcessModel& model);

// The same for the reactor of van_de_vusse.h:
//
//   {"time_factor": 720, "activity": [[0, 1.0], [12, 0.7]], "heat_transfer":
//   0.9}
struct ReactorAgeing {
  Schedule activity = Schedule(1.0);       // > 0
  Schedule heat_transfer = Schedule(1.0);  // > 0
};
absl::StatusOr<ReactorAgeing> ReadReactorAgeing(const std::string& path);

}  // namespace mle::sim

#endif  // SIM_AGEING_JSON_H_
