// What outliers do to the estimators, and what their replacement mends:
//
//   outlier_study MODEL.json SEEDS FIRST SHARE NAME:PLANT.json …
//
// Of every output a share of the samples is off by 10 to 50 σ, in the historian
// alone, so that the loop and its noise are those of the clean record. E of ΔR
// and of the structured correction with the clean records, with the spoilt
// ones, and with the outliers replaced (for the structured one: marked).

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "apps/reproduce/experiment.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/data/outlier_replacement.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {
namespace {

constexpr double kLargestOutlier = 50.0;  // σ; the smallest is a fifth of it
constexpr std::array<const char*, 6> kColumns = {
    "ΔR, clean",         "ΔR, spoilt",         "ΔR, replaced",
    "structured, clean", "structured, spoilt", "structured, marked"};
using Row = std::array<double, kColumns.size()>;

std::vector<Record> Windows(const ProcessModel& initial,
                            const ProcessModel& plant, std::uint64_t seed,
                            const reproduce::ExperimentOptions& options) {
  auto windows = reproduce::SimulateWindows(initial, plant, seed, options);
  CHECK(windows.ok()) << windows.status();
  return *std::move(windows);
}

Row RunOne(const ProcessModel& initial, const ProcessModel& plant,
           std::uint64_t seed, const ConversionSummary& conversion,
           double share, reproduce::ExperimentOptions options) {
  const StepResponse truth = plant.ComputeStepResponse(
      options.sample_time, options.response_samples());
  const auto arx = [&](const std::vector<Record>& windows) {
    const auto correction =
        CorrectModel(conversion.model, windows, options.correction);
    CHECK(correction.ok()) << correction.status();
    return SquaredDistance(
        truth, correction->Model().ComputeStepResponse(truth.samples()));
  };
  const auto structured = [&](const std::vector<Record>& windows) {
    const auto fit = CorrectStructure(initial, windows, {});
    CHECK(fit.ok()) << fit.status();
    return SquaredDistance(truth, fit->full.model.ComputeStepResponse(
                                      options.sample_time, truth.samples()));
  };
  const std::vector<Record> clean = Windows(initial, plant, seed, options);
  auto& faults = options.conditions.faults;
  faults.outlier_probability = share;
  faults.outlier_size = Eigen::VectorXd::Constant(
      plant.num_outputs(), kLargestOutlier * std::sqrt(options.noise_variance));
  faults.only_in_record = true;
  const std::vector<Record> spoilt = Windows(initial, plant, seed, options);
  std::vector<Record> replaced = spoilt;
  ReplaceOutliers(initial, {}, replaced);
  std::vector<Record> marked = spoilt;
  OutlierReplacementOptions mark;
  mark.max_gap = 0;
  ReplaceOutliers(initial, mark, marked);
  return {arx(clean),        arx(spoilt),        arx(replaced),
          structured(clean), structured(spoilt), structured(marked)};
}

int Main(int argc, char** argv) {
  int seeds = 0;
  int first = 0;
  double share = 0.0;
  if (argc < 6 || !absl::SimpleAtoi(argv[2], &seeds) || seeds < 1 ||
      !absl::SimpleAtoi(argv[3], &first) || first < 0 ||
      !absl::SimpleAtod(argv[4], &share)) {
    std::cerr << "usage: outlier_study MODEL.json SEEDS FIRST SHARE "
                 "NAME:PLANT.json …\n";
    return 2;
  }
  const auto initial = ReadProcessModel(argv[1]);
  CHECK(initial.ok()) << initial.status();
  reproduce::ExperimentOptions options;
  options.output_weight =
      Eigen::VectorXd::Constant(initial->num_outputs(), 0.2);
  options.move_weight = Eigen::VectorXd::Constant(initial->num_inputs(), 0.1);
  options.correction.lambdas = *MakeLambdaGrid(1e-2, 1e-6);
  std::cout << "| case | seed |";
  for (const char* column : kColumns) std::cout << " " << column << " |";
  std::cout << "\n|---|---|---|---|---|---|---|---|" << std::endl;
  const auto print = [](const std::string& name, const std::string& seed,
                        const Row& row) {
    std::cout << "| " << name << " | " << seed << " |";
    for (const double E : row) std::cout << absl::StrFormat(" %.3g |", E);
    std::cout << std::endl;
  };
  for (int c = 5; c < argc; ++c) {
    const std::pair<std::string, std::string> part =
        absl::StrSplit(argv[c], absl::MaxSplits(':', 1));
    const auto plant = ReadProcessModel(part.second);
    CHECK(plant.ok()) << plant.status();
    std::vector<Row> rows(seeds);
    ParallelFor(seeds, 0, [&](int s) {
      const auto seed = static_cast<std::uint64_t>(first + s);
      const auto conversion =
          reproduce::ConvertInitialModel(*initial, seed, options);
      CHECK(conversion.ok()) << conversion.status();
      rows[s] = RunOne(*initial, *plant, seed, *conversion, share, options);
    });
    Row mean = {};
    for (int s = 0; s < seeds; ++s) {
      print(part.first, std::to_string(first + s), rows[s]);
      for (std::size_t k = 0; k < mean.size(); ++k) {
        mean[k] += rows[s][k] / seeds;
      }
    }
    print(part.first, "mean", mean);
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
