#include "mle/nonlinear/output_cost.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "Eigen/Core"
#include "ceres/cost_function.h"
#include "mle/nonlinear/amplitude_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// Columns of a segment, from the left: residuals, the derivatives of each free
// element by K, ln T and L, its free responses, their derivatives by ln T.
class OutputCost : public ceres::CostFunction {
 public:
  OutputCost(const OutputErrorProblem& problem, const OutputPoint& point,
             const std::vector<bool>& free, const NoiseShape& shape,
             bool fixed_cells)
      : problem_(problem), fixed_cells_(fixed_cells), point_(point) {
    set_num_residuals(problem.num_samples());
    for (int j = 0; j < problem.num_elements(); ++j) {
      if (!problem.elements()[j].has_value() || !free[j]) continue;
      free_.push_back(j);
      num_modes_ += problem.elements()[j]->order();
      mutable_parameter_block_sizes()->push_back(3);
    }
    Eigen::Index begin = 0;
    for (int s = 0; s < problem.num_segments(); ++s) {
      parts_.push_back(Hold(s, free, shape));
      parts_.back().begin = begin;
      begin += problem.segment(s).outputs.size();
    }
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    for (std::size_t f = 0; f < free_.size(); ++f) {
      point_.values[free_[f]] = {x[f][0], std::exp(x[f][1]), x[f][2]};
    }
    if (!fixed_cells_) point_.SetCells(problem_.sample_time());
    for (int s = 0; s < problem_.num_segments(); ++s) {
      EvaluateSegment(s, residuals, jacobians);
    }
    return true;
  }

 private:
  // What does not change with the free elements.
  struct Part {
    InnovationsFilter filter;
    VectorXd outputs;     // less the responses of the elements held
    MatrixXd amplitudes;  // whitened, of these elements, lines and steps
    Eigen::Index begin = 0;
  };

  Part Hold(int s, const std::vector<bool>& free,
            const NoiseShape& shape) const {
    const OutputErrorProblem::Segment& segment = problem_.segment(s);
    Part part = {
        .filter = InnovationsFilter(segment.times, shape, segment.weights),
        .outputs = segment.outputs,
        .amplitudes = MatrixXd(segment.outputs.size(), 0)};
    MatrixXd response;
    MatrixXd derivatives;
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!problem_.elements()[j].has_value() || free[j]) continue;
      problem_.Respond(segment, point_, j, response);
      part.outputs -=
          point_.values[j].gain * response(segment.times, Eigen::all).col(0);
      problem_.AppendModes(segment, point_, j, part.amplitudes, derivatives);
    }
    problem_.AppendDisturbances(s, part.amplitudes);
    part.filter.Apply(part.amplitudes);
    return part;
  }

  void EvaluateSegment(int s, double* residuals, double** jacobians) const {
    const Part& part = parts_[s];
    const Eigen::Index width =
        jacobians != nullptr ? 1 + 3 * static_cast<Eigen::Index>(free_.size())
                             : 1;
    const Eigen::Index derivatives = jacobians != nullptr ? num_modes_ : 0;
    columns_.resize(part.outputs.size(), width + num_modes_ + derivatives);
    Fill(problem_.segment(s), part, width);
    part.filter.Apply(columns_);
    const Eigen::Index held = part.amplitudes.cols();
    if (num_modes_ + held > 0) {
      MatrixXd amplitudes(columns_.rows(), num_modes_ + held);
      amplitudes << columns_.middleCols(width, num_modes_), part.amplitudes;
      const AmplitudeFit fit(std::move(amplitudes));
      if (jacobians != nullptr) AddModes(fit.Solve(columns_.col(0)), width);
      fit.TakeOut(columns_.leftCols(width));
    }
    Eigen::Map<VectorXd>(residuals + part.begin, columns_.rows()) =
        columns_.col(0);
    for (std::size_t f = 0; jacobians != nullptr && f < free_.size(); ++f) {
      if (jacobians[f] == nullptr) continue;
      Eigen::Map<RowMajor>(jacobians[f] + 3 * part.begin, columns_.rows(), 3) =
          columns_.middleCols<3>(1 + 3 * static_cast<Eigen::Index>(f));
    }
  }

  // `width`: without derivatives 1.
  void Fill(const OutputErrorProblem::Segment& segment, const Part& part,
            Eigen::Index width) const {
    columns_.col(0) = part.outputs;
    Eigen::Index mode = width;
    for (std::size_t f = 0; f < free_.size(); ++f) {
      const int j = free_[f];
      const double gain = point_.values[j].gain;
      problem_.Respond(segment, point_, j, response_);
      columns_.col(0) -= gain * response_(segment.times, 0);
      if (width > 1) {
        const Eigen::Index first = 1 + 3 * static_cast<Eigen::Index>(f);
        columns_.col(first) = -response_(segment.times, 0);
        columns_.col(first + 1) = -gain * response_(segment.times, 1);
        columns_.col(first + 2) = -gain * response_(segment.times, 2);
      }
      const Eigen::Index r = problem_.elements()[j]->order();
      unused_.resize(columns_.rows(), r);
      problem_.Modes(segment, point_, j, columns_.middleCols(mode, r),
                     width > 1 ? columns_.middleCols(mode + num_modes_, r)
                               : unused_.leftCols(r));
      mode += r;
    }
  }

  // The modes' part of the derivative by ln T takes their amplitudes.
  void AddModes(const VectorXd& amplitudes, Eigen::Index width) const {
    Eigen::Index mode = 0;
    for (std::size_t f = 0; f < free_.size(); ++f) {
      const Eigen::Index r = problem_.elements()[free_[f]]->order();
      columns_.col(2 + 3 * static_cast<Eigen::Index>(f)).noalias() -=
          columns_.middleCols(width + num_modes_ + mode, r) *
          amplitudes.segment(mode, r);
      mode += r;
    }
  }

  const OutputErrorProblem& problem_;
  bool fixed_cells_;
  std::vector<int> free_;
  Eigen::Index num_modes_ = 0;  // of the free elements
  std::vector<Part> parts_;
  // Of one evaluation; Ceres makes one at a time.
  mutable OutputPoint point_;
  mutable MatrixXd columns_;
  mutable MatrixXd response_;
  mutable MatrixXd unused_;  // derivatives that nobody asked for
};

}  // namespace

std::unique_ptr<ceres::CostFunction> MakeOutputCost(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const std::vector<bool>& free, const NoiseShape& shape, bool fixed_cells) {
  return std::make_unique<OutputCost>(problem, point, free, shape, fixed_cells);
}

}  // namespace mle
