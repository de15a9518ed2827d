// The cost of operation. Prices are in units of money of the user's
// choice; hours are real hours, whatever the model's time unit.

#ifndef APPS_LIFECYCLE_PRICES_H_
#define APPS_LIFECYCLE_PRICES_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/lifecycle/life.h"
#include "apps/lifecycle/sums.h"

namespace mle::lifecycle {

struct Prices {
  Eigen::VectorXd squared_error;   // p, per squared unit of the output and hour
  Eigen::VectorXd absolute_error;  // p, per unit and hour
  Eigen::VectorXd violation;       // p, per unit beyond a limit and hour
  Eigen::VectorXd movement;        // m, per unit that an input moves
  double test_hour = 100.0;        // of a step test, besides its product
  double engineer_hour = 100.0;
  double hours_per_update = 1.0;  // of an engineer: a correction to be approved
  double hours_per_test = 16.0;   // of an engineer, for a step test
};

std::vector<Option> OptionsOf(Prices& prices);

// Parts of a cost.
struct Cost {
  double product = 0.0;  // errors
  double violation = 0.0;
  double movement = 0.0;
  double test_hours = 0.0;  // the tests' hours, at their price
  double engineering = 0.0;

  double total() const {
    return product + violation + movement + test_hours + engineering;
  }
  void Add(const Cost& other);
};

// Hours in a unit of time: of "s", "min", "h", "d" and their full names.
absl::StatusOr<double> HoursPerUnit(const std::string& time_unit);

// Product made during a step test counts with the rest. Corrections that found
// no change cost no engineer.
Cost CostOf(const ChangeRow& row, const Prices& prices, double hours_per_unit);
Cost CostOf(const Life& life, const Prices& prices, double hours_per_unit);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_PRICES_H_
