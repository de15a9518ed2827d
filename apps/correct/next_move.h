// The next move of mle_correct --plan: the least costly change of set points
// after which what these records leave open is known (mle/plan/plan.h).

#ifndef APPS_CORRECT_NEXT_MOVE_H_
#define APPS_CORRECT_NEXT_MOVE_H_

#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "mle/model/process_model.h"
#include "mle/plan/plan.h"

namespace mle::correct {

struct NextMoveOptions {
  bool wanted = false;
  double error = 0.1;  // standard error > 0 of each gain, relative
  // In the model's time unit, > 0; nothing: ten settling times.
  std::optional<double> longest;
  double quiet = 0.0;                   // between moves, ≥ 0
  std::vector<std::string> set_points;  // that may move; empty: all
  // p or m; empty: the width of the range in usual operation beyond it.
  Eigen::VectorXd min_output;
  Eigen::VectorXd max_output;
  Eigen::VectorXd min_input;
  Eigen::VectorXd max_input;
  // p, for an hour; empty: squares in units of usual operation.
  Eigen::VectorXd squared_price;
  Eigen::VectorXd absolute_price;
};

std::vector<Option> OptionsOf(NextMoveOptions& move);

// InvalidArgument names the option: set points and prices that the model does
// not have, outputs that no plan can be made for.
absl::Status CheckNextMove(const NextMoveOptions& move,
                           const ProcessModel& model);

struct NextMove {
  // Nothing where no plan can be made, with the reason.
  std::optional<Plan> plan;
  std::string reason;
  PlanOptions options;    // limits as they were kept
  bool priced = false;    // the cost is money
  double usual = 0.0;     // else the time of usual operation that costs as much
  double earliest = 0.0;  // time of the records
  bool at_once = true;
  std::string settling;  // what is still on its way, if anything
  // Sentences on what was assumed.
  std::vector<std::string> assumptions;
};

struct Result;

// For a result that is complete but for the plan. InvalidArgument for limits
// that usual operation does not keep, with the option's name.
absl::StatusOr<NextMove> PlanNextMove(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_NEXT_MOVE_H_
