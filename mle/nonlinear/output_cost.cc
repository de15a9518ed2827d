#include "mle/nonlinear/output_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "ceres/cost_function.h"
#include "mle/nonlinear/elimination.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Columns of a segment, from the left: amplitudes of the elements held, of
// lines and steps; free responses of the free elements; where there are
// derivatives those of each free element by K, ln T and L; residuals. The
// derivative by ln T takes the amplitudes of the free responses: they are those
// of the evaluation before, which moves them by less and less as a fit ends, or
// of one at the same values, which Ceres asks for before it accepts a step.
class OutputCost : public ceres::CostFunction {
 public:
  OutputCost(const OutputErrorProblem& problem, const OutputPoint& point,
             const std::vector<bool>& free, const NoiseShape& shape,
             bool fixed_cells)
      : problem_(problem), fixed_cells_(fixed_cells), point_(point) {
    for (int j = 0; j < problem.num_elements(); ++j) {
      if (!problem.elements()[j].has_value() || !free[j]) continue;
      free_.push_back(j);
      num_modes_ += problem.elements()[j]->order();
      mutable_parameter_block_sizes()->push_back(3);
    }
    num_parameters_ = 3 * static_cast<Index>(free_.size());
    set_num_residuals(static_cast<int>(num_parameters_) + 1);
    for (int s = 0; s < problem.num_segments(); ++s) {
      parts_.push_back(Hold(s, free, shape));
    }
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    for (std::size_t f = 0; f < free_.size(); ++f) {
      point_.values[free_[f]] = {x[f][0], std::exp(x[f][1]), x[f][2]};
    }
    const Index width = jacobians != nullptr ? num_parameters_ : 0;
    MatrixXd products = Products(width);
    const Elimination compressed = EliminateFirst(width, std::move(products));
    Eigen::Map<VectorXd> values(residuals, num_residuals());
    values.setZero();
    const Index rank = compressed.rank();
    values.head(rank) = compressed.rows.col(width);
    values(num_parameters_) = std::sqrt(std::max(compressed.rest(0, 0), 0.0));
    for (std::size_t f = 0; jacobians != nullptr && f < free_.size(); ++f) {
      if (jacobians[f] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>
          jacobian(jacobians[f], num_residuals(), 3);
      jacobian.setZero();
      jacobian.topRows(rank) =
          compressed.rows.middleCols<3>(3 * static_cast<Index>(f));
    }
    return true;
  }

  // At K, ln T and L of each free element in turn.
  QuadraticModel Model(const VectorXd& x) {
    for (std::size_t f = 0; f < free_.size(); ++f) {
      const Index first = 3 * static_cast<Index>(f);
      point_.values[free_[f]] = {x(first), std::exp(x(first + 1)),
                                 x(first + 2)};
    }
    const Index n = num_parameters_;
    const MatrixXd products = Products(n);
    return {.cost = 0.5 * std::max(products(n, n), 0.0),
            .gradient = products.col(n).head(n),
            .hessian = products.topLeftCorner(n, n)};
  }

 private:
  struct Part {
    InnovationsFilter filter;
    VectorXd outputs;  // less the responses of the elements held
    Index held = 0;    // amplitudes that do not change
    // Columns with derivatives and without; the amplitudes held stay in them.
    mutable RowMajorMatrix columns = {};
    mutable RowMajorMatrix without = {};
    // As they were in the last evaluation: taken off before products are made,
    // so that little is left for them to explain.
    mutable VectorXd amplitudes = {};
  };

  Part Hold(int s, const std::vector<bool>& free,
            const NoiseShape& shape) const {
    const OutputErrorProblem::Segment& segment = problem_.segment(s);
    Part part = {
        .filter = InnovationsFilter(segment.times, shape, segment.weights),
        .outputs = segment.outputs};
    const Index rows = segment.outputs.size();
    MatrixXd held(rows, 0);
    MatrixXd response;
    MatrixXd derivatives;
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!problem_.elements()[j].has_value() || free[j]) continue;
      problem_.Respond(segment, point_, j, response, /*derivatives=*/false);
      part.outputs -=
          point_.values[j].gain * response(segment.times, Eigen::all).col(0);
      problem_.AppendModes(segment, point_, j, held, derivatives);
    }
    problem_.AppendDisturbances(s, held);
    part.held = held.cols();
    const Index amplitudes = part.held + num_modes_;
    part.amplitudes = VectorXd::Zero(amplitudes);
    part.columns.resize(rows, amplitudes + num_parameters_ + 1);
    part.without.resize(rows, amplitudes + 1);
    part.columns.leftCols(part.held) = held;
    part.without.leftCols(part.held) = held;
    return part;
  }

  // Of the derivatives (`width`, or 0) and the residuals at point_.
  MatrixXd Products(Index width) const {
    if (!fixed_cells_) point_.SetCells(problem_.sample_time());
    if (width > 0 && num_modes_ > 0 && !evaluated_) {
      for (int s = 0; s < problem_.num_segments(); ++s) ProductsOf(s, 0);
    }
    evaluated_ = true;
    MatrixXd products = MatrixXd::Zero(width + 1, width + 1);
    for (int s = 0; s < problem_.num_segments(); ++s) {
      products += ProductsOf(s, width);
    }
    return products;
  }

  // Of the derivatives (`width`, or 0) and the residuals of a segment,
  // whitened, without what the amplitudes explain.
  MatrixXd ProductsOf(int s, Index width) const {
    const Part& part = parts_[s];
    const bool derivatives = width > 0;
    RowMajorMatrix& columns = derivatives ? part.columns : part.without;
    Fill(problem_.segment(s), part, derivatives, columns);
    const Index amplitudes = part.amplitudes.size();
    columns.rightCols<1>() -= columns.leftCols(amplitudes) * part.amplitudes;
    Elimination result =
        EliminateFirst(amplitudes, part.filter.WhitenedProducts(columns));
    if (amplitudes > 0) {
      part.amplitudes += result.Coefficients(columns.cols() - 1);
    }
    return std::move(result.rest);
  }

  void Fill(const OutputErrorProblem::Segment& segment, const Part& part,
            bool derivatives, RowMajorMatrix& columns) const {
    const Index last = columns.cols() - 1;
    columns.col(last) = part.outputs;
    Index mode = part.held;
    Index parameter = part.held + num_modes_;
    for (const int j : free_) {
      const double gain = point_.values[j].gain;
      problem_.Respond(segment, point_, j, response_, derivatives);
      const Index r = problem_.elements()[j]->order();
      modes_.resize(columns.rows(), r);
      mode_derivatives_.resize(columns.rows(), r);
      problem_.Modes(segment, point_, j, modes_, mode_derivatives_);
      columns.middleCols(mode, r) = modes_;
      if (derivatives) {
        by_time_scale_.noalias() =
            mode_derivatives_ * part.amplitudes.segment(mode, r);
      }
      for (Index row = 0; row < columns.rows(); ++row) {
        const auto at = response_.row(segment.times[row]);
        columns(row, last) -= gain * at(0);
        if (!derivatives) continue;
        columns(row, parameter) = -at(0);
        columns(row, parameter + 1) = -gain * at(1) - by_time_scale_(row);
        columns(row, parameter + 2) = -gain * at(2);
      }
      mode += r;
      parameter += 3;
    }
  }

  const OutputErrorProblem& problem_;
  bool fixed_cells_;
  std::vector<int> free_;
  Index num_modes_ = 0;  // of the free elements
  Index num_parameters_ = 0;
  std::vector<Part> parts_;
  // Of one evaluation; Ceres makes one at a time.
  mutable OutputPoint point_;
  mutable MatrixXd response_;
  mutable MatrixXd modes_;
  mutable MatrixXd mode_derivatives_;
  mutable VectorXd by_time_scale_;
  mutable bool evaluated_ = false;  // amplitudes are known
};

}  // namespace

std::unique_ptr<ceres::CostFunction> MakeOutputCost(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const std::vector<bool>& free, const NoiseShape& shape, bool fixed_cells) {
  return std::make_unique<OutputCost>(problem, point, free, shape, fixed_cells);
}

std::function<QuadraticModel(const VectorXd&)> MakeOutputModel(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const std::vector<bool>& free, const NoiseShape& shape, bool fixed_cells) {
  const auto cost =
      std::make_shared<OutputCost>(problem, point, free, shape, fixed_cells);
  return [cost](const VectorXd& x) { return cost->Model(x); };
}

}  // namespace mle
