#include "mle/nonlinear/output_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "ceres/cost_function.h"
#include "mle/nonlinear/elimination.h"
#include "mle/nonlinear/response_rows.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The cost of the square of an amplitude, over the square of its column at
// first: next to nothing but for amplitudes that free responses of nearly equal
// time constants need against each other. If a rank were cut off it would
// change with the time constants, and the objective jump each time by what an
// amplitude explains of noise.
constexpr double kAmplitudeCost = 1e-11;

// The elements that are free.
std::vector<int> FreeElements(const OutputErrorProblem& problem,
                              const std::vector<bool>& free) {
  std::vector<int> elements;
  for (int j = 0; j < problem.num_elements(); ++j) {
    if (problem.elements()[j].has_value() && free[j]) elements.push_back(j);
  }
  return elements;
}

// Columns of a segment, from the left: amplitudes of the elements held, of
// lines and steps; free responses of the free elements; where there are
// derivatives those of each free element by K, ln T and L, and of the free
// responses by ln T; residuals. The derivative by ln T takes the amplitudes of
// the free responses, which are known once they are eliminated: the products of
// its parts are added up then.
class OutputCost : public ceres::CostFunction {
 public:
  OutputCost(const OutputErrorProblem& problem, const OutputPoint& point,
             const std::vector<bool>& free, const NoiseShape& shape,
             bool fixed_cells)
      : problem_(problem),
        fixed_cells_(fixed_cells),
        free_(FreeElements(problem, free)),
        point_(point),
        responses_(problem, free_) {
    for (const int j : free_) {
      num_modes_ += problem.elements()[j]->order();
      mutable_parameter_block_sizes()->push_back(3);
    }
    num_parameters_ = 3 * static_cast<Index>(free_.size());
    set_num_residuals(static_cast<int>(num_parameters_) + 1);
    columns_.resize(free_.size());
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
    const Elimination compressed = EliminateFirst(width, Products(width));
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
    VectorXd outputs;         // less the responses of the elements held
    MatrixXd held;            // columns of amplitudes that do not change
    std::vector<Index> ends;  // of each of them (WhitenedProducts)
    // As they were in the last evaluation: taken off before products are made,
    // so that little is left for them to explain.
    mutable VectorXd amplitudes = {};
    mutable VectorXd costs = {};  // of their squares
  };

  // The free responses of a free element in a segment.
  struct Columns {
    // From the first sample that counts on, as long as they are not zero.
    MatrixXd modes;
    MatrixXd mode_derivatives;
    Index end = 0;  // from this row on both are zero
  };

  Part Hold(int s, const std::vector<bool>& free,
            const NoiseShape& shape) const {
    const OutputErrorProblem::Segment& segment = problem_.segment(s);
    Part part = {
        .filter = InnovationsFilter(segment.times, shape, segment.weights),
        .outputs = segment.outputs,
        .held = {},
        .ends = {}};
    const Index rows = segment.outputs.size();
    Index modes = 0;
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (IsHeld(j, free)) modes += problem_.elements()[j]->order();
    }
    MatrixXd held(rows, modes);
    MatrixXd derivatives(rows, modes);
    MatrixXd response;
    Index mode = 0;
    for (int j = 0; j < problem_.num_elements(); ++j) {
      if (!IsHeld(j, free)) continue;
      problem_.Respond(segment, point_, j, response, /*derivatives=*/false);
      part.outputs -=
          point_.values[j].gain * response(segment.times, Eigen::all).col(0);
      const Index r = problem_.elements()[j]->order();
      const Index end =
          problem_.Modes(segment, point_, j, held.middleCols(mode, r),
                         derivatives.middleCols(mode, r));
      part.ends.insert(part.ends.end(), r, end);
      mode += r;
    }
    problem_.AppendDisturbances(s, held);
    part.ends.resize(held.cols(), rows);
    part.held = held;
    part.amplitudes = VectorXd::Zero(held.cols() + num_modes_);
    return part;
  }

  bool IsHeld(int j, const std::vector<bool>& free) const {
    return problem_.elements()[j].has_value() && !free[j];
  }

  // Products of the derivatives (`width`, or 0) and the residuals at point_.
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

  // Products of the derivatives (`width`, or 0) and the residuals of a segment,
  // whitened, without what the amplitudes explain.
  MatrixXd ProductsOf(int s, Index width) const {
    const Part& part = parts_[s];
    const OutputErrorProblem::Segment& segment = problem_.segment(s);
    const Index amplitudes = part.amplitudes.size();
    const Index columns = amplitudes + width + (width > 0 ? num_modes_ : 0) + 1;
    Start(segment, width > 0);
    MatrixXd products = part.filter.WhitenedProducts(
        columns,
        [&](Index first, Index count, const std::vector<Index>& live,
            double* rows, Index stride) {
          Fill(segment, part, width > 0, first, live,
               {rows, count, std::ssize(live), Eigen::OuterStride<>(stride)});
        },
        EndsOf(part, width));
    AddCostOfAmplitudes(part, products);
    Elimination result = EliminateFirst(amplitudes, products);
    if (amplitudes > 0) {
      part.amplitudes += result.Coefficients(columns - 1);
    }
    if (width == 0) return std::move(result.rest);
    return WithAmplitudes(part.amplitudes.tail(num_modes_), width,
                          InTurn(result.rest));
  }

  // To the products of amplitudes' columns, of all else and of residuals: what
  // the amplitudes cost that are taken off the residuals.
  static void AddCostOfAmplitudes(const Part& part, MatrixXd& products) {
    const Index count = part.amplitudes.size();
    const Index residuals = products.cols() - 1;
    if (part.costs.size() < count) {
      part.costs = kAmplitudeCost * products.diagonal().head(count);
    }
    const VectorXd pull = part.costs.cwiseProduct(part.amplitudes);
    products.diagonal().head(count) += part.costs;
    products.col(residuals).head(count) -= pull;
    products.row(residuals).head(count) -= pull;
    products(residuals, residuals) += pull.dot(part.amplitudes);
  }

  // Derivatives by K, ln T and L of each element in turn, all else behind them.
  MatrixXd InTurn(const MatrixXd& products) const {
    std::vector<Index> places = responses_.places();
    while (std::ssize(places) < products.cols()) {
      places.push_back(std::ssize(places));
    }
    return products(places, places);
  }

  // Products of `width` derivatives and the residuals, from those that have
  // derivatives of free responses between them: these are taken times their
  // amplitudes to the derivatives by ln T.
  MatrixXd WithAmplitudes(const Eigen::Ref<const VectorXd>& amplitudes,
                          Index width, MatrixXd products) const {
    Index mode = 0;
    for (std::size_t f = 0; f < free_.size(); ++f) {
      const Index by_time_scale = 3 * static_cast<Index>(f) + 1;
      for (Index c = 0; c < columns_[f].modes.cols(); ++c, ++mode) {
        const double amplitude = amplitudes(mode);
        products.row(by_time_scale) -= amplitude * products.row(width + mode);
        products.col(by_time_scale) -= amplitude * products.col(width + mode);
      }
    }
    MatrixXd of_all(width + 1, width + 1);
    of_all.topLeftCorner(width, width) = products.topLeftCorner(width, width);
    of_all.row(width).head(width) = products.bottomRows<1>().head(width);
    of_all.col(width).head(width) = products.rightCols<1>().head(width);
    of_all(width, width) = products(width + mode, width + mode);
    return of_all;
  }

  void Start(const OutputErrorProblem::Segment& segment,
             bool derivatives) const {
    responses_.Start(segment, point_, derivatives);
    for (std::size_t f = 0; f < free_.size(); ++f) {
      Columns& of = columns_[f];
      of.end = problem_.FreeResponses(segment, point_, free_[f], of.modes,
                                      of.mode_derivatives);
    }
  }

  // Ends of all columns (WhitenedProducts).
  std::vector<Index> EndsOf(const Part& part, Index width) const {
    const Index rows = part.outputs.size();
    std::vector<Index> ends = part.ends;
    const auto append_modes = [&] {
      for (const Columns& of : columns_) {
        ends.insert(ends.end(), of.modes.cols(), of.end);
      }
    };
    append_modes();
    ends.insert(ends.end(), width, rows);
    if (width > 0) append_modes();
    ends.push_back(rows);
    return ends;
  }

  // The columns `live` of the samples from `first` on, in turn.
  using Rows = Eigen::Map<RowMajorMatrix, 0, Eigen::OuterStride<>>;
  void Fill(const OutputErrorProblem::Segment& segment, const Part& part,
            bool derivatives, Index first, const std::vector<Index>& live,
            Rows rows) const {
    const Index count = rows.rows();
    const Index held = part.held.cols();
    Index next = 0;  // in `live`
    const auto is_live = [&](Index column) { return live[next] == column; };
    rest_ = part.outputs.segment(first, count);
    for (Index c = 0; c < held; ++c) {
      if (!is_live(c)) continue;
      const auto column = part.held.col(c).segment(first, count);
      rows.col(next++) = column;
      rest_ -= part.amplitudes(c) * column;
    }
    const int* times = segment.times.data() + first;
    const int begin = segment.times.front();
    // A free response, which is zero behind its samples.
    const auto copy = [&](const double* column, Index samples, Index to) {
      for (Index row = 0; row < count; ++row) {
        const int k = times[row] - begin;
        rows(row, to) = k < samples ? column[k] : 0.0;
      }
    };
    Index mode = held;
    for (const Columns& of : columns_) {
      for (Index c = 0; c < of.modes.cols(); ++c, ++mode) {
        if (!is_live(mode)) continue;
        copy(of.modes.col(c).data(), of.modes.rows(), next);
        rest_ -= part.amplitudes(mode) * rows.col(next++);
      }
    }
    responses_.Next(times, count, rest_.data(), rows.data() + next,
                    rows.outerStride());
    if (derivatives) next += num_parameters_;
    rows.col(std::ssize(live) - 1) = rest_;
    if (!derivatives) return;
    Index by_mode = mode + num_parameters_;
    for (const Columns& of : columns_) {
      for (Index c = 0; c < of.modes.cols(); ++c, ++by_mode) {
        if (!is_live(by_mode)) continue;
        copy(of.mode_derivatives.col(c).data(), of.mode_derivatives.rows(),
             next++);
      }
    }
  }

  const OutputErrorProblem& problem_;
  bool fixed_cells_;
  std::vector<int> free_;
  Index num_modes_ = 0;  // of the free elements
  Index num_parameters_ = 0;
  std::vector<Part> parts_;
  // The state of one evaluation; Ceres makes one at a time.
  mutable OutputPoint point_;
  mutable std::vector<Columns> columns_;  // of each free element
  mutable ResponseRows responses_;
  mutable VectorXd rest_;           // residuals of rows
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
