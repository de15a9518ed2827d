// The estimators against each other over cases, seeds and noise:
//
//   estimator_study MODEL.json SEEDS FIRST VARIANCE DRIFT ESTIMATOR,…
//       NAME:PLANT.json …
//
// DRIFT is the increment variance per sample of a random walk on every output.
// NAME:none has no mismatch. A line for each run, then a table. The conversion
// is under white noise of the same variance. --threads=N limits the threads.

#include <iostream>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "apps/reproduce/estimators.h"
#include "apps/reproduce/experiment.h"
#include "benchmarks/study_threads.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/correction/correction.h"
#include "mle/model/process_model.h"

namespace mle {
namespace {

struct StudyCase {
  std::string name;
  ProcessModel plant;
};

ProcessModel Read(const std::string& path) {
  auto model = ReadProcessModel(path);
  CHECK(model.ok()) << model.status();
  return *std::move(model);
}

reproduce::ExperimentOptions Options(const ProcessModel& initial,
                                     double variance, double drift,
                                     const std::string& estimators) {
  reproduce::ExperimentOptions options;
  options.noise_variance = variance;
  options.conversion_noise_variance = variance;
  const int p = initial.num_outputs();
  options.output_weight = Eigen::VectorXd::Constant(p, 0.2);
  options.move_weight = Eigen::VectorXd::Constant(initial.num_inputs(), 0.1);
  if (drift > 0.0) {
    options.conditions.output_disturbance.drift_variance =
        Eigen::VectorXd::Constant(p, drift);
  }
  const auto grid = MakeLambdaGrid(1e-2, 1e-6);
  CHECK(grid.ok()) << grid.status();
  options.correction.lambdas = *grid;
  options.estimators = absl::StrSplit(estimators, ',');
  CHECK(options.Validate(initial).ok()) << options.Validate(initial);
  return options;
}

reproduce::EstimatorComparison Run(
    const ProcessModel& initial, const StudyCase& one, std::uint64_t seed,
    const ConversionSummary& conversion,
    const reproduce::ExperimentOptions& options) {
  const auto windows =
      reproduce::SimulateWindows(initial, one.plant, seed, options);
  CHECK(windows.ok()) << windows.status();
  const double start = reproduce::ThreadSeconds();
  const auto correction =
      CorrectModel(conversion.model, *windows, options.correction);
  CHECK(correction.ok()) << correction.status();
  return reproduce::CompareEstimators(initial, one.plant, *windows, *correction,
                                      reproduce::ThreadSeconds() - start, seed,
                                      /*in_full=*/true, options);
}

std::string Line(const std::string& name, std::uint64_t seed,
                 const reproduce::EstimatorComparison& comparison) {
  std::string line =
      absl::StrFormat("%s,%d,limit,%.4g", name, seed, comparison.E_limit);
  for (const reproduce::EstimatorResult& result : comparison.estimators) {
    absl::StrAppendFormat(&line, ",%s,%.4g,%s,%.2g,%.2f s", result.name,
                          result.E, result.change_proposed ? "change" : "none",
                          result.p_value, result.seconds);
    if (!result.status.ok()) {
      absl::StrAppend(&line, ",", std::string(result.status.message()));
    }
  }
  return line;
}

int Main(int argc, char** argv) {
  const int threads = benchmarks::TakeThreads(argc, argv);
  int seeds = 0;
  int first = 0;
  double variance = 0.0;
  double drift = 0.0;
  if (threads < 0 || argc < 8 || !absl::SimpleAtoi(argv[2], &seeds) ||
      seeds < 1 || !absl::SimpleAtoi(argv[3], &first) || first < 0 ||
      !absl::SimpleAtod(argv[4], &variance) ||
      !absl::SimpleAtod(argv[5], &drift)) {
    std::cerr << "usage: estimator_study MODEL.json SEEDS FIRST VARIANCE DRIFT "
                 "ESTIMATOR,… NAME:PLANT.json … [--threads=N]\n";
    return 2;
  }
  const ProcessModel initial = Read(argv[1]);
  const reproduce::ExperimentOptions options =
      Options(initial, variance, drift, argv[6]);
  std::vector<StudyCase> cases;
  for (int i = 7; i < argc; ++i) {
    const std::pair<std::string, std::string> part =
        absl::StrSplit(argv[i], absl::MaxSplits(':', 1));
    cases.push_back(
        {part.first, part.second == "none" ? initial : Read(part.second)});
  }
  std::vector<std::vector<reproduce::EstimatorComparison>> runs(
      cases.size(), std::vector<reproduce::EstimatorComparison>(seeds));
  std::mutex mutex;
  ParallelFor(seeds, threads, [&](int s) {
    const std::uint64_t seed = static_cast<std::uint64_t>(first + s);
    const auto conversion =
        reproduce::ConvertInitialModel(initial, seed, options);
    CHECK(conversion.ok()) << conversion.status();
    for (std::size_t c = 0; c < cases.size(); ++c) {
      runs[c][s] = Run(initial, cases[c], seed, *conversion, options);
      const std::lock_guard<std::mutex> lock(mutex);
      std::cout << Line(cases[c].name, seed, runs[c][s]) << std::endl;
    }
  });
  for (std::size_t c = 0; c < cases.size(); ++c) {
    std::vector<const reproduce::EstimatorComparison*> all;
    for (const auto& run : runs[c]) all.push_back(&run);
    std::cout << "\nσ² " << argv[4] << ", q " << argv[5] << "\n"
              << report::RenderText(
                     reproduce::EstimatorTable(cases[c].name, all));
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
