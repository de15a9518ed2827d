// The experiment with one decision taken differently, to show what each is
// worth (docs/method.md).

#ifndef APPS_REPRODUCE_ABLATIONS_H_
#define APPS_REPRODUCE_ABLATIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "apps/report/table.h"
#include "apps/reproduce/experiment.h"
#include "mle/model/process_model.h"
#include "nlohmann/json_fwd.hpp"

namespace mle::reproduce {

// One decision, by its name.
struct Ablation {
  const char* name;
  const char* what;  // in a few words
  void (*apply)(ExperimentOptions& options);
};

absl::Span<const Ablation> Ablations();

// Null if there is none of that name.
const Ablation* FindAblation(const std::string& name);

// What came of it, for each seed.
struct AblationRun {
  absl::Status status;  // why there is no result
  double lambda_star = 0.0;
  double E = 0.0;
  double max_relative_gap = 0.0;  // of every lasso fit
};

struct AblationResult {
  const Ablation* ablation = nullptr;
  std::vector<AblationRun> runs;  // seed by seed
};

// What a run cannot do stands in its result, and is no error.
AblationRun RunAblation(const Ablation& ablation, const ProcessModel& initial,
                        const ProcessModel& plant, std::uint64_t seed,
                        const ExperimentOptions& experiment);

// Beside the same seeds as the method has it, E_method in their order.
report::Table AblationTable(const std::string& case_name,
                            const std::vector<double>& E_method,
                            const std::vector<AblationResult>& results);

// The value of "ablations" of a case in results.json (docs/formats.md).
nlohmann::ordered_json AblationsJson(
    const std::vector<AblationResult>& results);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_ABLATIONS_H_
