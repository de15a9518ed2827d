#include "mle/plan/plan_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
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
constexpr double kPriceOfMove = 0.01;
constexpr double kPriceOfTime = 0.03;
// How much farther than expected an output or input goes, before plants have
// been drawn.
constexpr double kFirstSpread = 1.2;
constexpr double kLargestSize = 1e9;

// E|m + σ z| − E|σ z|.
double MoreAbsolute(double m, double deviation) {
  if (!(deviation > 0.0)) return std::abs(m);
  const double unit = m / deviation;
  return deviation * std::sqrt(2.0 / std::numbers::pi) *
             (std::exp(-0.5 * unit * unit) - 1.0) +
         m * std::erf(unit / std::numbers::sqrt2);
}

// The mean over plants.
double MeanAt(const Variances& variances, double size) {
  double sum = 0.0;
  for (const VarianceOfSize& variance : variances) sum += variance.At(size);
  return sum / static_cast<double>(variances.size());
}

double LeastSizeFor(const Variances& variances, double wanted) {
  if (MeanAt(variances, 0.0) <= wanted) return 0.0;
  if (MeanAt(variances, kLargestSize) > wanted) return kInfinity;
  double low = -30.0;
  double high = std::log(kLargestSize);
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (MeanAt(variances, std::exp(middle)) > wanted ? low : high) = middle;
  }
  return std::exp(high);
}

VarianceOfSize VarianceOf(const MatrixXd& root, const MatrixXd& information,
                          Index place) {
  const auto lower = root.triangularView<Eigen::Lower>();
  const MatrixXd half = lower.solve(information);
  const MatrixXd relative = lower.solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(
      0.5 * (relative + relative.transpose()));
  const VectorXd own = lower.solve(VectorXd::Unit(root.rows(), place)).eval();
  const VectorXd along = solver.eigenvectors().transpose() * own;
  return {along.cwiseAbs2(), solver.eigenvalues().cwiseMax(0.0)};
}

VectorXd Room(const VectorXd& limits, const VectorXd& from, double sign) {
  if (limits.size() == 0) return VectorXd::Constant(from.size(), kInfinity);
  return sign * (limits - from);
}

}  // namespace

double VarianceOfSize::At(double size) const {
  return (squares.array() / (1.0 + size * size * growth.array())).sum();
}

int PlanShape::duration() const {
  return std::accumulate(holds.begin(), holds.end(), 0);
}

PlanShape PlanShape::Tidy() const {
  PlanShape tidy;
  tidy.levels.resize(levels.rows(), levels.cols());
  Index kept = 0;
  Index last = levels.cols();
  while (last > 0 && levels.col(last - 1).isZero(0.0)) --last;
  for (Index s = 0; s < last; ++s) {
    const int hold = holds[static_cast<std::size_t>(s)];
    if (kept == 0 && levels.col(s).isZero(0.0)) continue;
    if (kept > 0 && tidy.levels.col(kept - 1) == levels.col(s)) {
      tidy.holds.back() += hold;
      continue;
    }
    tidy.levels.col(kept++) = levels.col(s);
    tidy.holds.push_back(hold);
  }
  tidy.levels.conservativeResize(levels.rows(), kept);
  return tidy;
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

MatrixXd SetPointsOf(const PlanShape& shape, double size,
                     const PlanGrid& grid) {
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
    MLE_RETURN_IF_ERROR(made.AddSteps(problem, plant, options));
  }
  return made;
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
  spread_up_ = VectorXd::Constant(p_ + m_, kFirstSpread);
  spread_down_ = spread_up_;
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

absl::Status ShapeEvaluator::AddSteps(const PlanProblem& problem,
                                      const ProcessModel& plant,
                                      const PlanOptions& options) {
  const Index samples = static_cast<Index>(grid_.length()) * grid_.samples;
  std::vector<PlanRow> rows;
  for (const Part& part : parts_) {
    MLE_ASSIGN_OR_RETURN(
        PlanRow row, PlanRow::Create(plant, part.output, problem.sample_time));
    rows.push_back(std::move(row));
  }
  const Index all = parts_.back().first + parts_.back().count;
  std::vector<MatrixXd>& steps = steps_.emplace_back(p_);
  std::vector<absl::Status> status(static_cast<std::size_t>(p_));
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
  return absl::OkStatus();
}

void ShapeEvaluator::SetSpread(const VectorXd& up, const VectorXd& down) {
  spread_up_ = up;
  spread_down_ = down;
}

MatrixXd ShapeEvaluator::Answer(const PlanShape& shape,
                                std::size_t plant) const {
  const std::vector<MatrixXd>& steps = steps_[plant];
  const Index rows = parts_.back().first + parts_.back().count;
  const Index length = shape.duration() + grid_.tail;
  MatrixXd answer = MatrixXd::Zero(rows, length);
  VectorXd before = VectorXd::Zero(p_);
  Index at = 0;
  for (std::size_t s = 0; s <= shape.holds.size(); ++s) {
    const bool back = s == shape.holds.size();
    const VectorXd level =
        back ? VectorXd(VectorXd::Zero(p_))
             : VectorXd(shape.levels.col(static_cast<Index>(s)));
    for (int q = 0; q < p_; ++q) {
      const double move = level(q) - before(q);
      if (move == 0.0 || steps[q].size() == 0) continue;
      answer.rightCols(length - at) += move * steps[q].leftCols(length - at);
    }
    if (back) break;
    before = level;
    at += shape.holds[s];
  }
  return answer;
}

std::vector<MatrixXd> ShapeEvaluator::Informations(
    const PlanShape& shape, const MatrixXd& expected) const {
  std::vector<MatrixXd> informations;
  for (std::size_t plant = 0; plant < steps_.size(); ++plant) {
    const MatrixXd other = plant == 0 ? MatrixXd() : Answer(shape, plant);
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

// The largest size with this sign, into `value` where it is larger.
void ShapeEvaluator::Limit(const PlanShape& shape, const MatrixXd& answer,
                           double sign, ShapeValue& value) const {
  VectorXd high(2 * p_ + m_);
  VectorXd low(2 * p_ + m_);
  high << answer.topRows(p_ + m_).rowwise().maxCoeff(),
      shape.levels.rowwise().maxCoeff().cwiseProduct(grid_.scale);
  low << answer.topRows(p_ + m_).rowwise().minCoeff(),
      shape.levels.rowwise().minCoeff().cwiseProduct(grid_.scale);
  if (sign < 0.0) {
    high.swap(low);
    high = -high;
    low = -low;
  }
  ShapeValue limited;
  limited.size = kLargestSize;
  for (Index c = 0; c < high.size(); ++c) {
    const bool spreads = c < p_ + m_;
    const double up = high(c) * (spreads ? spread_up_(c) : 1.0);
    const double down = -low(c) * (spreads ? spread_down_(c) : 1.0);
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
  const MatrixXd answer = Answer(shape, 0);
  const Reach reach = ReachOf(Informations(shape, answer));
  const double least = reach.least_size;
  Limit(shape, answer, 1.0, value);
  Limit(shape, answer, -1.0, value);
  const double most = std::abs(value.size);
  value.reaches = least <= most;
  if (value.reaches) value.size = std::copysign(least, value.size);
  value.cost = CostOf(value.size * answer.topRows(p_));
  Index moves = 0;
  for (Index s = 0; s < shape.levels.cols(); ++s) {
    const VectorXd move =
        s == 0 ? VectorXd(shape.levels.col(0))
               : VectorXd(shape.levels.col(s) - shape.levels.col(s - 1));
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
