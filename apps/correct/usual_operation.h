// What outputs and inputs do in usual operation: in the windows and in the
// records between them, but for parts in which the plant is shut down or run
// far from its operating point (mle/maintain/steady_records.h). Ranges are
// those of all of it, squares those of parts in which nothing is asked of the
// plant.

#ifndef APPS_CORRECT_USUAL_OPERATION_H_
#define APPS_CORRECT_USUAL_OPERATION_H_

#include <vector>

#include "Eigen/Core"
#include "apps/correct/result.h"
#include "mle/base/double_limits.h"

namespace mle::correct {

// Sums over the samples of a channel.
struct ChannelUse {
  double low = kInfinity;
  double high = -kInfinity;
  double last = 0.0;  // of all records
  bool known = false;
  double squares = 0.0;  // about the set point, or the mean of its part
  double count = 0.0;

  void AddToRange(double value);
  double deviation() const;
};

// p outputs, then m inputs, then the set points where there are any.
struct Operation {
  std::vector<ChannelUse> outputs;
  std::vector<ChannelUse> inputs;
  std::vector<ChannelUse> set_points;
};

Operation OperationIn(const Result& result);

// Of each channel.
Eigen::VectorXd Deviations(const std::vector<ChannelUse>& uses);

}  // namespace mle::correct

#endif  // APPS_CORRECT_USUAL_OPERATION_H_
