// The benefit of a correction in the closed loop: the aged plant under the
// controller with the model before correction, with the corrected one (the ARX
// model R̂ as it is), and with the plant's own. Horizons, weights and observer
// are the experiment's; each set-point change of the experiment is run with
// each model, without noise and with it, noise being the same for all three.

#ifndef APPS_REPRODUCE_CLOSED_LOOP_COMPARISON_H_
#define APPS_REPRODUCE_CLOSED_LOOP_COMPARISON_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/options.h"
#include "apps/report/table.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "nlohmann/json_fwd.hpp"

namespace mle::reproduce {

// How one set-point change went, from the change to the end of its window. All
// outputs count; times in the model's time unit.
struct LoopPerformance {
  // Σ (y − r)² Δt over samples and outputs. With measurement noise, σ² of every
  // sample is part of it.
  double integrated_squared_error = 0.0;
  double input_movement = 0.0;  // Σ |u_k − u_{k−1}| over samples and inputs
  // How far the stepped output goes beyond its set point, over the step; ≥ 0.
  double overshoot = 0.0;
  // From the change until every output stays within 5 % of the step from its
  // set point; infinite where that is not before the end of the window. Without
  // noise only, else 0.
  double settling_time = 0.0;
};

enum class LoopModel { kInitial, kCorrected, kTrue };
inline constexpr std::array<const char*, 3> kLoopModelNames = {
    "initial", "corrected", "true"};

// With one model and one noise variance.
struct LoopRun {
  // Why there is none: a model that cannot predict, or a loop that runs away.
  absl::Status status;
  std::vector<LoopPerformance> changes;  // one for each output
  // The records about each change, for figures; where asked for.
  std::vector<Record> records;
};

struct ClosedLoopComparison {
  // By LoopModel.
  std::array<LoopRun, 3> noise_free;
  std::array<LoopRun, 3> noisy;
};

// Only what makes the comparison itself impossible is an error. `in_full` also
// keeps the records without noise.
absl::StatusOr<ClosedLoopComparison> CompareClosedLoops(
    const ProcessModel& initial, const ArxModel& corrected,
    const ProcessModel& plant, std::uint64_t seed, bool in_full,
    const experiment::ExperimentOptions& options);

// Means over the seeds, a row for each change and model.
report::Table ClosedLoopTable(
    const std::string& case_name, const ProcessModel& plant,
    const std::vector<const ClosedLoopComparison*>& comparisons);

// The value of "closed_loop" in results.json (docs/formats.md).
nlohmann::ordered_json ClosedLoopJson(
    const std::vector<const ClosedLoopComparison*>& comparisons);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_CLOSED_LOOP_COMPARISON_H_
