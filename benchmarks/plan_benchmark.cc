// plan_benchmark EXECUTIONS ESTIMATES FIRST_SEED PLANTS: what the plan of
// mle/plan/plan.h costs beside a test by generalised binary noise that tells as
// much, whether it keeps its limits, and whether it brings what it promises.
//
// PLANTS of five published plants run under mle::control::Mpc, tuned by
// published rules. Outputs are in units of their white noise; the largest gain
// of each row is
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
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "benchmarks/plan_study.h"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/model/process_simulator.h"
#include "mle/plan/plan.h"
#include "mle/plan/plan_row.h"

namespace mle {
namespace {

using benchmarks::Answers;
using benchmarks::RunLoop;
using benchmarks::Study;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kWanted = 0.1;
constexpr int kSequences = 2;
constexpr double kLongestTest = 64.0;  // of generalised binary noise
constexpr double kSpread = 1.2;        // of it, as a plan has at first

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

// How far each set point or input moves, beside the others.
VectorXd SizesOf(const PlanProblem& problem, Moved moved,
                 const std::vector<bool>& same) {
  VectorXd sizes = problem.output_deviations;
  if (moved == kSamePoints) {
    for (Index i = 0; i < sizes.size(); ++i) sizes(i) *= same[i] ? 1.0 : 0.0;
  }
  if (moved != kAllInputs) return sizes;
  return (problem.output_deviations.cwiseInverse().asDiagonal() *
          StaticGains(problem.plant))
      .cwiseAbs()
      .colwise()
      .maxCoeff()
      .cwiseInverse()
      .transpose();
}

// The size within the limits of a test that runs as `unit` at size 1.
double LargestSize(const Study& study, const Record& unit) {
  const PlanProblem& problem = study.problem;
  const auto room = [&](const MatrixXd& moves, const VectorXd& limit,
                        const VectorXd& deviations) {
    const VectorXd left = limit - study.options.deviations * deviations;
    return (left.array() /
            (kSpread * moves.cwiseAbs().rowwise().maxCoeff().array()).max(1e-9))
        .minCoeff();
  };
  return std::min(
      room(unit.outputs, study.options.max_output, problem.output_deviations),
      room(unit.inputs, study.options.max_input, problem.input_deviations));
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
  const VectorXd sizes = SizesOf(problem, moved, same);
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
  const double size = LargestSize(study, *unit);
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
  const absl::StatusOr<std::vector<PlanRow>> rows =
      RowsOf(study.problem.plant, study.problem.sample_time);
  CHECK(rows.ok()) << rows.status();
  std::vector<PlanQuestion> all;
  std::vector<PlanQuestion> open;
  for (const auto& [i, j] : Pairs(study.problem.plant)) {
    const Index place = (*rows)[i].PlaceOfGain(j);
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
  Study study = benchmarks::MakeStudy(path, seed);
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
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s EXECUTIONS ESTIMATES FIRST_SEED PLANTS\n",
                 argv[0]);
    return 2;
  }
  const int executions = std::atoi(argv[1]);
  const int estimates = std::atoi(argv[2]);
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[3]));
  std::vector<const char*> plants = {
      MLE_CONFIG_DIR "/wood_berry.json", MLE_CONFIG_DIR "/splitter.json",
      MLE_PLANT_DIR "/vinante_luyben.json", MLE_PLANT_DIR "/wardle_wood.json",
      MLE_PLANT_DIR "/ogunnaike_ray.json"};
  plants.resize(std::clamp<std::size_t>(std::strtoul(argv[4], nullptr, 10), 1,
                                        plants.size()));
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
