#include "mle/model/response_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "glog/logging.h"
#include "mle/model/largest_gain.h"

namespace mle {
namespace {

// The largest over the inputs of measure(δ, K − G) / s.
template <typename Measure>
Eigen::VectorXd LargestOf(const ResponsesOfModel& found,
                          const ResponsesOfModel& wanted,
                          const Measure& measure) {
  const StepResponse& psi = wanted.response;
  CHECK_EQ(found.response.values.rows(), psi.values.rows());
  CHECK_EQ(found.response.values.cols(), psi.values.cols());
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(psi.num_outputs);
  for (int i = 0; i < psi.num_outputs; ++i) {
    for (int j = 0; j < psi.num_inputs; ++j) {
      const double gain = wanted.gains(i, j);
      const double size =
          std::max(psi.element(i, j).cwiseAbs().maxCoeff(), std::abs(gain));
      if (!(size > 0.0)) continue;
      const double value =
          measure((found.response.element(i, j) - psi.element(i, j)).eval(),
                  found.gains(i, j) - gain);
      largest(i) = std::isfinite(value)
                       ? std::max(largest(i), value / size)
                       : std::numeric_limits<double>::infinity();
    }
  }
  return largest;
}

}  // namespace

Eigen::VectorXd RelativeDifferences(const ResponsesOfModel& found,
                                    const ResponsesOfModel& wanted) {
  return LargestOf(
      found, wanted, [](const Eigen::VectorXd& difference, double of_gains) {
        return std::max(difference.cwiseAbs().maxCoeff(), std::abs(of_gains));
      });
}

Eigen::VectorXd LargestGainsOfDifference(const ResponsesOfModel& found,
                                         const ResponsesOfModel& wanted) {
  return LargestOf(
      found, wanted, [](const Eigen::VectorXd& difference, double of_gains) {
        const Eigen::Index last = difference.size() - 1;
        return LargestGainBound(difference.tail(last) - difference.head(last)) +
               std::abs(of_gains - difference(last));
      });
}

}  // namespace mle
