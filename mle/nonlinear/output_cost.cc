#include "mle/nonlinear/output_cost.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Core"
#include "ceres/cost_function.h"

namespace mle {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

class OutputCost : public ceres::CostFunction {
 public:
  OutputCost(const OutputErrorProblem& problem, const OutputPoint& point,
             const NoiseShape& shape, bool fixed_cells)
      : problem_(problem),
        point_(point),
        shape_(shape),
        fixed_cells_(fixed_cells) {
    set_num_residuals(problem.num_samples());
    for (int j = 0; j < problem.num_elements(); ++j) {
      if (!problem.elements()[j].has_value()) continue;
      present_.push_back(j);
      mutable_parameter_block_sizes()->push_back(3);
    }
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    OutputPoint point = point_;
    for (std::size_t b = 0; b < present_.size(); ++b) {
      point.values[present_[b]] = {x[b][0], std::exp(x[b][1]), x[b][2]};
    }
    if (!fixed_cells_) point.SetCells(problem_.sample_time());
    const WhitenedColumns whitened = problem_.Whiten(
        problem_.Linearise(point, shape_, jacobians != nullptr), shape_);
    std::copy(whitened.residuals.begin(), whitened.residuals.end(), residuals);
    if (jacobians == nullptr) return true;
    for (std::size_t b = 0; b < present_.size(); ++b) {
      if (jacobians[b] == nullptr) continue;
      Eigen::Map<RowMajor>(jacobians[b], whitened.residuals.size(), 3) =
          whitened.jacobian.middleCols(3 * present_[b], 3);
    }
    return true;
  }

 private:
  const OutputErrorProblem& problem_;
  OutputPoint point_;
  NoiseShape shape_;
  bool fixed_cells_;
  std::vector<int> present_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> MakeOutputCost(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const NoiseShape& shape, bool fixed_cells) {
  return std::make_unique<OutputCost>(problem, point, shape, fixed_cells);
}

}  // namespace mle
