// Structured correction over cases, seeds and noise, held against the
// Cramér–Rao limit; and how often the tests raise an alarm:
//
//   structured_study MODEL.json SEEDS FIRST VARIANCE DRIFT NAME:PLANT.json …
//
// DRIFT is the increment variance per sample of a random walk on every output.
// NAME:none has no mismatch. The records are those of the paper's experiment.
// After each row stand RMS error over its limit, and coverage in per cent, of
// every parameter: K, T and L of each element, row by row. --threads=N limits
// the threads.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "apps/reproduce/experiment.h"
#include "benchmarks/study_threads.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {
namespace {

constexpr int kKinds = 3;  // K, T, L

struct Run {
  double E_proposed = 0.0;
  double E_full = 0.0;  // all elements free
  double E_limit = 0.0;
  bool proposed = false;
  bool named_exactly = false;
  bool suspected = false;  // by the test of the initial model (TestAdequacy)
  bool wrong_structure = false;  // the same of the corrected model
  // Of every parameter, element by element: error, its standard error in the
  // limit and of the estimate, and whether the interval covers the truth.
  std::vector<double> error;
  std::vector<double> limit;
  std::vector<double> standard_error;
  std::vector<bool> covered;
};

double Value(const TransferFunction& element, int kind) {
  return kind == 0 ? element.StaticGain()
         : kind == 1
             ? ElementResponse::Create(element)->initial_values().time_scale
             : element.delay();
}

const ParameterEstimate& Parameter(const ElementEstimate& element, int kind) {
  return kind == 0   ? element.gain
         : kind == 1 ? element.time_scale
                     : element.delay;
}

void AddParameters(const ProcessModel& plant, const StructuredFit& full,
                   const StructuredFit& limit, Run& run) {
  for (int i = 0; i < plant.num_outputs(); ++i) {
    for (int j = 0; j < plant.num_inputs(); ++j) {
      if (full.element(i, j).state != ElementState::kFitted) continue;
      for (int kind = 0; kind < kKinds; ++kind) {
        const double truth = Value(plant.element(i, j), kind);
        const ParameterEstimate& p = Parameter(full.element(i, j), kind);
        run.error.push_back(p.value - truth);
        run.standard_error.push_back(p.standard_error);
        run.limit.push_back(
            Parameter(limit.element(i, j), kind).standard_error);
        run.covered.push_back(p.lower <= truth && truth <= p.upper);
      }
    }
  }
}

bool Changed(const TransferFunction& a, const TransferFunction& b) {
  for (int kind = 0; kind < kKinds; ++kind) {
    if (a.IsZero() != b.IsZero()) return true;
    if (!a.IsZero() && Value(a, kind) != Value(b, kind)) return true;
  }
  return false;
}

Run RunOne(const ProcessModel& initial, const ProcessModel& plant,
           std::uint64_t seed, double drift,
           const reproduce::ExperimentOptions& options) {
  const auto windows =
      reproduce::SimulateWindows(initial, plant, seed, options);
  CHECK(windows.ok()) << windows.status();
  const StructuredOptions structured;
  const auto fit = CorrectStructure(initial, *windows, structured);
  CHECK(fit.ok()) << fit.status();
  const std::vector<NoiseEstimate> noise(
      plant.num_outputs(),
      NoiseEstimate{.variance = options.noise_variance,
                    .ratio = drift / options.noise_variance,
                    .offset = drift > 0.0,
                    .log_ratio_deviation = 0.0});
  const auto limit = ComputeStructuredLimit(plant, *windows, noise, structured);
  CHECK(limit.ok()) << limit.status();
  const int samples = options.response_samples();
  const StepResponse truth =
      plant.ComputeStepResponse(options.sample_time, samples);
  const auto distance = [&](const ProcessModel& model) {
    return SquaredDistance(
        truth, model.ComputeStepResponse(options.sample_time, samples));
  };
  Run run;
  run.E_proposed = distance(fit->corrected.model);
  run.E_full = distance(fit->full.model);
  run.E_limit = limit->ExpectedSquaredDistance(options.sample_time, samples);
  run.proposed = fit->change_proposed;
  run.named_exactly = true;
  for (int i = 0; i < plant.num_outputs(); ++i) {
    for (int j = 0; j < plant.num_inputs(); ++j) {
      run.named_exactly =
          run.named_exactly && fit->aged(i, j) == Changed(initial.element(i, j),
                                                          plant.element(i, j));
    }
  }
  const auto before = TestAdequacy(initial, *windows, {}, {});
  const auto after =
      TestAdequacy(fit->corrected.model, *windows, fit->aged, {});
  CHECK(before.ok() && after.ok());
  run.suspected = !before->adequate;
  run.wrong_structure = !after->adequate;
  AddParameters(plant, fit->full, *limit, run);
  return run;
}

// Share of runs in which `what` holds, in percent.
template <typename What>
double Percent(const std::vector<Run>& runs, const What& what) {
  return 100.0 *
         static_cast<double>(std::count_if(runs.begin(), runs.end(), what)) /
         static_cast<double>(runs.size());
}

void PrintRow(const std::string& name, const std::string& variance,
              const std::string& drift, const std::vector<Run>& runs) {
  double proposed = 0.0, full = 0.0, limit = 0.0, covered = 0.0, count = 0.0;
  double worst_ratio = 0.0, largest = 0.0, gains = 0.0, gain_count = 0.0;
  double full_squares = 0.0;
  const double n = static_cast<double>(runs.size());
  const std::size_t parameters = runs.front().error.size();
  for (const Run& run : runs) {
    proposed += run.E_proposed / n;
    full += run.E_full / n;
    full_squares += run.E_full * run.E_full / n;
    limit += run.E_limit / n;
    for (std::size_t k = 0; k < run.error.size(); ++k) {
      covered += run.covered[k] ? 1.0 : 0.0;
      count += 1.0;
      if (k % kKinds == 0) {
        gains += run.covered[k] ? 1.0 : 0.0;
        gain_count += 1.0;
      }
      largest = std::max(largest, std::abs(run.error[k]) /
                                      std::max(run.standard_error[k], 1e-300));
    }
  }
  std::string each;
  for (std::size_t k = 0; k < parameters; ++k) {
    double squares = 0.0, bound = 0.0, own_covered = 0.0;
    for (const Run& run : runs) {
      squares += run.error[k] * run.error[k] / n;
      bound += run.limit[k] * run.limit[k] / n;
      own_covered += run.covered[k] ? 1.0 / n : 0.0;
    }
    const double ratio = std::sqrt(squares / bound);
    worst_ratio = std::max(worst_ratio, ratio);
    absl::StrAppendFormat(&each, " %.2f/%.0f", ratio, 100.0 * own_covered);
  }
  const double full_error = std::sqrt(
      std::max(full_squares - full * full, 0.0) / std::max(n - 1.0, 1.0));
  std::cout << absl::StrFormat(
                   "| %s | %s | %s | %d | %.3g | %.3g | %.2f ± %.2f | %.2f | "
                   "%.1f | "
                   "%.1f %% (%.1f %%) | %.1f %% | %.1f %% | %.3g | %.1f %% | "
                   "%.1f %% |",
                   name, variance, drift, runs.size(), full, limit,
                   full / limit, full_error / limit, worst_ratio, largest,
                   100.0 * covered / count, 100.0 * gains / gain_count,
                   Percent(runs, [](const Run& r) { return r.proposed; }),
                   Percent(runs, [](const Run& r) { return r.named_exactly; }),
                   proposed,
                   Percent(runs, [](const Run& r) { return r.suspected; }),
                   Percent(runs,
                           [](const Run& r) { return r.wrong_structure; }))
            << "\n"
            << each << std::endl;
}

int Main(int argc, char** argv) {
  const int threads = benchmarks::TakeThreads(argc, argv);
  int seeds = 0;
  int first = 0;
  double variance = 0.0;
  double drift = 0.0;
  if (threads < 0 || argc < 7 || !absl::SimpleAtoi(argv[2], &seeds) ||
      seeds < 1 || !absl::SimpleAtoi(argv[3], &first) || first < 0 ||
      !absl::SimpleAtod(argv[4], &variance) ||
      !absl::SimpleAtod(argv[5], &drift)) {
    std::cerr << "usage: structured_study MODEL.json SEEDS FIRST VARIANCE "
                 "DRIFT NAME:PLANT.json … [--threads=N]\n";
    return 2;
  }
  const auto initial = ReadProcessModel(argv[1]);
  CHECK(initial.ok()) << initial.status();
  reproduce::ExperimentOptions options;
  options.noise_variance = variance;
  const int p = initial->num_outputs();
  options.output_weight = Eigen::VectorXd::Constant(p, 0.2);
  options.move_weight = Eigen::VectorXd::Constant(initial->num_inputs(), 0.1);
  if (drift > 0.0) {
    options.conditions.output_disturbance.drift_variance =
        Eigen::VectorXd::Constant(p, drift);
  }
  std::cout << "| case | σ² | q | seeds | E, all free | limit | ratio | worst "
               "RMS error / limit | largest error / s.e. | coverage of 95 % "
               "(gains) | change proposed | named exactly | E, proposed | "
               "initial model suspected | structure suspected |\n"
               "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
            << std::endl;
  for (int c = 6; c < argc; ++c) {
    const std::pair<std::string, std::string> part =
        absl::StrSplit(argv[c], absl::MaxSplits(':', 1));
    ProcessModel plant = *initial;
    if (part.second != "none") {
      const auto read = ReadProcessModel(part.second);
      CHECK(read.ok()) << read.status();
      plant = *read;
    }
    std::vector<Run> runs(seeds);
    ParallelFor(seeds, threads, [&](int s) {
      runs[s] = RunOne(*initial, plant, static_cast<std::uint64_t>(first + s),
                       drift, options);
    });
    PrintRow(part.first, argv[4], argv[5], runs);
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
