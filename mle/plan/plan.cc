#include "mle/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/plan/plan_problem.h"
#include "mle/plan/plan_row.h"
#include "mle/plan/plan_search.h"
#include "mle/plan/plan_shape.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Searches with more and more plants that go beyond limits, until none does.
constexpr int kMostRounds = 12;
// The search begins anew in every so many rounds: shapes that suit many limits
// are far from those that suit few.
constexpr int kAnew = 3;
// Plants over which squared errors are averaged: what is expected, and some
// drawn.
constexpr std::size_t kPlants = 5;
constexpr double kNearEnough = 1.05;  // of the error wanted, at last
// Corrections of the size by the bound of the estimate itself.
constexpr int kMostCorrections = 4;
constexpr double kLargestCorrection = 2.0;
constexpr double kEnough = 1.005;  // of the error wanted

// Set points have three digits, of the largest move: away from zero, or `down`.
MatrixXd Rounded(const MatrixXd& levels, bool down) {
  MatrixXd rounded = levels;
  for (Index i = 0; i < levels.rows(); ++i) {
    const double largest = levels.row(i).cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) continue;
    const double digit = std::pow(10.0, std::floor(std::log10(largest)) - 2.0);
    for (double& level : rounded.row(i)) {
      const double digits = std::abs(level) / digit;
      level = std::copysign(
          digit * (down ? std::floor(digits + 0.01) : std::ceil(digits - 0.01)),
          level);
    }
  }
  return rounded;
}

class PlanMaker {
 public:
  PlanMaker(const PlanProblem& problem, const PlanOptions& options)
      : problem_(problem), options_(options) {}

  absl::StatusOr<Plan> Make();

 private:
  // Answers with the errors before; what is open.
  absl::StatusOr<std::vector<OpenQuestion>> Ask(
      const std::vector<PlanRow>& rows);
  // Sets the errors after a plan, root mean squares over plants_; the largest
  // over that wanted.
  absl::StatusOr<double> AnswerBy(const PlanShape& shape);
  // Those over which squared errors are averaged.
  absl::Status ChoosePlants(const std::vector<ProcessModel>& drawn);
  absl::StatusOr<Record> Expect(const PlanShape& shape) const;
  absl::StatusOr<PlanBand> Simulate(
      const PlanShape& shape, const std::vector<ProcessModel>& plants) const {
    return BandOf(problem_, plants, SetPointsOf(shape, 1.0, grid_),
                  options_.threads);
  }
  PlanShape Scaled(const PlanShape& shape, double size, bool down) const;
  // `shape` of a size that suffices, as the evaluator then demands.
  absl::StatusOr<PlanShape> Sized(const PlanShape& shape,
                                  ShapeEvaluator& evaluator);
  // The factor ≤ 1 of its size with which the plan keeps the limits in the
  // whole band, and the plants that go farthest beyond one.
  double Fit(const PlanBand& band, std::vector<int>& beyond) const;
  void Write(const ShapeEvaluator& evaluator, const PlanShape& shape,
             const Record& expected, const PlanBand& band);
  // Has the evaluator keep limits with these plants, and drops from those drawn
  // what the loop does not hold.
  absl::Status KeepLimits(const std::vector<int>& beyond,
                          std::vector<ProcessModel>& drawn,
                          ShapeEvaluator& evaluator);
  std::string Hindrance(const ShapeValue& value) const;

  const PlanProblem& problem_;
  const PlanOptions& options_;
  PlanGrid grid_;
  std::vector<ProcessModel> plants_;
  std::vector<MatrixXd> known_;  // p: I₀ by the windows
  Plan plan_;
};

absl::StatusOr<std::vector<OpenQuestion>> PlanMaker::Ask(
    const std::vector<PlanRow>& rows) {
  MLE_ASSIGN_OR_RETURN(known_, InformationOfWindows(problem_, problem_.windows,
                                                    rows, options_.threads));
  std::vector<OpenQuestion> open;
  for (const PlanQuestion& question : problem_.questions) {
    const auto i = static_cast<std::size_t>(question.output);
    OpenQuestion asked{question, rows[i].PlaceOfGain(question.input),
                       known_[i]};
    if (question.alone) asked.information.setZero();
    const double before = ErrorBy(asked.information, asked.place);
    plan_.answers.push_back({question, before, before});
    if (before > question.error) open.push_back(std::move(asked));
  }
  return open;
}

absl::StatusOr<double> PlanMaker::AnswerBy(const PlanShape& shape) {
  const MatrixXd set_points = SetPointsOf(shape, 1.0, grid_);
  std::vector<double> variances(plan_.answers.size(), 0.0);
  double count = 0.0;
  for (std::size_t d = 0; d < plants_.size(); ++d) {
    const ProcessModel& plant = plants_[d];
    const absl::StatusOr<Record> expected = problem_.loop(plant, set_points);
    if (d > 0 && absl::IsFailedPrecondition(expected.status())) continue;
    MLE_RETURN_IF_ERROR(expected.status());
    ++count;
    MLE_ASSIGN_OR_RETURN(
        const std::vector<double> errors,
        ErrorsAfter(problem_, plant, *expected, known_, options_.threads));
    for (std::size_t a = 0; a < errors.size(); ++a) {
      variances[a] += errors[a] * errors[a];
    }
  }
  double most = 0.0;
  for (std::size_t a = 0; a < variances.size(); ++a) {
    PlanAnswer& answer = plan_.answers[a];
    answer.after = std::sqrt(variances[a] / count);
    most = std::max(most, answer.after / answer.question.error);
  }
  return most;
}

absl::StatusOr<Record> PlanMaker::Expect(const PlanShape& shape) const {
  return problem_.loop(problem_.plant, SetPointsOf(shape, 1.0, grid_));
}

PlanShape PlanMaker::Scaled(const PlanShape& shape, double size,
                            bool down) const {
  PlanShape scaled = shape;
  scaled.levels = grid_.scale.cwiseInverse().asDiagonal() *
                  Rounded(size * grid_.scale.asDiagonal() * shape.levels, down);
  return scaled.Unrolled();
}

absl::StatusOr<PlanShape> PlanMaker::Sized(const PlanShape& shape,
                                           ShapeEvaluator& evaluator) {
  const ShapeValue value = evaluator.Evaluate(shape);
  double size = value.size;
  for (int round = 1;; ++round) {
    PlanShape sized = Scaled(shape, size, !value.reaches);
    MLE_ASSIGN_OR_RETURN(const double most, AnswerBy(sized));
    if (!value.reaches || most <= kEnough || round == kMostCorrections) {
      if (value.size != 0.0) {
        evaluator.SetDemand(evaluator.demand() * size / value.size);
      }
      return sized;
    }
    size *= std::min(most, kLargestCorrection);
  }
}

double PlanMaker::Fit(const PlanBand& band, std::vector<int>& beyond) const {
  const Index p = problem_.plant.num_outputs();
  const Index m = problem_.plant.num_inputs();
  double fit = 1.0;
  for (Index c = 0; c < p + m; ++c) {
    const bool output = c < p;
    const Index i = output ? c : c - p;
    const double kept =
        options_.deviations *
        (output ? problem_.output_deviations(i) : problem_.input_deviations(i));
    const double at = output ? problem_.set_points(i) : problem_.inputs(i);
    const auto check = [&](const VectorXd& limits, double sign, double farthest,
                           int plant) {
      if (limits.size() == 0 || !std::isfinite(limits(i))) return;
      const double room = sign * (limits(i) - at) - kept;
      if (farthest <= room) return;
      fit = std::min(fit, room / farthest);
      beyond.push_back(plant);
    };
    check(output ? options_.max_output : options_.max_input, 1.0,
          band.high.row(c).maxCoeff(), band.highest[c]);
    check(output ? options_.min_output : options_.min_input, -1.0,
          -band.low.row(c).minCoeff(), band.lowest[c]);
  }
  std::sort(beyond.begin(), beyond.end());
  beyond.erase(std::unique(beyond.begin(), beyond.end()), beyond.end());
  return fit;
}

std::string PlanMaker::Hindrance(const ShapeValue& value) const {
  const ProcessModel& plant = problem_.plant;
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  if (value.channel < 0) {
    return "no change of the set points within the longest duration tells the "
           "inputs apart";
  }
  const char* const which = value.upper ? "upper" : "lower";
  if (value.channel < p || value.channel >= p + m) {
    const int i = value.channel < p ? value.channel : value.channel - p - m;
    return absl::StrCat("the ", which, " limit of ", plant.outputs()[i].name);
  }
  return absl::StrCat("the ", which, " limit of ",
                      plant.inputs()[value.channel - p].name);
}

void PlanMaker::Write(const ShapeEvaluator& evaluator, const PlanShape& shape,
                      const Record& expected, const PlanBand& band) {
  const Index p = problem_.plant.num_outputs();
  const Index m = problem_.plant.num_inputs();
  double time = 0.0;
  for (std::size_t s = 0; s < shape.holds.size(); ++s) {
    const VectorXd level =
        shape.levels.col(static_cast<Index>(s)).cwiseProduct(grid_.scale);
    plan_.steps.push_back({time, problem_.set_points + level});
    time += shape.holds[s] * grid_.step;
  }
  plan_.steps.push_back({time, problem_.set_points});
  plan_.duration = time;
  MatrixXd coarse(p, expected.outputs.cols() / grid_.samples);
  for (Index k = 0; k < coarse.cols(); ++k) {
    coarse.col(k) = expected.outputs.col(k * grid_.samples);
  }
  plan_.cost = evaluator.CostOf(coarse);
  plan_.expected = expected;
  plan_.expected.start_time = 0.0;
  plan_.expected.sample_time = problem_.sample_time;
  plan_.expected.set_points = SetPointsOf(shape, 1.0, grid_);
  plan_.expected.set_points.colwise() += problem_.set_points;
  plan_.expected.outputs.colwise() += problem_.set_points;
  plan_.expected.inputs.colwise() += problem_.inputs;
  const auto widened = [&](const MatrixXd& extremes, double sign, Index first,
                           const VectorXd& at, const VectorXd& deviations) {
    MatrixXd rows = extremes.middleRows(first, at.size());
    rows.colwise() += at + sign * options_.deviations * deviations;
    return rows;
  };
  plan_.low_outputs = widened(band.low, -1.0, 0, problem_.set_points,
                              problem_.output_deviations);
  plan_.high_outputs = widened(band.high, 1.0, 0, problem_.set_points,
                               problem_.output_deviations);
  plan_.low_inputs = widened(band.low.bottomRows(m), -1.0, 0, problem_.inputs,
                             problem_.input_deviations);
  plan_.high_inputs = widened(band.high.bottomRows(m), 1.0, 0, problem_.inputs,
                              problem_.input_deviations);
  plan_.left_out += band.left_out;
}

absl::Status PlanMaker::ChoosePlants(const std::vector<ProcessModel>& drawn) {
  MatrixXd set_points =
      MatrixXd::Zero(problem_.plant.num_outputs(),
                     static_cast<Index>(grid_.length()) * grid_.samples);
  set_points.leftCols(static_cast<Index>(grid_.settling) * grid_.samples)
      .colwise() = grid_.scale;
  plants_ = {problem_.plant};
  for (const ProcessModel& plant : drawn) {
    if (plants_.size() == kPlants) break;
    const absl::Status status = problem_.loop(plant, set_points).status();
    if (status.ok()) plants_.push_back(plant);
    if (!status.ok() && !absl::IsFailedPrecondition(status)) return status;
  }
  return absl::OkStatus();
}

absl::Status PlanMaker::KeepLimits(const std::vector<int>& beyond,
                                   std::vector<ProcessModel>& drawn,
                                   ShapeEvaluator& evaluator) {
  for (auto plant = beyond.rbegin(); plant != beyond.rend(); ++plant) {
    const absl::Status status =
        evaluator.KeepLimitsOf(problem_, drawn[*plant], options_);
    if (status.ok()) continue;
    if (!absl::IsFailedPrecondition(status)) return status;
    // The loop holds it no longer than a plan.
    drawn.erase(drawn.begin() + *plant);
    ++plan_.left_out;
  }
  return absl::OkStatus();
}

absl::StatusOr<Plan> PlanMaker::Make() {
  MLE_RETURN_IF_ERROR(CheckProblem(problem_, options_));
  MLE_ASSIGN_OR_RETURN(const std::vector<PlanRow> rows,
                       RowsOf(problem_.plant, problem_.sample_time));
  MLE_ASSIGN_OR_RETURN(std::vector<OpenQuestion> open, Ask(rows));
  if (open.empty()) return std::move(plan_);
  grid_ = MakePlanGrid(problem_, options_);
  MLE_ASSIGN_OR_RETURN(std::vector<ProcessModel> drawn,
                       DrawPlants(problem_, options_));
  MLE_RETURN_IF_ERROR(ChoosePlants(drawn));
  MLE_ASSIGN_OR_RETURN(ShapeEvaluator evaluator,
                       ShapeEvaluator::Create(problem_, options_, grid_,
                                              plants_, std::move(open)));
  const ShapeBounds bounds = MakeShapeBounds(problem_, options_, grid_);
  PlanShape shape = FindShape(evaluator, bounds);
  bool anew = true;
  for (int round = 1;; ++round) {
    MLE_ASSIGN_OR_RETURN(PlanShape sized, Sized(shape, evaluator));
    MLE_ASSIGN_OR_RETURN(Record expected, Expect(sized));
    MLE_ASSIGN_OR_RETURN(PlanBand band, Simulate(sized, drawn));
    std::vector<int> beyond;
    const double fit = Fit(band, beyond);
    const bool stuck = !anew && !evaluator.Evaluate(shape).reaches;
    if ((fit < 1.0 || stuck) && round < kMostRounds) {
      MLE_RETURN_IF_ERROR(KeepLimits(beyond, drawn, evaluator));
      anew = fit >= 1.0 || round % kAnew == 0;
      shape = anew ? FindShape(evaluator, bounds)
                   : RefineShape(evaluator, bounds, std::move(shape));
      continue;
    }
    if (fit < 1.0) {
      sized = Scaled(sized, fit, /*down=*/true);
      MLE_ASSIGN_OR_RETURN(expected, Expect(sized));
      MLE_ASSIGN_OR_RETURN(band, Simulate(sized, drawn));
    }
    MLE_ASSIGN_OR_RETURN(const double most, AnswerBy(sized));
    plan_.state =
        most <= kNearEnough ? Plan::State::kFound : Plan::State::kOutOfReach;
    if (plan_.state == Plan::State::kOutOfReach) {
      plan_.hindrance = Hindrance(evaluator.Evaluate(shape));
    }
    Write(evaluator, sized, expected, band);
    return std::move(plan_);
  }
}

}  // namespace

absl::StatusOr<Plan> FindPlan(const PlanProblem& problem,
                              const PlanOptions& options) {
  return PlanMaker(problem, options).Make();
}

}  // namespace mle
