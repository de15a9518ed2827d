#include "mle/plan/plan_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "mle/base/double_limits.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Times that a level is held, as shares of the model's settling time.
constexpr std::array<double, 6> kHolds = {0.05, 0.1, 0.2, 0.35, 0.6, 1.0};
constexpr std::array<int, 4> kRepeats = {1, 2, 4, 8};
constexpr std::array<double, 3> kRelativeSizes = {1.0, -1.0, 0.4};
constexpr std::array<double, 4> kSteps = {0.5, 0.25, 0.12, 0.06};
constexpr std::size_t kStarts = 5;  // that are extended and refined
constexpr int kMostPasses = 6;      // with each step
constexpr double kGain = 1e-3;      // ln of the cost that a change must save
constexpr double kWorth = 0.02;     // that further levels must
constexpr double kSmall = 0.08;     // of the largest level: tried without

const std::vector<std::vector<double>>& Patterns() {
  static const auto* const patterns = new std::vector<std::vector<double>>{
      {1.0}, {1.0, -1.0}, {1.0, -1.0, 1.0, -1.0}, {1.0, 2.0, 1.0}};
  return *patterns;
}

// A shape with its value.
struct ValuedShape {
  PlanShape shape;
  double objective = kInfinity;
};

class ShapeSearch {
 public:
  ShapeSearch(const ShapeEvaluator& evaluator, const ShapeBounds& bounds)
      : evaluator_(evaluator), bounds_(bounds) {}

  void Take(PlanShape shape) {
    best_.objective = evaluator_.Evaluate(shape).objective;
    best_.shape = std::move(shape);
  }
  // Of one of the directions.
  void TryPatterns(Index direction);
  void Extend();
  void Refine();
  void Prune();
  const ValuedShape& best() const { return best_; }

 private:
  // Takes it where it saves `gain`.
  bool Try(PlanShape shape, double gain);
  std::set<int> Holds() const;
  bool RefineRepeats();
  bool RefineHolds(double step);
  bool RefineLevels(double step);
  double Largest() const { return best_.shape.levels.cwiseAbs().maxCoeff(); }

  const ShapeEvaluator& evaluator_;
  const ShapeBounds& bounds_;
  ValuedShape best_;
};

bool ShapeSearch::Try(PlanShape shape, double gain) {
  const double objective = evaluator_.Evaluate(shape).objective;
  if (!(objective < best_.objective - gain)) return false;
  best_ = {std::move(shape), objective};
  return true;
}

std::set<int> ShapeSearch::Holds() const {
  std::set<int> holds;
  for (const double share : kHolds) {
    holds.insert(std::max(
        static_cast<int>(std::lround(share * evaluator_.grid().settling)),
        bounds_.shortest_hold));
  }
  return holds;
}

PlanShape Append(const PlanShape& shape, const VectorXd& direction,
                 const std::vector<double>& pattern, int hold, double size) {
  PlanShape longer = shape;
  const Index before = shape.levels.cols();
  longer.levels.conservativeResize(direction.size(),
                                   before + std::ssize(pattern));
  for (std::size_t s = 0; s < pattern.size(); ++s) {
    longer.levels.col(before + static_cast<Index>(s)) =
        size * pattern[s] * direction;
    longer.holds.push_back(hold);
  }
  return longer;
}

void ShapeSearch::TryPatterns(Index direction) {
  for (const std::vector<double>& pattern : Patterns()) {
    if (std::ssize(pattern) > bounds_.most_steps) continue;
    for (const int hold : Holds()) {
      PlanShape shape =
          Append({}, bounds_.directions.col(direction), pattern, hold, 1.0);
      for (const int repeats : kRepeats) {
        shape.repeats = repeats;
        if (shape.duration() > evaluator_.grid().longest) break;
        Try(shape, 0.0);
      }
    }
  }
  if (!best_.shape.holds.empty()) return;
  // Whatever is allowed at all.
  Take(Append({}, bounds_.directions.col(direction), {1.0},
              std::min(bounds_.shortest_hold, evaluator_.grid().longest), 1.0));
}

void ShapeSearch::Extend() {
  for (bool better = true; better;) {
    better = false;
    const ValuedShape from = best_;
    const double largest = Largest();
    const Index left = bounds_.most_steps - from.shape.levels.cols();
    for (Index d = 0; d < bounds_.directions.cols(); ++d) {
      const VectorXd direction =
          bounds_.directions.col(d) /
          bounds_.directions.col(d).cwiseAbs().maxCoeff();
      for (std::size_t k = 0; k < 2; ++k) {
        if (std::ssize(Patterns()[k]) > left) continue;
        for (const int hold : Holds()) {
          for (const double relative : kRelativeSizes) {
            const PlanShape longer = Append(
                from.shape, direction, Patterns()[k], hold, relative * largest);
            const double gain =
                best_.objective == from.objective ? kWorth : kGain;
            better = Try(longer, gain) || better;
          }
        }
      }
    }
  }
}

bool ShapeSearch::RefineRepeats() {
  bool better = false;
  for (const int by : {1, -1}) {
    PlanShape changed = best_.shape;
    changed.repeats += by;
    if (changed.repeats < 1) continue;
    better = Try(std::move(changed), kGain) || better;
  }
  return better;
}

bool ShapeSearch::RefineHolds(double step) {
  bool better = false;
  for (std::size_t s = 0; s < best_.shape.holds.size(); ++s) {
    for (const double sign : {1.0, -1.0}) {
      PlanShape changed = best_.shape;
      const int by =
          std::max(static_cast<int>(std::lround(step * changed.holds[s])), 1);
      changed.holds[s] =
          std::max(changed.holds[s] + static_cast<int>(sign) * by,
                   bounds_.shortest_hold);
      if (changed.holds[s] == best_.shape.holds[s]) continue;
      better = Try(std::move(changed), kGain) || better;
    }
  }
  return better;
}

bool ShapeSearch::RefineLevels(double step) {
  bool better = false;
  for (Index s = 0; s < best_.shape.levels.cols(); ++s) {
    for (Index q = 0; q < best_.shape.levels.rows(); ++q) {
      if (!bounds_.movable[static_cast<std::size_t>(q)]) continue;
      for (const double sign : {1.0, -1.0}) {
        PlanShape changed = best_.shape;
        changed.levels(q, s) += sign * step * Largest();
        better = Try(std::move(changed), kGain) || better;
      }
    }
  }
  return better;
}

void ShapeSearch::Refine() {
  for (const double step : kSteps) {
    for (int pass = 0; pass < kMostPasses; ++pass) {
      const bool repeats = RefineRepeats();
      const bool holds = RefineHolds(step);
      const bool levels = RefineLevels(step);
      if (!repeats && !holds && !levels) break;
    }
  }
}

void ShapeSearch::Prune() {
  const double small = kSmall * Largest();
  for (Index s = 0; s < best_.shape.levels.cols(); ++s) {
    for (Index q = 0; q < best_.shape.levels.rows(); ++q) {
      const double level = best_.shape.levels(q, s);
      if (level == 0.0 || std::abs(level) > small) continue;
      PlanShape changed = best_.shape;
      changed.levels(q, s) = 0.0;
      Try(std::move(changed), -kWorth);
    }
  }
}

}  // namespace

ShapeBounds MakeShapeBounds(const PlanProblem& problem,
                            const PlanOptions& options, const PlanGrid& grid) {
  const ProcessModel& plant = problem.plant;
  const int p = plant.num_outputs();
  ShapeBounds bounds;
  bounds.movable =
      options.movable.empty() ? std::vector<bool>(p, true) : options.movable;
  const double settling = SettlingTime(plant);
  const double shortest =
      options.shortest_hold > 0.0 ? options.shortest_hold : settling / 20.0;
  bounds.shortest_hold =
      std::max(static_cast<int>(std::ceil(shortest / grid.step - 1e-9)), 1);
  bounds.most_steps = options.most_steps;
  const MatrixXd gains = StaticGains(plant);
  std::vector<VectorXd> directions;
  for (int q = 0; q < p; ++q) {
    if (bounds.movable[q]) directions.push_back(VectorXd::Unit(p, q));
  }
  for (int j = 0; j < plant.num_inputs(); ++j) {
    VectorXd column = gains.col(j).cwiseQuotient(grid.scale);
    for (int q = 0; q < p; ++q) column(q) = bounds.movable[q] ? column(q) : 0.0;
    const bool several = (column.array() != 0.0).count() > 1;
    if (plant.inputs()[j].role != InputRole::kManipulated || !several) continue;
    directions.push_back(column.normalized());
  }
  bounds.directions.resize(p, std::ssize(directions));
  for (std::size_t d = 0; d < directions.size(); ++d) {
    bounds.directions.col(static_cast<Index>(d)) = directions[d];
  }
  return bounds;
}

PlanShape RefineShape(const ShapeEvaluator& evaluator,
                      const ShapeBounds& bounds, PlanShape shape) {
  ShapeSearch search(evaluator, bounds);
  search.Take(std::move(shape));
  search.Refine();
  search.Prune();
  return search.best().shape;
}

PlanShape FindShape(const ShapeEvaluator& evaluator,
                    const ShapeBounds& bounds) {
  std::vector<ValuedShape> starts;
  for (Index d = 0; d < bounds.directions.cols(); ++d) {
    ShapeSearch search(evaluator, bounds);
    search.TryPatterns(d);
    starts.push_back(search.best());
  }
  const auto cheaper = [](const ValuedShape& a, const ValuedShape& b) {
    return a.objective < b.objective;
  };
  std::stable_sort(starts.begin(), starts.end(), cheaper);
  starts.resize(std::min(starts.size(), kStarts));
  for (ValuedShape& start : starts) {
    ShapeSearch search(evaluator, bounds);
    search.Take(start.shape);
    search.Extend();
    search.Refine();
    search.Prune();
    start = search.best();
  }
  return std::min_element(starts.begin(), starts.end(), cheaper)->shape;
}

}  // namespace mle
