// What outliers do to the estimators, and what replacement and robust losses
// mend:
//
//   outlier_study MODEL.json SEEDS FIRST SHARE LONGEST VARIANCE NAME:PLANT.json
//   …
//
// Of every output a share of the samples is off by 10 to 50 σ, in the historian
// alone, so that the loop and its noise are those of the clean record: singly
// (LONGEST 1) or in bursts of 3 to LONGEST samples off to the same side. E of
// ΔR and of the structured correction with the clean records, with the spoilt
// ones, with the outliers replaced (for the structured one: marked) by a model
// (output_reconstruction.h), and of the structured correction with robust
// losses on the spoilt ones. Last, how many samples were spoilt, how many of
// them the model found, and how many it found besides. --threads=N limits the
// threads.

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
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
#include "mle/correction/correction.h"
#include "mle/nonlinear/output_reconstruction.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {
namespace {

constexpr double kSmallest = 10.0;  // σ
constexpr double kLargest = 50.0;
constexpr int kShortestBurst = 3;
constexpr std::array<const char*, 11> kColumns = {"ΔR, clean",
                                                  "ΔR, spoilt",
                                                  "ΔR, model",
                                                  "structured, clean",
                                                  "structured, spoilt",
                                                  "structured, model",
                                                  "structured, Huber",
                                                  "structured, Cauchy",
                                                  "spoilt",
                                                  "found",
                                                  "wrongly"};
constexpr std::array<int, kColumns.size()> kClean = {0, 0, 0, 3, 3, 3,
                                                     3, 3, 8, 8, 8};
// Longest gap that is filled: two bursts, one at the other.
constexpr int kMaxGap = 30;
using Row = std::array<double, kColumns.size()>;

// Outliers, or bursts of them, until the share is reached.
void Spoil(double share, int longest, double deviation, std::uint64_t seed,
           std::vector<Record>& windows) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> size(kSmallest, kLargest);
  for (Record& window : windows) {
    const int samples = window.samples();
    for (int i = 0; i < window.num_outputs(); ++i) {
      for (int spoilt = 0; spoilt < share * samples;) {
        const int length = longest == 1 ? 1
                                        : std::uniform_int_distribution<int>(
                                              kShortestBurst, longest)(engine);
        const int first =
            std::uniform_int_distribution<int>(0, samples - length)(engine);
        const double side = engine() % 2 == 0 ? 1.0 : -1.0;
        for (int k = first; k < first + length; ++k) {
          window.outputs(i, k) += side * size(engine) * deviation;
        }
        spoilt += length;
      }
    }
  }
}

std::vector<Record> Windows(const ProcessModel& initial,
                            const ProcessModel& plant, std::uint64_t seed,
                            const reproduce::ExperimentOptions& options) {
  auto windows = reproduce::SimulateWindows(initial, plant, seed, options);
  CHECK(windows.ok()) << windows.status();
  return *std::move(windows);
}

// 0 where there is nothing to compare with: no sample was spoilt.
double Ratio(double value, double clean) {
  return clean > 0.0 ? value / clean : 0.0;
}

// Samples of outputs.
struct Counts {
  double spoilt = 0.0;
  double found = 0.0;
  double wrongly = 0.0;
};

Counts Compare(const std::vector<Record>& clean,
               const std::vector<Record>& spoilt,
               const std::vector<Record>& marked) {
  Counts counts;
  for (std::size_t w = 0; w < clean.size(); ++w) {
    for (Eigen::Index k = 0; k < clean[w].outputs.size(); ++k) {
      const bool bad = spoilt[w].outputs(k) != clean[w].outputs(k);
      const bool found = std::isnan(marked[w].outputs(k));
      counts.spoilt += bad ? 1.0 : 0.0;
      counts.found += bad && found ? 1.0 : 0.0;
      counts.wrongly += !bad && found ? 1.0 : 0.0;
    }
  }
  return counts;
}

struct Spoiling {
  double share = 0.0;
  int longest = 1;
};

Row RunOne(const ProcessModel& initial, const ProcessModel& plant,
           std::uint64_t seed, const ConversionSummary& conversion,
           const Spoiling& spoiling,
           const reproduce::ExperimentOptions& options) {
  const StepResponse truth = plant.ComputeStepResponse(
      options.sample_time, options.response_samples());
  const auto correct = [&](const std::vector<Record>& windows) {
    auto correction =
        CorrectModel(conversion.model, windows, options.correction);
    CHECK(correction.ok()) << correction.status();
    return *std::move(correction);
  };
  const auto arx = [&](const ArxModel& model) {
    return SquaredDistance(truth, model.ComputeStepResponse(truth.samples()));
  };
  const auto structured = [&](const std::vector<Record>& windows,
                              RobustLoss loss = RobustLoss::kNone) {
    const auto fit = CorrectStructure(initial, windows, {.robust_loss = loss});
    CHECK(fit.ok()) << fit.status();
    return SquaredDistance(truth, fit->full.model.ComputeStepResponse(
                                      options.sample_time, truth.samples()));
  };
  const std::vector<Record> clean = Windows(initial, plant, seed, options);
  std::vector<Record> spoilt = clean;
  Spoil(spoiling.share, spoiling.longest, std::sqrt(options.noise_variance),
        seed, spoilt);
  std::vector<Record> by_model = spoilt;
  const auto report = MarkOutliers(initial, {}, {}, by_model);
  CHECK(report.ok()) << report.status();
  const auto fit = CorrectStructure(initial, by_model, {});
  CHECK(fit.ok()) << fit.status();
  std::vector<Record> filled = by_model;
  const auto count =
      FillOutputs(fit->full.model, fit->full.noise, kMaxGap, filled);
  CHECK(count.ok()) << count.status();
  const Counts counts = Compare(clean, spoilt, by_model);
  return {arx(correct(clean).Model()),
          arx(correct(spoilt).Model()),
          arx(correct(filled).Model()),
          structured(clean),
          structured(spoilt),
          structured(by_model),
          structured(spoilt, RobustLoss::kHuber),
          structured(spoilt, RobustLoss::kCauchy),
          counts.spoilt,
          counts.found,
          counts.wrongly};
}

int Main(int argc, char** argv) {
  const int threads = benchmarks::TakeThreads(argc, argv);
  int seeds = 0;
  int first = 0;
  Spoiling spoiling;
  double variance = 0.0;
  if (threads < 0 || argc < 8 || !absl::SimpleAtoi(argv[2], &seeds) ||
      seeds < 1 || !absl::SimpleAtoi(argv[3], &first) || first < 0 ||
      !absl::SimpleAtod(argv[4], &spoiling.share) ||
      !absl::SimpleAtoi(argv[5], &spoiling.longest) ||
      (spoiling.longest != 1 && spoiling.longest < kShortestBurst) ||
      !absl::SimpleAtod(argv[6], &variance)) {
    std::cerr << "usage: outlier_study MODEL.json SEEDS FIRST SHARE LONGEST "
                 "VARIANCE NAME:PLANT.json … [--threads=N]\n";
    return 2;
  }
  const auto initial = ReadProcessModel(argv[1]);
  CHECK(initial.ok()) << initial.status();
  reproduce::ExperimentOptions options;
  options.noise_variance = variance;
  options.conversion_noise_variance = variance;
  options.output_weight =
      Eigen::VectorXd::Constant(initial->num_outputs(), 0.2);
  options.move_weight = Eigen::VectorXd::Constant(initial->num_inputs(), 0.1);
  options.correction.lambdas = *MakeLambdaGrid(1e-2, 1e-6);
  std::cout << "| case | seed |";
  for (const char* column : kColumns) std::cout << " " << column << " |";
  std::cout << "\n|---|---|";
  for (std::size_t k = 0; k < kColumns.size(); ++k) std::cout << "---|";
  std::cout << std::endl;
  const auto print = [](const std::string& name, const std::string& seed,
                        const Row& row) {
    std::cout << "| " << name << " | " << seed << " |";
    for (const double E : row) std::cout << absl::StrFormat(" %.3g |", E);
    std::cout << std::endl;
  };
  for (int c = 7; c < argc; ++c) {
    const std::pair<std::string, std::string> part =
        absl::StrSplit(argv[c], absl::MaxSplits(':', 1));
    const auto plant = ReadProcessModel(part.second);
    CHECK(plant.ok()) << plant.status();
    std::vector<Row> rows(seeds);
    ParallelFor(seeds, threads, [&](int s) {
      const auto seed = static_cast<std::uint64_t>(first + s);
      const auto conversion =
          reproduce::ConvertInitialModel(*initial, seed, options);
      CHECK(conversion.ok()) << conversion.status();
      rows[s] = RunOne(*initial, *plant, seed, *conversion, spoiling, options);
    });
    Row mean = {};
    Row worst = {};  // ratio to the clean records' E
    for (int s = 0; s < seeds; ++s) {
      print(part.first, std::to_string(first + s), rows[s]);
      for (std::size_t k = 0; k < mean.size(); ++k) {
        mean[k] += rows[s][k] / seeds;
        worst[k] = std::max(worst[k], Ratio(rows[s][k], rows[s][kClean[k]]));
      }
    }
    print(part.first, "mean", mean);
    Row ratio = {};
    for (std::size_t k = 0; k < ratio.size(); ++k) {
      ratio[k] = Ratio(mean[k], mean[kClean[k]]);
    }
    print(part.first, "mean over clean mean", ratio);
    print(part.first, "largest over clean", worst);
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
