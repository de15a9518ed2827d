// plan_benchmark EXECUTIONS ESTIMATES FIRST_SEED: what the plan of
// mle/plan/plan.h costs beside a test by generalised binary noise that tells as
// much, whether it keeps its limits, and whether it brings what it promises.
//
// Five published plants run under mle::control::Mpc, tuned by published rules.
// Outputs are in units of their white noise; the largest gain of each row is
// 50. Each output has coloured noise of the same variance beside it. The
// records are one set-point change. Outputs may leave their set points by 15
// standard deviations of usual operation. What is asked is one gain, drawn
// among those that the record tells to more than 10 %, those of its row, or
// those of all rows, to 10 %; or the one where deviations cost in proportion
// to their size, with prices of 1/σ.
//
// Generalised binary noise (Tulleken, Automatica 26, 1990) switches between two
// levels, with a mean time between switches of a third of the settling time
// (Zhu, Multivariable System Identification for Process Control, 2001), at the
// largest size within the same limits, for as long as the questions need by the
// same bound of information. It moves the set points that the plan moves, all
// set points, or all inputs in open loop without control, where disturbances
// cost nothing more; two sequences are averaged. Costs are squared
// deviations in units of usual operation; errors are root mean squares over the
// plants that the plan averages them over.
//
// EXECUTIONS plants are drawn from what the record leaves open. Those that the
// loop does not hold are drawn anew. Each runs the plan once, with noise; a
// measured output or an input beyond its limit is a violation. From ESTIMATES
// of them the gains are estimated (FitAllElements()).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "Eigen/QR"
#include "benchmarks/tuned_plant.h"
#include "control/mpc.h"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/model/process_simulator.h"
#include "mle/plan/plan.h"
#include "mle/plan/plan_row.h"
#include "sim/closed_loop.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLargestGain = 50.0;
constexpr double kWanted = 0.1;
constexpr double kRoom = 10.0;  // of outputs, beside what is kept, in σ
constexpr int kUsual = 8000;    // samples of usual operation
constexpr int kSequences = 2;
constexpr double kLongest = 12.0;      // of a plan, in settling times
constexpr double kLongestTest = 64.0;  // of generalised binary noise
constexpr double kSpread = 1.2;        // of it, as a plan has at first

struct Site {
  benchmarks::TunedPlant plant;
  sim::PlantConditions conditions;
  NoiseEstimate noise;
  double settling = 0.0;

  sim::ClosedLoopOptions Loop(Index samples, std::uint64_t seed,
                              bool noisy) const {
    sim::ClosedLoopOptions options;
    options.sample_time = plant.sample_time;
    options.control_period = plant.tuning.control_period;
    options.duration = plant.sample_time * static_cast<double>(samples - 1);
    options.noise_variance = noisy ? noise.variance : 0.0;
    options.seed = seed;
    return options;
  }
};

Site MakeSite(const char* path) {
  ProcessModel model = benchmarks::ReadTunedPlant(path).model;
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
  Site site{.plant = benchmarks::TunePlant(std::move(model))};
  site.settling = SettlingTime(site.plant.model);
  const double lag = site.plant.lag * site.plant.sample_time;
  site.noise.variance = 1.0;
  site.noise.colour_pole = std::exp(-site.plant.sample_time / lag);
  site.noise.colour_ratio =
      1.0 - site.noise.colour_pole * site.noise.colour_pole;
  site.conditions.output_disturbance.coloured_variance =
      VectorXd::Ones(site.plant.model.num_outputs());
  site.conditions.output_disturbance.coloured_time_constant = lag;
  return site;
}

sim::SetPointProfile ProfileOf(const MatrixXd& set_points, double sample_time) {
  sim::SetPointProfile profile;
  for (Index k = 0; k < set_points.cols(); ++k) {
    for (Index i = 0; i < set_points.rows(); ++i) {
      const double before = k == 0 ? 0.0 : set_points(i, k - 1);
      if (set_points(i, k) == before) continue;
      profile.steps.push_back({static_cast<int>(i),
                               sample_time * static_cast<double>(k),
                               set_points(i, k)});
    }
  }
  return profile;
}

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
      ProfileOf(set_points, site.plant.sample_time),
      site.Loop(set_points.cols(), seed, noisy),
      noisy ? site.conditions : sim::PlantConditions());
  if (!record.ok() || noisy) return record;
  if (!ComesToRest(*record)) {
    return absl::FailedPreconditionError("the loop does not settle");
  }
  return record;
}

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

// Plants over which squared errors are averaged.
constexpr std::size_t kPlants = 5;

struct Study {
  Site site;
  control::Mpc mpc;
  PlanProblem problem;
  PlanOptions options;
  MatrixXd window_set_points;
  // Over which squared errors are averaged: as expected, and as drawn.
  std::vector<ProcessModel> plants;
  std::vector<MatrixXd> known;  // p, by the window
};

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

// A pulse of all set points.
MatrixXd PulseOf(const Study& study) {
  const auto settled = static_cast<Index>(
      std::ceil(study.site.settling / study.problem.sample_time));
  MatrixXd pulse =
      MatrixXd::Zero(study.problem.output_deviations.size(), 3 * settled);
  pulse.leftCols(settled).colwise() = study.problem.output_deviations;
  return pulse;
}

std::vector<PlanRow> RowsOf(const Study& study, const ProcessModel& plant) {
  std::vector<PlanRow> rows;
  for (int i = 0; i < plant.num_outputs(); ++i) {
    absl::StatusOr<PlanRow> row =
        PlanRow::Create(plant, i, study.problem.sample_time);
    CHECK(row.ok()) << row.status();
    rows.push_back(*std::move(row));
  }
  return rows;
}

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
  absl::StatusOr<std::vector<MatrixXd>> known =
      InformationOfWindows(study.problem, study.problem.windows,
                           RowsOf(study, study.problem.plant), 1);
  CHECK(known.ok()) << known.status();
  study.known = *std::move(known);
}

struct Answers {
  double worst = 0.0;          // the largest error over that wanted
  std::vector<double> errors;  // of each question
  double cost = 0.0;
};

// Deviations of a test with what is before it.
Record WithLead(const Study& study, const Record& test) {
  const auto lead = static_cast<Index>(
      std::ceil(study.site.settling / study.problem.sample_time));
  Record record;
  record.sample_time = study.problem.sample_time;
  record.outputs =
      MatrixXd::Zero(test.outputs.rows(), lead + test.outputs.cols());
  record.inputs = MatrixXd::Zero(test.inputs.rows(), record.outputs.cols());
  record.outputs.rightCols(test.outputs.cols()) = test.outputs;
  record.inputs.rightCols(test.inputs.cols()) = test.inputs;
  return record;
}

// E|m + σ z| − E|σ z| in units of σ.
double MoreAbsolute(double unit) {
  return std::sqrt(2.0 / std::numbers::pi) *
             (std::exp(-0.5 * unit * unit) - 1.0) +
         unit * std::erf(unit / std::numbers::sqrt2);
}

double CostOf(const Study& study, const MatrixXd& outputs) {
  const MatrixXd units =
      study.problem.output_deviations.cwiseInverse().asDiagonal() * outputs;
  return study.problem.sample_time * (study.options.absolute_price.size() > 0
                                          ? units.unaryExpr(&MoreAbsolute).sum()
                                          : units.squaredNorm());
}

// Of a test that runs as `test` says with each plant.
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
    PlanProblem problem = study.problem;
    problem.plant = plant;
    const std::vector<PlanRow> rows = RowsOf(study, plant);
    const absl::StatusOr<std::vector<MatrixXd>> informations =
        InformationOfWindows(problem, {WithLead(study, *record)}, rows, 1);
    CHECK(informations.ok()) << informations.status();
    for (std::size_t q = 0; q < answers.errors.size(); ++q) {
      const PlanQuestion& asked = problem.questions[q];
      const double error =
          ErrorBy((*informations)[asked.output] + study.known[asked.output],
                  rows[asked.output].Place(asked.input, asked.parameter));
      answers.errors[q] += error * error;
    }
  }
  for (std::size_t q = 0; q < answers.errors.size(); ++q) {
    answers.errors[q] = std::sqrt(answers.errors[q] / count);
    answers.worst = std::max(
        answers.worst, answers.errors[q] / study.problem.questions[q].error);
  }
  return answers;
}

enum Moved { kSamePoints, kAllPoints, kAllInputs };

// Rows that switch at random between the two levels.
MatrixXd BinaryNoise(const VectorXd& sizes, Index samples, Index period,
                     double mean_time, double sample_time, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform;
  const double switches =
      std::min(1.0, static_cast<double>(period) * sample_time / mean_time);
  MatrixXd noise = MatrixXd::Zero(sizes.size(), samples);
  for (Index i = 0; i < sizes.size(); ++i) {
    double level = uniform(engine) < 0.5 ? sizes(i) : -sizes(i);
    for (Index k = 0; k < samples; ++k) {
      if (k > 0 && k % period == 0 && uniform(engine) < switches) {
        level = -level;
      }
      noise(i, k) = level;
    }
  }
  return noise;
}

absl::StatusOr<Record> OpenLoop(const ProcessModel& plant,
                                const MatrixXd& inputs, double sample_time) {
  Record record;
  record.sample_time = sample_time;
  record.inputs = inputs;
  MatrixXd from_rest(inputs.rows(), inputs.cols() + 1);
  from_rest << MatrixXd::Zero(inputs.rows(), 1), inputs;
  absl::StatusOr<MatrixXd> outputs =
      SimulateResponse(plant, sample_time, from_rest);
  if (!outputs.ok()) return outputs.status();
  record.outputs = outputs->rightCols(inputs.cols());
  return record;
}

// Cost of a test by generalised binary noise; infinite where it does not tell
// within kLongestTest.
struct Test {
  double cost = kInfinity;
  double duration = 0.0;
  MatrixXd signal;             // of the set points or inputs
  std::vector<double> errors;  // of each question
};

Test TestOf(const Study& study, Moved moved, const std::vector<bool>& same,
            std::uint64_t seed) {
  const PlanProblem& problem = study.problem;
  const ProcessModel& model = problem.plant;
  const double settling = study.site.settling;
  const auto settled =
      static_cast<Index>(std::ceil(settling / problem.sample_time));
  VectorXd sizes = problem.output_deviations;
  if (moved == kAllInputs) {
    sizes = (problem.output_deviations.cwiseInverse().asDiagonal() *
             StaticGains(model))
                .cwiseAbs()
                .colwise()
                .maxCoeff()
                .cwiseInverse()
                .transpose();
  } else if (moved == kSamePoints) {
    for (Index i = 0; i < sizes.size(); ++i) sizes(i) *= same[i] ? 1.0 : 0.0;
  }
  const MatrixXd longest =
      BinaryNoise(sizes, static_cast<Index>(kLongestTest) * settled,
                  study.site.plant.samples_of_period, settling / 3.0,
                  problem.sample_time, seed);
  // Of `samples`, then back, until all has settled.
  const auto signal_of = [&](Index samples, double size) {
    MatrixXd signal = MatrixXd::Zero(sizes.size(), samples + 2 * settled);
    signal.leftCols(samples) = size * longest.leftCols(samples);
    return signal;
  };
  const auto run = [&](const ProcessModel& plant, const MatrixXd& signal) {
    if (moved != kAllInputs) return problem.loop(plant, signal);
    return OpenLoop(plant, signal, problem.sample_time);
  };
  const auto answers_of = [&](const MatrixXd& signal) {
    return AnswersOf(
        study, [&](const ProcessModel& plant) { return run(plant, signal); });
  };
  const absl::StatusOr<Record> unit =
      run(model, signal_of(longest.cols(), 1.0));
  CHECK(unit.ok()) << unit.status();
  const auto room = [&](const MatrixXd& moves, const VectorXd& limit,
                        const VectorXd& deviations) {
    const VectorXd left = limit - study.options.deviations * deviations;
    return (left.array() /
            (kSpread * moves.cwiseAbs().rowwise().maxCoeff().array()).max(1e-9))
        .minCoeff();
  };
  const double size = std::min(
      room(unit->outputs, study.options.max_output, problem.output_deviations),
      room(unit->inputs, study.options.max_input, problem.input_deviations));
  Test test;
  const auto suffices = [&](Index samples) {
    return answers_of(signal_of(samples, size)).worst <= 1.0;
  };
  Index little = 0;
  Index enough = 2 * settled;
  while (!suffices(enough)) {
    if (enough == longest.cols()) return test;
    little = enough;
    enough = std::min(2 * enough, longest.cols());
  }
  while (enough - little > enough / 16 + 1) {
    const Index middle = (little + enough) / 2;
    (suffices(middle) ? enough : little) = middle;
  }
  test.signal = signal_of(enough, size);
  const Answers answers = answers_of(test.signal);
  test.cost = answers.cost;
  test.errors = answers.errors;
  test.duration = static_cast<double>(enough) * problem.sample_time;
  return test;
}

struct Executed {
  int runs = 0;
  int violated = 0;
  int usual_violated = 0;  // as long without the plan
  int estimates = 0;
  std::vector<double> errors;  // of gains over those promised
};

bool Violates(const Record& record, Index first, const PlanOptions& options) {
  const auto beyond = [&](const MatrixXd& rows, const VectorXd& limit) {
    return ((rows.rightCols(rows.cols() - first).cwiseAbs().colwise() - limit)
                .array() > 0.0)
        .any();
  };
  return beyond(record.outputs, options.max_output) ||
         beyond(record.inputs, options.max_input);
}

// `errors` are those promised for each question.
void Estimate(const Study& study, const std::vector<double>& errors,
              const ProcessModel& truth, const std::vector<Record>& records,
              Executed& executed) {
  const ProcessModel& model = study.problem.plant;
  const absl::StatusOr<OutputErrorFit> fit =
      FitAllElements(model, records, {.threads = 1});
  if (!fit.ok()) return;
  ++executed.estimates;
  for (std::size_t q = 0; q < errors.size(); ++q) {
    const PlanQuestion& asked = study.problem.questions[q];
    const double error =
        (fit->element(asked.output, asked.input).gain.value -
         truth.element(asked.output, asked.input).StaticGain()) /
        truth.element(asked.output, asked.input).StaticGain();
    executed.errors.push_back(std::abs(error) / errors[q]);
  }
}

// Of set points (deviations).
Executed Execute(const Study& study, const MatrixXd& moved,
                 const std::vector<double>& errors, int executions,
                 int estimates) {
  PlanOptions drawing = study.options;
  drawing.seed += 7'919;
  drawing.draws = 2 * executions;
  const absl::StatusOr<std::vector<ProcessModel>> plants =
      DrawPlants(study.problem, drawing);
  CHECK(plants.ok()) << plants.status();
  const auto lead = static_cast<Index>(
      std::ceil(study.site.settling / study.problem.sample_time));
  MatrixXd set_points = MatrixXd::Zero(moved.rows(), lead + moved.cols());
  set_points.rightCols(moved.cols()) = moved;
  Executed executed;
  for (std::size_t d = 0; d < plants->size() && executed.runs < executions;
       ++d) {
    const ProcessModel& truth = (*plants)[d];
    if (!study.problem.loop(truth, set_points).ok()) continue;
    const std::uint64_t seed = study.options.seed * 100'003 + d;
    const auto run = [&](const MatrixXd& points, std::uint64_t of) {
      absl::StatusOr<Record> record =
          RunLoop(study.site, study.mpc, truth, points, of, true);
      CHECK(record.ok()) << record.status();
      return *std::move(record);
    };
    const Record record = run(set_points, seed);
    ++executed.runs;
    executed.violated += Violates(record, lead, study.options) ? 1 : 0;
    const Record usual = run(0.0 * set_points, seed);
    executed.usual_violated += Violates(usual, lead, study.options) ? 1 : 0;
    if (executed.estimates >= estimates) continue;
    Estimate(study, errors, truth,
             {run(study.window_set_points, seed + 50'000), record}, executed);
  }
  return executed;
}

enum Asked { kOneGain, kRowOfGains, kAllGains, kOneAtLinearPrice };
constexpr std::array<const char*, 4> kAskedNames = {"one", "row", "all",
                                                    "lin."};

std::vector<PlanQuestion> QuestionsOf(const Study& study, Asked asked,
                                      std::uint64_t seed) {
  const std::vector<PlanRow> rows = RowsOf(study, study.problem.plant);
  std::vector<PlanQuestion> all;
  std::vector<PlanQuestion> open;
  for (const auto& [i, j] : Pairs(study.problem.plant)) {
    const Index place = rows[i].Place(j, PlanParameter::kGain);
    if (place < 0) continue;
    all.push_back({.output = i, .input = j, .error = kWanted});
    if (ErrorBy(study.known[i], place) > kWanted) open.push_back(all.back());
  }
  CHECK(!open.empty());
  const PlanQuestion one = open[(seed * 2'654'435'761U >> 8U) % open.size()];
  if (asked == kOneGain || asked == kOneAtLinearPrice) return {one};
  if (asked == kRowOfGains) {
    std::erase_if(
        all, [&](const PlanQuestion& q) { return q.output != one.output; });
  }
  return all;
}

struct Row {
  std::string name;
  double cost = 0.0;
  double worst = 0.0;
  double duration = 0.0;
  bool found = false;
  std::array<double, 3> tests = {};  // mean cost of each kind
  std::array<double, 3> durations = {};
  Executed executed;
  Executed tested;  // by binary noise on the same set points
};

Row Run(const char* path, Asked asked, int executions, int estimates,
        std::uint64_t seed) {
  Study study = MakeStudy(path, seed);
  PlanProblem& problem = study.problem;
  if (asked == kOneAtLinearPrice) {
    study.options.absolute_price = problem.output_deviations.cwiseInverse();
  }
  ChoosePlants(study);
  problem.questions = QuestionsOf(study, asked, seed);
  const absl::StatusOr<Plan> plan = FindPlan(problem, study.options);
  CHECK(plan.ok()) << plan.status();
  Row row{.name = problem.plant.name()};
  row.found = plan->state == Plan::State::kFound;
  const Answers answers = AnswersOf(study, [&](const ProcessModel& plant) {
    return problem.loop(plant, plan->expected.set_points);
  });
  row.cost = answers.cost;
  row.worst = answers.worst;
  row.duration = plan->duration / study.site.settling;
  std::vector<bool> same(problem.plant.num_outputs(), false);
  for (const PlanStep& step : plan->steps) {
    for (std::size_t i = 0; i < same.size(); ++i) {
      same[i] = same[i] || step.set_points(static_cast<Index>(i)) != 0.0;
    }
  }
  for (const Moved moved : {kSamePoints, kAllPoints, kAllInputs}) {
    double cost = 0.0;
    double duration = 0.0;
    for (int s = 0; s < kSequences; ++s) {
      const Test one = TestOf(study, moved, same, seed * 31 + s);
      if (moved == kSamePoints && s == 0 && one.signal.size() > 0) {
        row.tested =
            Execute(study, one.signal, one.errors, estimates, estimates);
      }
      cost += one.cost / kSequences;
      duration += one.duration / kSequences / study.site.settling;
    }
    row.tests[moved] = cost;
    row.durations[moved] = duration;
  }
  row.executed = Execute(study, plan->expected.set_points, answers.errors,
                         executions, estimates);
  return row;
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(
      share * static_cast<double>(values.size() - 1))];
}

void Print(const std::vector<Row>& rows) {
  std::printf(
      "cost in squared deviations of usual operation × time; durations in "
      "settling times; errors over those wanted or promised\n"
      "%-28s %4s %9s %5s %5s  %-26s %-26s %-26s %s\n",
      "plant", "ask", "cost", "error", "time", "GBN, same set points",
      "GBN, all set points", "GBN, all inputs",
      "runs bad usual  errors (50, 90 %), of GBN");
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    std::printf("%-28s %4s %9.3g %5.2f %5.2f ", row.name.c_str(),
                kAskedNames[r % kAskedNames.size()], row.cost, row.worst,
                row.duration);
    for (std::size_t k = 0; k < row.tests.size(); ++k) {
      std::printf(" %9.3g × %-6.3f %6.2f ", row.tests[k],
                  row.cost / row.tests[k], row.durations[k]);
    }
    std::printf(
        " %4d %3d %5d  %.2f %.2f  %.2f %.2f%s\n", row.executed.runs,
        row.executed.violated, row.executed.usual_violated,
        Quantile(row.executed.errors, 0.5), Quantile(row.executed.errors, 0.9),
        Quantile(row.tested.errors, 0.5), Quantile(row.tested.errors, 0.9),
        row.found ? "" : "  out of reach");
  }
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s EXECUTIONS ESTIMATES FIRST_SEED\n",
                 argv[0]);
    return 2;
  }
  const int executions = std::atoi(argv[1]);
  const int estimates = std::atoi(argv[2]);
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[3]));
  const std::vector<const char*> plants = {
      MLE_CONFIG_DIR "/wood_berry.json", MLE_CONFIG_DIR "/splitter.json",
      MLE_PLANT_DIR "/vinante_luyben.json", MLE_PLANT_DIR "/wardle_wood.json",
      MLE_PLANT_DIR "/ogunnaike_ray.json"};
  const int kinds = static_cast<int>(mle::kAskedNames.size());
  std::vector<mle::Row> rows(plants.size() * mle::kAskedNames.size());
  mle::ParallelFor(static_cast<int>(rows.size()),
                   /*threads=*/0, [&](int r) {
                     rows[r] = mle::Run(
                         plants[r / kinds], static_cast<mle::Asked>(r % kinds),
                         executions, estimates,
                         first + static_cast<std::uint64_t>(r / kinds));
                   });
  mle::Print(rows);
  return 0;
}
