// Effects of real plants and historians, channel by channel, as JSON files
// (docs/formats.md).
//
//   {
//     "outputs": [
//       {"name": "overhead",
//        "arma": {"poles": [0.95, [0.8, 0.3]], "zeros": [0.5], "variance":
//        1e-4}, "sines": [{"amplitude": 0.1, "period": 20}], "steps": [[100,
//        0.2]], "sensor": {"lag": 1.5, "max": 2.0, "dead_from": 300},
//        "set_point": {"ramps": [[100, 60, 1.0]],
//                      "optimiser": {"interval": 5, "deviation": 0.05}},
//        "archive": {"exception": 0.01, "compression": 0.02,
//                    "clock_offset": 0.6, "spikes": [[120, 5.0]]}}
//     ],
//     "inputs": [
//       {"name": "reflux",
//        "load": {"variance": 1e-2, "time_constant": 40,
//                 "steps": [[200, 0.1]], "answered": 0.5},
//        "manual": [[300, 400, 0.1]],
//        "actuator": {"stiction": 0.05, "jump": 0.02, "rangeability": 30,
//                     "span": 2.0, "position": 0.5, "rate": 0.1}}
//     ]
//   }

#ifndef SIM_EFFECTS_JSON_H_
#define SIM_EFFECTS_JSON_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/actuator.h"
#include "sim/archive.h"
#include "sim/input_load.h"
#include "sim/output_disturbance.h"
#include "sim/plant_conditions.h"
#include "sim/sensor.h"
#include "sim/set_point_profile.h"

namespace mle {
class JsonNode;
}

namespace mle::sim {

struct OptimiserOptions {
  int output = 0;
  double interval = 0.0;   // > 0
  double deviation = 0.0;  // ≥ 0
};

struct Effects {
  std::vector<ArmaDisturbance> arma;
  std::vector<SineDisturbance> sines;
  std::vector<OutputStep> steps;
  std::vector<InputLoad> loads;
  std::vector<ManualPeriod> manual;
  std::vector<ActuatorOptions> actuators;
  std::vector<SensorOptions> sensors;
  ArchiveOptions archive;
  std::vector<SetPointMove> ramps;
  std::vector<OptimiserOptions> optimisers;

  // Adds those of the plant and its instruments to `conditions`.
  void AddTo(PlantConditions& conditions) const;
  // Adds those of the set points to `profile`; the moves of optimisers end
  // with the run. InvalidArgument for more than 10,000 moves of one output.
  absl::Status AddTo(SetPointProfile& profile, double duration,
                     std::uint64_t seed, std::uint64_t stream) const;
};

// `source` (a file's name) opens every message; unknown or missing keys, wrong
// types, unknown channels and values out of range are errors that name the
// place.
absl::StatusOr<Effects> ParseEffects(std::string_view json,
                                     std::string_view source,
                                     const ProcessModel& model);
// Parses effects that stand inside another file; messages name the place.
absl::StatusOr<Effects> ParseEffects(const JsonNode& node,
                                     const ProcessModel& model);
absl::StatusOr<Effects> ReadEffects(const std::string& path,
                                    const ProcessModel& model);

}  // namespace mle::sim

#endif  // SIM_EFFECTS_JSON_H_
