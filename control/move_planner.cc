#include "control/move_planner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// S_0; …; S_{H_p−1} of the manipulated inputs.
MatrixXd ManipulatedResponses(const PredictionModel& model,
                              const std::vector<int>& manipulated,
                              int prediction_horizon) {
  const int p = model.num_outputs;
  MatrixXd responses(p * prediction_horizon, manipulated.size());
  for (int i = 0; i < prediction_horizon; ++i) {
    const int k = std::min(i, model.periods());
    for (std::size_t j = 0; j < manipulated.size(); ++j) {
      responses.col(j).segment(p * i, p) =
          model.responses.col(manipulated[j]).segment(p * k, p);
    }
  }
  return responses;
}

// The effect of the moves on the predicted outputs: block (i, b) is S_{i−t_b},
// i = 1 … H_p.
MatrixXd DynamicMatrix(const MatrixXd& responses, int p,
                       const std::vector<int>& instants) {
  const Eigen::Index m = responses.cols();
  MatrixXd dynamic = MatrixXd::Zero(
      responses.rows(), m * static_cast<Eigen::Index>(instants.size()));
  for (std::size_t b = 0; b < instants.size(); ++b) {
    const Eigen::Index first = Eigen::Index{p} * (instants[b] - 1);
    const Eigen::Index rows = responses.rows() - first;
    dynamic.block(first, m * static_cast<Eigen::Index>(b), rows, m) =
        responses.topRows(rows);
  }
  return dynamic;
}

// S_0ᵀ Q_y, …, S_{H_p−1}ᵀ Q_y, side by side.
MatrixXd Weighted(const MatrixXd& responses, const MatrixXd& output_weight) {
  const Eigen::Index p = output_weight.rows();
  MatrixXd weighted(responses.cols(), responses.rows());
  for (Eigen::Index row = 0; row < responses.rows(); row += p) {
    weighted.middleCols(row, p).noalias() =
        responses.middleRows(row, p).transpose() * output_weight;
  }
  return weighted;
}

// Gᵀ Q G of moves at `instants`: of those at t_b ≤ t_c, with d = t_c − t_b,
// Σ_{k=0}^{H_p−t_c} S_{k+d}ᵀ Q_y S_k, one sum for each d that is read at all
// its ends.
MatrixXd Curvature(const MatrixXd& responses, const MatrixXd& weighted, int p,
                   const std::vector<int>& instants) {
  const Eigen::Index m = responses.cols();
  const auto blocks = static_cast<Eigen::Index>(instants.size());
  struct Block {
    Eigen::Index b, c;
    Eigen::Index distance;  // d
    Eigen::Index terms;
  };
  std::vector<Block> order;
  for (Eigen::Index c = 0; c < blocks; ++c) {
    for (Eigen::Index b = 0; b <= c; ++b) {
      order.push_back({b, c, instants[c] - instants[b],
                       responses.rows() / p - instants[c] + 1});
    }
  }
  std::sort(order.begin(), order.end(), [](const Block& one, const Block& two) {
    return std::pair(one.distance, one.terms) <
           std::pair(two.distance, two.terms);
  });
  MatrixXd curvature(m * blocks, m * blocks);
  MatrixXd sum;
  Eigen::Index summed = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& [b, c, distance, terms] = order[i];
    if (i == 0 || distance != order[i - 1].distance) {
      sum = MatrixXd::Zero(m, m);
      summed = 0;
    }
    const Eigen::Index size = p * (terms - summed);
    sum.noalias() += weighted.middleCols(p * (summed + distance), size) *
                     responses.middleRows(p * summed, size);
    summed = terms;
    curvature.block(m * b, m * c, m, m) = sum;
    curvature.block(m * c, m * b, m, m) = sum.transpose();
  }
  return curvature;
}

// The slope of each move's response at the end of the horizon, p rows.
MatrixXd EndSlopes(const MatrixXd& responses, int p,
                   const std::vector<int>& instants) {
  const Eigen::Index m = responses.cols();
  const auto blocks = static_cast<Eigen::Index>(instants.size());
  MatrixXd slopes(p, m * blocks);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index last = responses.rows() - p * Eigen::Index{instants[b]};
    slopes.middleCols(m * b, m) = responses.middleRows(last, p);
    if (last > 0)
      slopes.middleCols(m * b, m) -= responses.middleRows(last - p, p);
  }
  return slopes;
}

// Q_y of the slope at the end, of the outputs that integrate.
MatrixXd SlopeWeight(const PredictionModel& model,
                     const std::vector<int>& manipulated,
                     const MpcOptions& options) {
  const MatrixXd slopes = model.SlopesOf(manipulated);
  const VectorXd integrates =
      (slopes.array() != 0.0).rowwise().any().cast<double>();
  const double horizon = options.prediction_horizon;
  return horizon * (horizon + 1.0) * (2.0 * horizon + 1.0) / 6.0 *
         (integrates.asDiagonal() * options.output_weight *
          integrates.asDiagonal());
}

struct Solution {
  MatrixXd hessian;  // H = GᵀQG + R
  MatrixXd gain;     // rows of H⁻¹ GᵀQ
};

// Q is block-diagonal but for the slope at its end, R is block-diagonal. The
// gain has all moves if `all_moves`, else the first alone.
absl::StatusOr<Solution> SolveWithoutLimits(const MatrixXd& responses,
                                            const std::vector<int>& instants,
                                            const MatrixXd& output_weight,
                                            const MatrixXd& slope_weight,
                                            const MatrixXd& move_weight,
                                            bool all_moves) {
  const Eigen::Index p = output_weight.rows();
  const Eigen::Index m = move_weight.rows();
  const MatrixXd weighted = Weighted(responses, output_weight);
  MatrixXd hessian =
      Curvature(responses, weighted, static_cast<int>(p), instants);
  const bool ramps = !slope_weight.isZero(0.0);
  MatrixXd slopes;
  if (ramps) {
    slopes = EndSlopes(responses, static_cast<int>(p), instants);
    hessian += slopes.transpose() * slope_weight * slopes;
  }
  for (Eigen::Index row = 0; row < hessian.rows(); row += m) {
    hessian.block(row, row, m, m) += move_weight;
  }
  hessian = 0.5 * (hessian + hessian.transpose()).eval();

  // Scaled to a unit diagonal, so that the test below and the solution do not
  // depend on the units of the inputs.
  const VectorXd diagonal = hessian.diagonal();
  VectorXd scale;
  Eigen::LLT<MatrixXd> scaled;
  double smallest = 0.0;  // 1/‖·‖₁ of the inverse, at most the least eigenvalue
  if (diagonal.minCoeff() > 0.0) {
    scale = diagonal.cwiseSqrt().cwiseInverse();
    const MatrixXd matrix = scale.asDiagonal() * hessian * scale.asDiagonal();
    scaled.compute(matrix);
    if (scaled.info() == Eigen::Success) {
      smallest = scaled.rcond() * matrix.cwiseAbs().colwise().sum().maxCoeff();
    }
  }
  if (!(smallest > 1e-14 * static_cast<double>(hessian.rows()))) {
    return absl::InvalidArgumentError(
        "the weights do not determine the moves: the Hessian of the control "
        "problem is not positive definite; make move_weight positive definite");
  }
  // Rows of H⁻¹, and their products with GᵀQ, move by move.
  MatrixXd rows =
      MatrixXd::Identity(hessian.rows(), all_moves ? hessian.rows() : m);
  rows = (scale.asDiagonal() * scaled.solve(scale.asDiagonal() * rows))
             .transpose()
             .eval();
  MatrixXd gain = MatrixXd::Zero(rows.rows(), responses.rows());
  for (std::size_t b = 0; b < instants.size(); ++b) {
    const Eigen::Index first = p * (Eigen::Index{instants[b]} - 1);
    const Eigen::Index size = responses.rows() - first;
    gain.rightCols(size).noalias() +=
        rows.middleCols(m * static_cast<Eigen::Index>(b), m) *
        weighted.leftCols(size);
  }
  if (ramps) {
    const MatrixXd of_slope = rows * slopes.transpose() * slope_weight;
    gain.rightCols(p) += of_slope;
    if (gain.cols() > p) gain.middleCols(gain.cols() - 2 * p, p) -= of_slope;
  }
  if (!gain.allFinite()) {
    return absl::InvalidArgumentError(
        "the controller's gain has values that are not finite: weights or "
        "gains of the model of these sizes go beyond double precision");
  }
  return Solution{hessian, gain};
}

VectorXd Pick(const VectorXd& values, const std::vector<int>& channels,
              double otherwise) {
  VectorXd picked = VectorXd::Constant(channels.size(), otherwise);
  if (values.size() > 0) picked = values(channels);
  return picked;
}

std::vector<int> FirstIntegers(int count) {
  std::vector<int> integers(count);
  for (int i = 0; i < count; ++i) integers[i] = i;
  return integers;
}

}  // namespace

absl::StatusOr<MovePlanner> MovePlanner::Create(const PredictionModel& model,
                                                const MpcOptions& options) {
  const std::vector<int> manipulated = model.InputsOf(InputRole::kManipulated);
  CHECK(!manipulated.empty());
  const std::vector<int> instants = options.MoveInstants();
  MovePlanner planner;
  planner.num_inputs_ = static_cast<int>(manipulated.size());
  planner.num_outputs_ = model.num_outputs;
  planner.num_blocks_ = static_cast<int>(instants.size());
  const MatrixXd responses =
      ManipulatedResponses(model, manipulated, options.prediction_horizon);
  const bool limited = planner.SetLimits(manipulated, options.limits);
  MLE_ASSIGN_OR_RETURN(
      Solution solution,
      SolveWithoutLimits(responses, instants, options.output_weight,
                         SlopeWeight(model, manipulated, options),
                         options.move_weight(manipulated, manipulated),
                         /*all_moves=*/limited));
  planner.gain_ = solution.gain.topRows(planner.num_inputs_);
  planner.moves_ = VectorXd::Zero(solution.hessian.rows());
  planner.planned_ = MatrixXd::Zero(planner.num_inputs_, planner.num_blocks_);
  if (!limited) return planner;
  MLE_RETURN_IF_ERROR(planner.AddLimits(
      DynamicMatrix(responses, model.num_outputs, instants), solution.hessian));
  planner.full_gain_ = std::move(solution.gain);
  return planner;
}

bool MovePlanner::SetLimits(const std::vector<int>& manipulated,
                            const MpcLimits& limits) {
  const std::vector<int> outputs = FirstIntegers(num_outputs_);
  min_input_ = Pick(limits.min_input, manipulated, -kInfinity);
  max_input_ = Pick(limits.max_input, manipulated, kInfinity);
  max_move_ = Pick(limits.max_move, manipulated, kInfinity);
  min_output_ = Pick(limits.min_output, outputs, -kInfinity);
  max_output_ = Pick(limits.max_output, outputs, kInfinity);
  output_limit_cost_ = Pick(limits.output_limit_cost, outputs, 0.0);
  return min_input_.array().isFinite().any() ||
         max_input_.array().isFinite().any() ||
         max_move_.array().isFinite().any() ||
         min_output_.array().isFinite().any() ||
         max_output_.array().isFinite().any();
}

absl::Status MovePlanner::AddLimits(const MatrixXd& dynamic,
                                    const MatrixXd& hessian) {
  const int m = num_inputs_;
  for (int b = 0; b < num_blocks_; ++b) {
    for (int j = 0; j < m; ++j) {
      if (std::isfinite(min_input_[j]) || std::isfinite(max_input_[j])) {
        rows_.push_back({Row::Kind::kInput, j, b});
      }
      if (std::isfinite(max_move_[j])) {
        rows_.push_back({Row::Kind::kMove, j, b});
      }
    }
  }
  const int horizon = static_cast<int>(dynamic.rows()) / num_outputs_;
  for (int i = 0; i < horizon; ++i) {
    for (int out = 0; out < num_outputs_; ++out) {
      const bool limited =
          std::isfinite(min_output_[out]) || std::isfinite(max_output_[out]);
      // An output that no move can reach by then is not worth a row.
      if (limited && !dynamic.row(i * num_outputs_ + out).isZero(0.0)) {
        rows_.push_back({Row::Kind::kOutput, out, i});
      }
    }
  }
  if (rows_.empty()) return absl::OkStatus();

  MatrixXd A = MatrixXd::Zero(rows_.size(), dynamic.cols());
  VectorXd cost = VectorXd::Constant(rows_.size(), kInfinity);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto& [kind, channel, step] = rows_[r];
    if (kind == Row::Kind::kOutput) {
      A.row(r) = dynamic.row(step * num_outputs_ + channel);
      cost[r] = output_limit_cost_[channel];
    } else {
      const int first = kind == Row::Kind::kInput ? 0 : step;
      for (int b = first; b <= step; ++b) A(r, b * m + channel) = 1.0;
    }
  }
  MLE_ASSIGN_OR_RETURN(program_, QuadraticProgram::Create(hessian, A, cost));
  lower_ = upper_ = VectorXd::Zero(rows_.size());
  lowest_ = highest_ = MatrixXd::Zero(m, num_blocks_);
  return absl::OkStatus();
}

const PlanSummary& MovePlanner::Plan(
    const Eigen::Ref<const VectorXd>& errors,
    const Eigen::Ref<const VectorXd>& free_outputs,
    const Eigen::Ref<const VectorXd>& inputs) {
  summary_ = PlanSummary();
  if (!has_limits()) {
    moves_.head(num_inputs_).noalias() = gain_ * errors;
    planned_.col(0) = inputs + moves_.head(num_inputs_);
    return summary_;
  }
  moves_.noalias() = full_gain_ * errors;
  SetBounds(free_outputs, inputs);
  const QuadraticProgram::Summary solved =
      program_->Solve(moves_, lower_, upper_);
  summary_.optimal = solved.converged;
  summary_.iterations = solved.iterations;
  summary_.active_limits = solved.active_rows;
  if (solved.converged) summary_.output_violation = OutputViolation();
  CutToLimits(solved.converged ? program_->x() : moves_, inputs);
  return summary_;
}

void MovePlanner::SetBounds(const Eigen::Ref<const VectorXd>& free_outputs,
                            const Eigen::Ref<const VectorXd>& inputs) {
  for (int b = 0; b < num_blocks_; ++b) {
    for (int j = 0; j < num_inputs_; ++j) {
      // An infinite move limit reaches everything.
      const double reach = (b + 1) * max_move_[j];
      lowest_(j, b) = std::min(min_input_[j], inputs[j] + reach);
      highest_(j, b) = std::max(max_input_[j], inputs[j] - reach);
      if (lowest_(j, b) < min_input_[j] || highest_(j, b) > max_input_[j]) {
        summary_.limits_widened = true;
      }
    }
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto& [kind, channel, step] = rows_[r];
    switch (kind) {
      case Row::Kind::kInput:
        lower_[r] = lowest_(channel, step) - inputs[channel];
        upper_[r] = highest_(channel, step) - inputs[channel];
        break;
      case Row::Kind::kMove:
        lower_[r] = -max_move_[channel];
        upper_[r] = max_move_[channel];
        break;
      case Row::Kind::kOutput: {
        const double free = free_outputs[step * num_outputs_ + channel];
        lower_[r] = min_output_[channel] - free;
        upper_[r] = max_output_[channel] - free;
        break;
      }
    }
  }
}

// Takes rounding off the solution, so that limits of inputs hold exactly.
void MovePlanner::CutToLimits(const Eigen::Ref<const VectorXd>& moves,
                              const Eigen::Ref<const VectorXd>& inputs) {
  for (int j = 0; j < num_inputs_; ++j) {
    double input = inputs[j];
    for (int b = 0; b < num_blocks_; ++b) {
      const double low = std::max(lowest_(j, b), input - max_move_[j]);
      const double high = std::min(highest_(j, b), input + max_move_[j]);
      input = std::max(low, std::min(high, input + moves[b * num_inputs_ + j]));
      planned_(j, b) = input;
    }
  }
}

double MovePlanner::OutputViolation() const {
  double worst = 0.0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (rows_[r].kind != Row::Kind::kOutput) continue;
    worst = std::max(worst, std::abs(program_->multipliers()[r]) /
                                output_limit_cost_[rows_[r].channel]);
  }
  return worst;
}

}  // namespace mle::control
