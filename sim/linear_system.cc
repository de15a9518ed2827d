#include "sim/linear_system.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "sim/fastest_time_constant.h"

namespace mle::sim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// An element of the transfer matrix in the block-diagonal system.
struct Block {
  int output = 0;
  int input = 0;
  int column = 0;  // of B and D: its path
  Index first_state = 0;
  TransferFunction element;
  StateSpace system;
  std::optional<ElementAgeing> ageing;
};

std::vector<Block> MakeBlocks(const ProcessModel& model,
                              const AgeingSchedule& ageing) {
  std::vector<Block> blocks;
  Index states = 0;
  for (const auto& [i, j] : Pairs(model)) {
    if (model.element(i, j).IsZero()) continue;
    Block block;
    block.output = i;
    block.input = j;
    block.column = static_cast<int>(blocks.size());
    block.first_state = states;
    block.element = model.element(i, j);
    block.system = block.element.Realize();
    for (const ElementAgeing& one : ageing.elements) {
      if (one.output == i && one.input == j) block.ageing = one;
    }
    states += block.system.A.rows();
    blocks.push_back(std::move(block));
  }
  return blocks;
}

InputPath PathOf(const Block& block) {
  const double delay = block.element.delay();
  return {block.input,
          block.ageing ? block.ageing->delay.Shifted(delay) : Schedule(delay)};
}

// The fastest time constant at any time, +∞ for a static element.
double FastestOf(const Block& block) {
  if (block.system.A.rows() == 0) {
    return std::numeric_limits<double>::infinity();
  }
  const double fastest = FastestTimeConstant(block.system.A);
  return block.ageing ? fastest * block.ageing->time_constant.Min() *
                            std::min(1.0, block.ageing->falling)
                      : fastest;
}

void WriteBlock(const Block& block, double time,
                LinearCoefficients& coefficients) {
  const Index r = block.system.A.rows();
  const double gain = block.ageing ? block.ageing->gain.At(time) : 1.0;
  const double rate =
      block.ageing ? 1.0 / block.ageing->time_constant.At(time) : 1.0;
  coefficients.D(block.output, block.column) = gain * block.system.D;
  if (r == 0) return;
  coefficients.A.block(block.first_state, block.first_state, r, r) =
      rate * block.system.A;
  coefficients.B.block(block.first_state, block.column, r, 1) =
      rate * block.system.B;
  coefficients.C.block(block.output, block.first_state, 1, r) =
      gain * block.system.C;
  if (!block.element.IsIntegrating()) return;
  // The first state is the integral (A has nothing in its column): what has
  // been integrated stays.
  coefficients.A.row(block.first_state).segment(block.first_state, r) =
      gain * block.system.A.row(0);
  coefficients.B(block.first_state, block.column) = gain * block.system.B(0);
  coefficients.C(block.output, block.first_state) = block.system.C(0);
}

// Slows the derivatives of blocks whose output falls.
void AddDirections(std::vector<Block> blocks, ContinuousSystem& system) {
  std::erase_if(blocks, [](const Block& block) {
    return !block.ageing || block.ageing->falling == 1.0 ||
           block.system.A.rows() == 0;
  });
  if (blocks.empty()) return;
  system.derivative =
      [blocks = std::move(blocks), rising = std::move(system.derivative)](
          double time, const VectorXd& x, const VectorXd& w, VectorXd& dx) {
        rising(time, x, w, dx);
        for (const Block& block : blocks) {
          auto part = dx.segment(block.first_state, block.system.A.rows());
          const double slope =
              block.ageing->gain.At(time) * block.system.C.row(0).dot(part);
          if (slope < 0.0) part /= block.ageing->falling;
        }
      };
}

void AddBreaks(const Schedule& schedule, std::vector<double>& breaks) {
  if (schedule.IsConstant()) return;
  for (const Schedule::Point& point : schedule.points()) {
    breaks.push_back(point.time);
  }
}

absl::Status CheckShapes(const LinearCoefficients& c, Index paths) {
  const Index n = c.A.rows();
  const Index p = c.C.rows();
  if (c.A.cols() == n && c.B.rows() == n && c.B.cols() == paths &&
      c.C.cols() == n && c.D.rows() == p && c.D.cols() == paths && p >= 1) {
    return absl::OkStatus();
  }
  const auto shape = [](const MatrixXd& matrix) {
    return absl::StrCat(matrix.rows(), " × ", matrix.cols());
  };
  return InvalidArgument(
      "the linear system has A ", shape(c.A), ", B ", shape(c.B), ", C ",
      shape(c.C), ", D ", shape(c.D), " and ", paths,
      " paths; A must be n × n, B n × q, C p × n, D p × q for q paths");
}

}  // namespace

absl::StatusOr<ContinuousSystem> MakeLinearSystem(
    LinearCoefficients coefficients, int num_inputs,
    std::vector<InputPath> paths, CoefficientUpdate update,
    double relative_step) {
  MLE_RETURN_IF_ERROR(
      CheckShapes(coefficients, static_cast<Index>(paths.size())));
  const Index n = coefficients.A.rows();
  ContinuousSystem system;
  system.num_inputs = num_inputs;
  system.num_outputs = static_cast<int>(coefficients.C.rows());
  system.paths = std::move(paths);
  system.initial_state = VectorXd::Zero(n);
  system.largest_step =
      n == 0 ? std::numeric_limits<double>::infinity()
             : relative_step * FastestTimeConstant(coefficients.A);
  system.derivative = [c = coefficients, update](double time, const VectorXd& x,
                                                 const VectorXd& w,
                                                 VectorXd& dx) mutable {
    if (update) update(time, c);
    dx = c.A.lazyProduct(x) + c.B.lazyProduct(w);
  };
  system.output = [c = std::move(coefficients), update = std::move(update)](
                      double time, const VectorXd& x, const VectorXd& w,
                      VectorXd& y) mutable {
    if (update) update(time, c);
    y = c.C.lazyProduct(x) + c.D.lazyProduct(w);
  };
  return system;
}

absl::StatusOr<ContinuousSystem> ToLinearSystem(const ProcessModel& model,
                                                const AgeingSchedule& ageing,
                                                double relative_step) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(ageing.Validate(model));
  std::vector<Block> blocks = MakeBlocks(model, ageing);
  std::vector<InputPath> paths;
  std::vector<double> breaks;
  double largest_step = std::numeric_limits<double>::infinity();
  for (const Block& block : blocks) {
    paths.push_back(PathOf(block));
    largest_step = std::min(largest_step, relative_step * FastestOf(block));
    if (block.ageing) {
      AddBreaks(block.ageing->gain, breaks);
      AddBreaks(block.ageing->time_constant, breaks);
    }
  }
  // A plant without paths would be given one for each input.
  if (paths.empty()) paths.emplace_back();

  const Index n = blocks.empty() ? 0
                                 : blocks.back().first_state +
                                       blocks.back().system.A.rows();
  const Index p = model.num_outputs();
  const Index q = static_cast<Index>(paths.size());
  LinearCoefficients coefficients{MatrixXd::Zero(n, n), MatrixXd::Zero(n, q),
                                  MatrixXd::Zero(p, n), MatrixXd::Zero(p, q)};
  for (const Block& block : blocks) WriteBlock(block, 0.0, coefficients);
  const std::vector<Block> all = blocks;
  CoefficientUpdate update;
  std::erase_if(blocks, [](const Block& block) { return !block.ageing; });
  if (!blocks.empty()) {
    update = [blocks](double time, LinearCoefficients& c) {
      for (const Block& block : blocks) WriteBlock(block, time, c);
    };
  }
  MLE_ASSIGN_OR_RETURN(
      ContinuousSystem system,
      MakeLinearSystem(std::move(coefficients), model.num_inputs(),
                       std::move(paths), std::move(update), relative_step));
  system.largest_step = largest_step;
  system.breaks = std::move(breaks);
  AddDirections(all, system);
  return system;
}

}  // namespace mle::sim
