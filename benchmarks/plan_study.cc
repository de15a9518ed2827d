#include "benchmarks/plan_study.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "glog/logging.h"
#include "mle/plan/plan_row.h"
#include "mle/plan/plan_shape.h"
#include "sim/set_point_profile.h"

namespace mle::benchmarks {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Plants over which squared errors are averaged.
constexpr std::size_t kPlants = 5;
constexpr double kLargestGain = 50.0;
constexpr double kRoom = 10.0;     // of outputs, beside what is kept, in σ
constexpr int kUsual = 8000;       // samples of usual operation
constexpr double kLongest = 12.0;  // of a plan, in settling times

Site MakeSite(const char* path) {
  ProcessModel model = ReadTunedPlant(path).model;
  for (int i = 0; i < model.num_outputs(); ++i) {
    const double largest = StaticGains(model).row(i).cwiseAbs().maxCoeff();
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      std::vector<double> numerator = element.numerator();
      for (double& c : numerator) c *= kLargestGain / largest;
      model.element(i, j) = TransferFunction(
          std::move(numerator), element.denominator(), element.delay());
    }
  }
  Site site{.plant = TunePlant(std::move(model))};
  site.settling = SettlingTime(site.plant.model);
  const double lag = site.plant.lag * site.plant.sample_time;
  site.noise.variance = 1.0;
  site.noise.ar_pole = std::exp(-site.plant.sample_time / lag);
  site.noise.ar_ratio = 1.0 - site.noise.ar_pole * site.noise.ar_pole;
  site.conditions.output_disturbance.coloured_variance =
      VectorXd::Ones(site.plant.model.num_outputs());
  site.conditions.output_disturbance.coloured_time_constant = lag;
  return site;
}

}  // namespace

absl::StatusOr<Record> RunLoop(const Site& site, const control::Mpc& tuned,
                               const ProcessModel& plant,
                               const MatrixXd& set_points, std::uint64_t seed,
                               bool noisy) {
  control::Mpc mpc = tuned;
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      plant,
      [&mpc](const auto& measured, const auto& wanted, auto next_inputs) {
        mpc.Step(measured, wanted, next_inputs);
      },
      sim::ProfileOf(set_points, site.plant.sample_time),
      site.Loop(set_points.cols(), seed, noisy),
      noisy ? site.conditions : sim::PlantConditions());
  if (!record.ok() || noisy) return record;
  if (!ComesToRest(*record)) {
    return absl::FailedPreconditionError("the loop does not settle");
  }
  return record;
}

namespace {

VectorXd Deviations(const MatrixXd& rows) {
  const MatrixXd moved = rows.colwise() - rows.rowwise().mean();
  return (moved.rowwise().squaredNorm() / static_cast<double>(rows.cols()))
      .cwiseSqrt();
}

// A window with a step of one set point, without noise or with it.
MatrixXd WindowSetPoints(const Site& site, const VectorXd& deviations,
                         std::uint64_t seed) {
  const auto settled =
      static_cast<Index>(std::ceil(site.settling / site.plant.sample_time));
  const auto p = static_cast<std::uint64_t>(deviations.size());
  const auto output = static_cast<Index>(seed % p);
  MatrixXd set_points = MatrixXd::Zero(deviations.size(), 3 * settled);
  set_points.row(output)
      .tail(2 * settled)
      .setConstant(4.0 * deviations(output));
  return set_points;
}

}  // namespace

Study MakeStudy(const char* path, std::uint64_t seed) {
  const Site site = MakeSite(path);
  const ProcessModel& model = site.plant.model;
  absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(site.plant.prediction, site.plant.tuning);
  CHECK(mpc.ok()) << mpc.status();
  Study study{site, *mpc, {}, {}, {}, {}, {}};
  const int p = model.num_outputs();
  const absl::StatusOr<Record> usual =
      RunLoop(site, *mpc, model, MatrixXd::Zero(p, kUsual), seed, true);
  CHECK(usual.ok()) << usual.status();
  PlanProblem& problem = study.problem;
  problem.plant = model;
  problem.sample_time = site.plant.sample_time;
  problem.noise.assign(p, site.noise);
  problem.set_points = VectorXd::Zero(p);
  problem.inputs = VectorXd::Zero(model.num_inputs());
  problem.output_deviations = Deviations(usual->outputs);
  problem.input_deviations = Deviations(usual->inputs);
  problem.loop = [site, tuned = *mpc](const ProcessModel& plant,
                                      const MatrixXd& set_points) {
    return RunLoop(site, tuned, plant, set_points, 1, false);
  };
  study.window_set_points =
      WindowSetPoints(site, problem.output_deviations, seed);
  const absl::StatusOr<Record> window =
      problem.loop(model, study.window_set_points);
  CHECK(window.ok()) << window.status();
  problem.windows = {*window};
  PlanOptions& options = study.options;
  options.longest = kLongest * site.settling;
  options.grid = site.plant.tuning.control_period;
  options.seed = seed;
  options.threads = 1;
  options.max_output = (options.deviations + kRoom) * problem.output_deviations;
  options.min_output = -options.max_output;
  const MatrixXd inverse =
      StaticGains(model).completeOrthogonalDecomposition().pseudoInverse();
  options.max_input = options.deviations * problem.input_deviations +
                      inverse.cwiseAbs() * (0.7 * kRoom / std::sqrt(p)) *
                          problem.output_deviations;
  options.min_input = -options.max_input;
  return study;
}

namespace {

// A pulse of all set points.
MatrixXd PulseOf(const Study& study) {
  const auto settled = static_cast<Index>(
      std::ceil(study.site.settling / study.problem.sample_time));
  MatrixXd pulse =
      MatrixXd::Zero(study.problem.output_deviations.size(), 3 * settled);
  pulse.leftCols(settled).colwise() = study.problem.output_deviations;
  return pulse;
}

}  // namespace

// The plants that the plan averages errors over, and what the window tells.
void ChoosePlants(Study& study) {
  const absl::StatusOr<std::vector<ProcessModel>> drawn =
      DrawPlants(study.problem, study.options);
  CHECK(drawn.ok()) << drawn.status();
  study.plants = {study.problem.plant};
  for (const ProcessModel& plant : *drawn) {
    if (study.plants.size() == kPlants) break;
    if (study.problem.loop(plant, PulseOf(study)).ok()) {
      study.plants.push_back(plant);
    }
  }
  const absl::StatusOr<std::vector<PlanRow>> rows =
      RowsOf(study.problem.plant, study.problem.sample_time);
  CHECK(rows.ok()) << rows.status();
  absl::StatusOr<std::vector<MatrixXd>> known =
      InformationOfWindows(study.problem, study.problem.windows, *rows, 1);
  CHECK(known.ok()) << known.status();
  study.known = *std::move(known);
}

namespace {

double CostOf(const Study& study, const MatrixXd& outputs) {
  const MatrixXd units =
      study.problem.output_deviations.cwiseInverse().asDiagonal() * outputs;
  return study.problem.sample_time *
         (study.options.absolute_price.size() > 0
              ? units
                    .unaryExpr(
                        [](double unit) { return MoreAbsolute(unit, 1.0); })
                    .sum()
              : units.squaredNorm());
}

}  // namespace

Answers AnswersOf(
    const Study& study,
    const std::function<absl::StatusOr<Record>(const ProcessModel&)>& test) {
  Answers answers;
  answers.errors.resize(study.problem.questions.size());
  double count = 0.0;
  for (const ProcessModel& plant : study.plants) {
    const absl::StatusOr<Record> record = test(plant);
    if (!record.ok()) continue;
    if (count == 0.0) answers.cost = CostOf(study, record->outputs);
    ++count;
    const absl::StatusOr<std::vector<double>> errors =
        ErrorsAfter(study.problem, plant, *record, study.known, 1);
    CHECK(errors.ok()) << errors.status();
    for (std::size_t q = 0; q < answers.errors.size(); ++q) {
      answers.errors[q] += (*errors)[q] * (*errors)[q];
    }
  }
  for (std::size_t q = 0; q < answers.errors.size(); ++q) {
    answers.errors[q] = std::sqrt(answers.errors[q] / count);
    answers.worst = std::max(
        answers.worst, answers.errors[q] / study.problem.questions[q].error);
  }
  return answers;
}

}  // namespace mle::benchmarks
