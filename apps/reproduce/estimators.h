// The estimators side by side on the records of one run, held against the
// plant.
//
//   arx         ΔR by the exact engine, λ* by the rule; the model stays as it
//   is
//               unless the records prove that it is wrong (model_adequacy.h)
//   ceres       the same at the same λ*, with smoothed L1 by Ceres
//   structured  gains, time scales and dead times (structured_correction.h)
//   combined    structured, then ΔR where that is not enough (combined.h)
//
// and the Cramér–Rao limit: the E that no unbiased estimate from these records
// can beat on average if it knows the structure and the noise.

#ifndef APPS_REPRODUCE_ESTIMATORS_H_
#define APPS_REPRODUCE_ESTIMATORS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "apps/report/table.h"
#include "mle/correction/correction.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "nlohmann/json_fwd.hpp"

namespace mle::reproduce {

struct ExperimentOptions;

struct EstimatorResult {
  std::string name;
  absl::Status status;  // why there is no result
  double E = 0.0;
  // Whether the records proved a change. If not, the model stays as it is, and
  // E is that of the initial model.
  bool change_proposed = false;
  double p_value = 1.0;  // of the initial model being right
  // Of processor time, tests included; the conversion of the initial model,
  // which all of a seed's cases share, is not.
  double seconds = 0.0;
  std::string report;  // in a line
};

struct EstimatorComparison {
  std::vector<EstimatorResult> estimators;  // as asked for, in their order
  double E_limit = 0.0;                     // 0 where there is none
};

// All names, in the order of the tables.
const std::vector<std::string>& EstimatorNames();

// What is wanted of `options.estimators`; `ceres` only `in_full`. `correction`
// is that of the run, `correction_seconds` what it took. What one estimator
// cannot do stands in its result, and is no error of the comparison.
EstimatorComparison CompareEstimators(const ProcessModel& initial,
                                      const ProcessModel& plant,
                                      const std::vector<Record>& windows,
                                      const Correction& correction,
                                      double correction_seconds,
                                      std::uint64_t seed, bool in_full,
                                      const ExperimentOptions& options);

// Seconds of processor time of this thread.
double ThreadSeconds();

// Over the runs of a case: a row for each estimator and one for the limit.
report::Table EstimatorTable(
    const std::string& case_name,
    const std::vector<const EstimatorComparison*>& comparisons);

// The value of "estimators" of one run in results.json (docs/formats.md).
nlohmann::ordered_json EstimatorsJson(const EstimatorComparison& comparison);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_ESTIMATORS_H_
