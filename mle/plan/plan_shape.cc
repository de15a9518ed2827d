#include "mle/plan/plan_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Steps of the grid until the model has settled, at most.
constexpr double kStepsToSettle = 60.0;
// Times until the model has settled that a window has before and after.
constexpr double kLead = 0.5;
constexpr double kTail = 1.5;
// What is known of a parameter of which nothing is known: ErrorBy().
constexpr double kNextToNothing = 1e-2;
constexpr double kOutOfReach = 1e3;
// Shares of the cost: of a move, and of each settling time that it takes.
constexpr double kPriceOfMove = 0.02;
constexpr double kPriceOfTime = 0.03;

VectorXd Room(const VectorXd& limits, const VectorXd& from, double sign) {
  if (limits.size() == 0) return VectorXd::Constant(from.size(), kInfinity);
  return sign * (limits - from);
}

}  // namespace

double MoreAbsolute(double m, double deviation) {
  if (!(deviation > 0.0)) return std::abs(m);
  const double unit = m / deviation;
  return deviation * std::sqrt(2.0 / std::numbers::pi) *
             (std::exp(-0.5 * unit * unit) - 1.0) +
         m * std::erf(unit / std::numbers::sqrt2);
}

int PlanShape::duration() const {
  return repeats * std::accumulate(holds.begin(), holds.end(), 0);
}

PlanShape PlanShape::Unrolled() const {
  PlanShape unrolled;
  const Index all = repeats * levels.cols();
  unrolled.levels.resize(levels.rows(), all);
  Index kept = 0;
  for (Index k = 0; k < all; ++k) {
    const Index s = k % levels.cols();
    const int hold = holds[static_cast<std::size_t>(s)];
    if (kept == 0 && levels.col(s).isZero(0.0)) continue;
    if (kept > 0 && unrolled.levels.col(kept - 1) == levels.col(s)) {
      unrolled.holds.back() += hold;
      continue;
    }
    unrolled.levels.col(kept++) = levels.col(s);
    unrolled.holds.push_back(hold);
  }
  if (kept > 1 && unrolled.levels.col(kept - 1).isZero(0.0)) {
    --kept;
    unrolled.holds.pop_back();
  }
  unrolled.levels.conservativeResize(levels.rows(), kept);
  return unrolled;
}

PlanGrid MakePlanGrid(const PlanProblem& problem, const PlanOptions& options) {
  PlanGrid grid;
  const double settling = SettlingTime(problem.plant);
  const int of_grid = static_cast<int>(
      std::max(std::round(options.grid / problem.sample_time), 1.0));
  grid.samples = of_grid * static_cast<int>(std::max(
                               std::floor(settling / (kStepsToSettle * of_grid *
                                                      problem.sample_time)),
                               1.0));
  grid.step = grid.samples * problem.sample_time;
  const auto steps = [&](double time) {
    return static_cast<int>(std::ceil(time / grid.step - 1e-9));
  };
  grid.settling = std::max(steps(settling), 1);
  grid.lead = steps(kLead * settling);
  grid.tail = steps(kTail * settling);
  grid.longest = std::max(
      static_cast<int>(std::floor(options.longest / grid.step + 1e-9)), 1);
  grid.scale = problem.output_deviations;
  for (double& scale : grid.scale) scale = scale > 0.0 ? scale : 1.0;
  return grid;
}

MatrixXd SetPointsOf(const PlanShape& repeated, double size,
                     const PlanGrid& grid) {
  const PlanShape shape = repeated.Unrolled();
  const Index samples =
      static_cast<Index>(shape.duration() + grid.tail) * grid.samples;
  MatrixXd set_points = MatrixXd::Zero(shape.levels.rows(), samples);
  Index first = 0;
  for (std::size_t s = 0; s < shape.holds.size(); ++s) {
    const Index count = static_cast<Index>(shape.holds[s]) * grid.samples;
    set_points.middleCols(first, count).colwise() +=
        size * shape.levels.col(static_cast<Index>(s)).cwiseProduct(grid.scale);
    first += count;
  }
  return set_points;
}

absl::StatusOr<ShapeEvaluator> ShapeEvaluator::Create(
    const PlanProblem& problem, const PlanOptions& options,
    const PlanGrid& grid, const std::vector<ProcessModel>& plants,
    std::vector<OpenQuestion> questions) {
  ShapeEvaluator made;
  made.grid_ = grid;
  made.p_ = problem.plant.num_outputs();
  made.m_ = problem.plant.num_inputs();
  Index first = made.p_ + made.m_;
  for (OpenQuestion& open : questions) {
    const int output = open.question.output;
    const Index n = open.information.rows();
    auto part = std::find_if(
        made.parts_.begin(), made.parts_.end(),
        [output](const Part& one) { return one.output == output; });
    if (part == made.parts_.end()) {
      part = made.parts_.insert(part, {output, first, n, {}});
      first += n;
    }
    Asked asked;
    asked.part = static_cast<std::size_t>(part - made.parts_.begin());
    asked.root =
        MatrixXd((open.information + kNextToNothing * MatrixXd::Identity(n, n))
                     .llt()
                     .matrixL());
    asked.open = std::move(open);
    made.asked_.push_back(std::move(asked));
  }
  made.SetPricesAndRoom(problem, options);
  made.AddOffsets(problem);
  for (const ProcessModel& plant : plants) {
    std::vector<PlanRow> rows;
    for (const Part& part : made.parts_) {
      MLE_ASSIGN_OR_RETURN(PlanRow row, PlanRow::Create(plant, part.output,
                                                        problem.sample_time));
      rows.push_back(std::move(row));
    }
    absl::StatusOr<Steps> steps = made.StepsOf(problem, plant, rows, options);
    const bool expected = made.steps_.empty();
    if (!expected && absl::IsFailedPrecondition(steps.status())) continue;
    MLE_RETURN_IF_ERROR(steps.status());
    made.steps_.push_back(*std::move(steps));
  }
  return made;
}

absl::Status ShapeEvaluator::KeepLimitsOf(const PlanProblem& problem,
                                          const ProcessModel& plant,
                                          const PlanOptions& options) {
  MLE_ASSIGN_OR_RETURN(Steps steps, StepsOf(problem, plant, {}, options));
  limiting_.push_back(std::move(steps));
  return absl::OkStatus();
}

void ShapeEvaluator::SetPricesAndRoom(const PlanProblem& problem,
                                      const PlanOptions& options) {
  deviations_ = problem.output_deviations;
  squared_price_ = options.squared_price;
  absolute_price_ = options.absolute_price;
  if (squared_price_.size() == 0 && absolute_price_.size() == 0) {
    squared_price_ = grid_.scale.cwiseAbs2().cwiseInverse();
  }
  for (VectorXd* price : {&squared_price_, &absolute_price_}) {
    if (price->size() == 0) *price = VectorXd::Zero(p_);
  }
  const VectorXd kept_of_outputs = options.deviations * deviations_;
  const VectorXd kept_of_inputs = options.deviations * problem.input_deviations;
  const VectorXd up = Room(options.max_output, problem.set_points, 1.0);
  const VectorXd down = Room(options.min_output, problem.set_points, -1.0);
  room_up_.resize(2 * p_ + m_);
  room_up_ << up - kept_of_outputs,
      Room(options.max_input, problem.inputs, 1.0) - kept_of_inputs, up;
  room_down_.resize(2 * p_ + m_);
  room_down_ << down - kept_of_outputs,
      Room(options.min_input, problem.inputs, -1.0) - kept_of_inputs, down;
}

void ShapeEvaluator::AddOffsets(const PlanProblem& problem) {
  const Index length = grid_.lead + grid_.length();
  for (Part& part : parts_) {
    const NoiseEstimate& noise =
        problem.noise[static_cast<std::size_t>(part.output)];
    MatrixXd offset =
        MatrixXd::Constant(1, length * grid_.samples, noise.offset ? 1.0 : 0.0);
    WhitenRows(noise, offset);
    part.offset.resize(length);
    for (Index k = 0; k < length; ++k) {
      part.offset(k) = offset(0, k * grid_.samples);
    }
  }
}

absl::StatusOr<ShapeEvaluator::Steps> ShapeEvaluator::StepsOf(
    const PlanProblem& problem, const ProcessModel& plant,
    const std::vector<PlanRow>& rows, const PlanOptions& options) const {
  const Index samples = static_cast<Index>(grid_.length()) * grid_.samples;
  const Index all =
      rows.empty() ? p_ + m_ : parts_.back().first + parts_.back().count;
  Steps steps(static_cast<std::size_t>(p_));
  std::vector<absl::Status> status(steps.size());
  ParallelFor(p_, options.threads, [&](int q) {
    if (!options.movable.empty() && !options.movable[q]) return;
    MatrixXd set_points = MatrixXd::Zero(p_, samples);
    set_points.row(q).setConstant(grid_.scale(q));
    const absl::StatusOr<Record> record = problem.loop(plant, set_points);
    if (!record.ok()) {
      status[q] = record.status();
      return;
    }
    MatrixXd fine(all, samples);
    fine.topRows(p_) = record->outputs;
    fine.middleRows(p_, m_) = record->inputs;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      MatrixXd sensitivities = rows[r].Sensitivities(record->inputs);
      WhitenRows(problem.noise[static_cast<std::size_t>(parts_[r].output)],
                 sensitivities);
      fine.middleRows(parts_[r].first, parts_[r].count) = sensitivities;
    }
    steps[q].resize(all, grid_.length());
    for (Index k = 0; k < grid_.length(); ++k) {
      steps[q].col(k) = fine.col(k * grid_.samples);
    }
  });
  for (const absl::Status& of_step : status) MLE_RETURN_IF_ERROR(of_step);
  return steps;
}

MatrixXd ShapeEvaluator::Answer(const PlanShape& unrolled,
                                const Steps& steps) const {
  Index rows = 0;
  for (const MatrixXd& step : steps) rows = std::max(rows, step.rows());
  const Index length = unrolled.duration() + grid_.tail;
  MatrixXd answer = MatrixXd::Zero(rows, length);
  Index at = 0;
  for (Index s = 0; s <= unrolled.levels.cols(); ++s) {
    for (int q = 0; q < p_; ++q) {
      const double now = s < unrolled.levels.cols() ? unrolled.levels(q, s) : 0;
      const double move = now - (s > 0 ? unrolled.levels(q, s - 1) : 0.0);
      if (move == 0.0 || steps[q].size() == 0) continue;
      answer.rightCols(length - at) += move * steps[q].leftCols(length - at);
    }
    if (s < unrolled.levels.cols()) {
      at += unrolled.holds[static_cast<std::size_t>(s)];
    }
  }
  return answer;
}

std::vector<MatrixXd> ShapeEvaluator::Informations(
    const PlanShape& unrolled, const MatrixXd& expected) const {
  std::vector<MatrixXd> informations;
  for (std::size_t plant = 0; plant < steps_.size(); ++plant) {
    const MatrixXd other =
        plant == 0 ? MatrixXd() : Answer(unrolled, steps_[plant]);
    const MatrixXd& answer = plant == 0 ? expected : other;
    for (const Part& part : parts_) {
      const auto rows = answer.middleRows(part.first, part.count);
      const auto offset = part.offset.segment(grid_.lead, answer.cols());
      MatrixXd information = rows * rows.transpose();
      const double own =
          part.offset.head(grid_.lead + answer.cols()).squaredNorm();
      if (own > 0.0) {
        const VectorXd shared = rows * offset.transpose();
        information -= shared * shared.transpose() / own;
      }
      informations.push_back(grid_.samples * information);
    }
  }
  return informations;
}

ShapeEvaluator::Reach ShapeEvaluator::ReachOf(
    const std::vector<MatrixXd>& informations) const {
  Reach reach;
  for (const Asked& asked : asked_) {
    Variances& variances = reach.variances.emplace_back();
    for (std::size_t k = asked.part; k < informations.size();
         k += parts_.size()) {
      variances.push_back(
          VarianceOf(asked.root, informations[k], asked.open.place));
    }
    const double wanted = asked.open.question.error;
    reach.least_size = std::max(
        reach.least_size, demand_ * LeastSizeFor(variances, wanted * wanted));
  }
  return reach;
}

double ShapeEvaluator::Shortfall(const Reach& reach, double size) const {
  double most = 0.0;
  for (std::size_t a = 0; a < asked_.size(); ++a) {
    most =
        std::max(most, std::sqrt(MeanAt(reach.variances[a], size / demand_)) /
                           asked_[a].open.question.error);
  }
  return most;
}

ShapeEvaluator::Extremes ShapeEvaluator::ExtremesOf(
    const PlanShape& unrolled, const MatrixXd& expected) const {
  Extremes extremes;
  VectorXd high = expected.topRows(p_ + m_).rowwise().maxCoeff();
  VectorXd low = expected.topRows(p_ + m_).rowwise().minCoeff();
  for (const Steps& steps : limiting_) {
    const MatrixXd answer = Answer(unrolled, steps);
    high = high.cwiseMax(answer.rowwise().maxCoeff()).eval();
    low = low.cwiseMin(answer.rowwise().minCoeff()).eval();
  }
  extremes.high.resize(2 * p_ + m_);
  extremes.high << high,
      unrolled.levels.rowwise().maxCoeff().cwiseProduct(grid_.scale);
  extremes.low.resize(2 * p_ + m_);
  extremes.low << low,
      unrolled.levels.rowwise().minCoeff().cwiseProduct(grid_.scale);
  return extremes;
}

void ShapeEvaluator::Limit(const Extremes& extremes, double sign,
                           ShapeValue& value) const {
  const VectorXd high = sign > 0.0 ? extremes.high : -extremes.low;
  const VectorXd low = sign > 0.0 ? extremes.low : -extremes.high;
  ShapeValue limited;
  limited.size = kLargestSize;
  for (Index c = 0; c < high.size(); ++c) {
    const double up = high(c);
    const double down = -low(c);
    if (up > 0.0 && room_up_(c) < limited.size * up) {
      limited.size = std::max(room_up_(c), 0.0) / up;
      limited.channel = static_cast<int>(c);
      limited.upper = true;
    }
    if (down > 0.0 && room_down_(c) < limited.size * down) {
      limited.size = std::max(room_down_(c), 0.0) / down;
      limited.channel = static_cast<int>(c);
      limited.upper = false;
    }
  }
  if (limited.size <= std::abs(value.size)) return;
  value.size = sign * limited.size;
  value.channel = limited.channel;
  value.upper = limited.upper;
}

double ShapeEvaluator::CostOf(const Eigen::Ref<const MatrixXd>& outputs) const {
  double cost = 0.0;
  for (int i = 0; i < p_; ++i) {
    if (squared_price_(i) > 0.0) {
      cost += squared_price_(i) * outputs.row(i).squaredNorm();
    }
    if (!(absolute_price_(i) > 0.0)) continue;
    double more = 0.0;
    for (const double deviation : outputs.row(i)) {
      more += MoreAbsolute(deviation, deviations_(i));
    }
    cost += absolute_price_(i) * more;
  }
  return cost * grid_.step;
}

ShapeValue ShapeEvaluator::Evaluate(const PlanShape& shape) const {
  ShapeValue value;
  value.objective = kInfinity;
  if (shape.duration() > grid_.longest) return value;
  const PlanShape unrolled = shape.Unrolled();
  if (unrolled.levels.cols() == 0) return value;
  const MatrixXd answer = Answer(unrolled, steps_.front());
  const Reach reach = ReachOf(Informations(unrolled, answer));
  const Extremes extremes = ExtremesOf(unrolled, answer);
  const double least = reach.least_size;
  Limit(extremes, 1.0, value);
  Limit(extremes, -1.0, value);
  const double most = std::abs(value.size);
  value.reaches = least <= most;
  if (value.reaches) value.size = std::copysign(least, value.size);
  value.cost = CostOf(value.size * answer.topRows(p_));
  Index moves = (unrolled.levels.col(0).array() != 0.0).count();
  for (Index s = 1; s < unrolled.levels.cols(); ++s) {
    const VectorXd move = unrolled.levels.col(s) - unrolled.levels.col(s - 1);
    moves += (move.array() != 0.0).count();
  }
  value.objective = value.reaches
                        ? std::log(std::max(value.cost, 1e-300)) +
                              kPriceOfMove * static_cast<double>(moves) +
                              kPriceOfTime * shape.duration() / grid_.settling
                        : kOutOfReach + std::log(Shortfall(reach, most));
  return value;
}

}  // namespace mle
