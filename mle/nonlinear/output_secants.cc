#include <algorithm>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

using Eigen::MatrixXd;

void OutputErrorProblem::TakeSecants(
    const OutputPoint& point, const std::vector<bool>& free,
    const std::vector<double>& steps,
    std::vector<SegmentColumns>& columns) const {
  Eigen::Index by_delay = -1;
  for (int j = 0; j < num_elements(); ++j) {
    if (!free[j]) continue;
    by_delay += 3;
    if (!elements_[j].has_value() || !(steps[j] > 0.0)) continue;
    OutputPoint ends[2] = {point, point};
    ends[0].values[j].delay = std::max(point.values[j].delay - steps[j], 0.0);
    ends[1].values[j].delay = point.values[j].delay + steps[j];
    const double width = ends[1].values[j].delay - ends[0].values[j].delay;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const Segment& segment = segments_[s];
      MatrixXd responses[2];
      for (int end = 0; end < 2; ++end) {
        ends[end].SetCells(sample_time_);
        Respond(segment, ends[end], j, responses[end], /*derivatives=*/false);
      }
      auto column = columns[s].jacobian.col(by_delay);
      for (Eigen::Index row = 0; row < column.size(); ++row) {
        const int k = segment.times[row];
        column(row) = -point.values[j].gain *
                      (responses[1](k, 0) - responses[0](k, 0)) / width;
      }
    }
  }
}

}  // namespace mle
