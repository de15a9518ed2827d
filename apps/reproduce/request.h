// The request to mle_reproduce, as its flags give it.

#ifndef APPS_REPRODUCE_REQUEST_H_
#define APPS_REPRODUCE_REQUEST_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/reproduce/reproduction.h"

namespace mle::reproduce {

// The Wood-Berry column's own cases.
inline constexpr char kPaperCases[] = "gain,delay";

struct Request {
  Request();

  // Options as they are given.
  std::string cases = kPaperCases;
  std::string model_path;
  std::string plants;
  int seeds = 1;
  std::uint64_t first_seed = 1;
  double lambda_grid_max = 1e-2;
  double lambda_grid_step = 1e-6;
  std::vector<std::string> estimators = {"arx", "ceres", "output_error",
                                         "combined"};
  std::vector<std::string> ablations;
  std::string folder = "results";
  bool figures = true;

  // Where all others are.
  Reproduction reproduction;
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the process models and checks everything that can be checked before
// something is run; errors name the option or the file.
absl::Status Complete(Request& request, OptionTable& table);

// The initial model and the plants of a reproduction.

// Fills in the campaign's model and mismatches: the user's own, or the paper's.
// Errors name the option, and the file if there is one.
absl::Status ReadCases(Request& request);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_REQUEST_H_
