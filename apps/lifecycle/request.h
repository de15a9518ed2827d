// The request to mle_lifecycle: the lives to simulate, and the prices.

#ifndef APPS_LIFECYCLE_REQUEST_H_
#define APPS_LIFECYCLE_REQUEST_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/common/option_values.h"
#include "apps/lifecycle/campaign.h"
#include "control/operating_cost.h"

namespace mle::lifecycle {

// Models in memory, and the text of a schedule of ageing (JSON).
struct GivenModels {
  ProcessModel model;
  std::optional<ProcessModel> plant;
  std::string ageing;
};

struct Request {
  // Options that are not fields of the campaign. Times are in the model's unit
  // unless they are called hours; 0 stands for what follows from the model.
  std::string model_path;
  std::string plant_path;
  std::string ageing_path;
  std::vector<double> rates = {1.0};
  double years = 5.0;
  double change_every_hours = 720.0;
  double window_age_hours = std::numeric_limits<double>::infinity();
  double disturbance_hours = 24.0;
  int seeds = 5;
  std::uint64_t first_seed = 1;
  bool figures = true;
  int threads = 0;
  bool calibrate_test = false;
  double window = 0.0;
  double quiet_stretch = 0.0;
  double warm_up = 0.0;
  double response_horizon = 0.0;
  double test_hold = 0.0;

  // In place of what the paths name.
  std::optional<GivenModels> given;

  // Where all others are.
  Campaign campaign;
  control::Prices prices;
  std::string currency;
  double hours_per_unit = 1.0;  // of the model's time unit
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the files and checks everything that can be checked before something is
// simulated; errors name the option or the file.
absl::Status Complete(Request& request, OptionTable& table);

// Lengths of time with their unit, as flags have them: "30d", "12h", "0.5y".

inline constexpr double kHoursPerYear = 8766.0;  // 365.25 days

// In hours; units are s, min, h, d, w and y. InvalidArgument unless it is a
// number > 0 with one of them.
absl::StatusOr<double> ParseHours(const std::string& text);

// An option that is a length of time, put into `hours`.
TextValue Hours(double* hours, std::string text);
}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_REQUEST_H_
