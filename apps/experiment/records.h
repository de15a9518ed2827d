// The records of one run: what the initial model is converted from, and what
// the closed loop leaves around its set-point changes.

#ifndef APPS_EXPERIMENT_RECORDS_H_
#define APPS_EXPERIMENT_RECORDS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/options.h"
#include "control/mpc.h"
#include "mle/correction/conversion.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "sim/set_point_profile.h"

namespace mle::experiment {

// R for one seed.
absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options);

// The set points of the run in which that of `output` steps (WindowSpec without
// `changes`).
sim::SetPointProfile StepOf(int output, const WindowSpec& windows);

// The plant under `mpc`, for the duration of a run, with options.effects beside
// the conditions. Noise is that of the seed's `stream`, of this variance.
absl::StatusOr<Record> SimulateLoop(control::Mpc mpc, const ProcessModel& plant,
                                    const sim::SetPointProfile& set_points,
                                    double noise_variance, std::uint64_t seed,
                                    std::uint64_t stream,
                                    const sim::PlantConditions& conditions,
                                    const ExperimentOptions& options);

// The records of the closed loop, a window for each set-point change.
absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_RECORDS_H_
