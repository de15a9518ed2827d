// The result of an earlier run, to be compared with.

#ifndef APPS_CORRECT_PREVIOUS_RUN_H_
#define APPS_CORRECT_PREVIOUS_RUN_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// A parameter as it was estimated with all elements free.
struct PreviousEstimate {
  std::string output;
  std::string input;
  std::string name;  // "gain", "time_constant", "delay"
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

struct PreviousRun {
  std::string folder;
  std::string decision;  // as in result.json
  std::string until;     // the end of its last window; empty: no dates
  std::vector<PreviousEstimate> estimates;
};

// Reads `folder`/result.json. InvalidArgument where it is not a result of a
// version known here, or of a model with other channels.
absl::StatusOr<PreviousRun> ReadPreviousRun(const std::string& folder,
                                            const ProcessModel& model);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PREVIOUS_RUN_H_
