// The rules for the penalty λ against each other.
//
//   selection_study core|all MODEL.json SEEDS VARIANCE,… NAME:PLANT.json …
//
// Corrects MODEL on every plant with every seed and noise variance, in the
// paper's experiment, lets each rule choose λ over the whole path, and compares
// E there with E at the best λ of the path. A plant NAME:none has no mismatch;
// there E is held against that of leaving the model alone. Writes a line of CSV
// for each run, then a table for each variance. --threads=N limits the threads.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <mutex>
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

namespace mle {
namespace {

using Rule = SelectionOptions::Rule;

struct NamedRule {
  std::string name;
  SelectionOptions options;
  bool window_intercepts = false;
};

std::vector<NamedRule> Rules(bool all) {
  // Orders of a block, phases and samples ahead.
  const auto blocks = [](double orders, int phases, int horizon) {
    SelectionOptions options;
    options.block_length = static_cast<int>(orders * 150);
    options.phases = phases;
    options.horizon = horizon;
    return options;
  };
  SelectionOptions paper;
  paper.rule = Rule::kLeaveChangeOut;
  paper.on_grid = true;
  SelectionOptions leave_change_out;
  leave_change_out.rule = Rule::kLeaveChangeOut;
  std::vector<NamedRule> rules = {
      {"paper", paper},
      {"leave_change_out", leave_change_out},
      {"blocks 2d, 1 phase", blocks(2, 1, 1)},
      {"blocks 2d, 2 phases", blocks(2, 2, 1)},
      {"blocks 2d, 2 phases, intercepts", blocks(2, 2, 1), true},
      {"blocks 2d, 2 ph., d/5 ahead (default)", blocks(2, 2, 30)},
      {"blocks 4d, 1 phase", blocks(4, 1, 1)},
  };
  for (const auto& [name, rule] : {std::pair{"aic", Rule::kAic},
                                   {"bic", Rule::kBic},
                                   {"gcv", Rule::kGcv}}) {
    SelectionOptions criterion;
    criterion.rule = rule;
    rules.push_back({name, criterion});
  }
  if (!all) return rules;
  SelectionOptions simulated = leave_change_out;
  simulated.horizon = 0;
  SelectionOptions one_standard_error = blocks(2, 2, 1);
  one_standard_error.one_standard_error = true;
  SelectionOptions each = blocks(2, 2, 1);
  each.per_output = true;
  for (const NamedRule& rule : std::vector<NamedRule>{
           {"leave_change_out, simulated", simulated},
           {"blocks d, 2 phases", blocks(1, 2, 1)},
           {"blocks 2d, 4 phases", blocks(2, 4, 1)},
           {"blocks 4d, 2 phases", blocks(4, 2, 1)},
           {"blocks 2d, 2 phases, d ahead", blocks(2, 2, 150)},
           {"blocks 2d, 2 phases, simulated", blocks(2, 2, 0)},
           {"blocks 2d, 2 phases, 1 s.e.", one_standard_error},
           {"blocks 2d, 2 phases, λ each", each}}) {
    rules.push_back(rule);
  }
  return rules;
}

// 24 a decade from 1e-4 σ, where noise is fitted, to 10: above any λ_max of
// these records.
Eigen::VectorXd Grid(double noise_variance) {
  const double first = std::log10(1e-4 * std::sqrt(noise_variance));
  const int steps = static_cast<int>(std::ceil((1.0 - first) * 24.0));
  return Eigen::VectorXd::LinSpaced(steps + 1, first, 1.0)
      .unaryExpr([](double x) { return std::pow(10.0, x); });
}

// The paper's rule stops at 1e-2.
constexpr double kPaperGridEnd = 1e-2 * (1.0 + 1e-9);

struct Outcome {
  double reference = 0.0;  // E at the best λ, or left alone without mismatch
  std::map<std::string, double> E;
};

Outcome Run(const std::vector<NamedRule>& rules, const ProcessModel& initial,
            const ProcessModel& plant, bool mismatch,
            const ConversionSummary& conversion, std::uint64_t seed,
            const reproduce::ExperimentOptions& options) {
  const auto windows =
      reproduce::SimulateWindows(initial, plant, seed, options);
  CHECK(windows.ok()) << windows.status();
  const auto correct = [&](bool window_intercepts) {
    CorrectionOptions correction = options.correction;
    correction.window_intercepts = window_intercepts;
    auto result = CorrectModel(conversion.model, *windows, correction);
    CHECK(result.ok()) << result.status();
    return *std::move(result);
  };
  const Correction common = correct(false);
  const Correction by_window = correct(true);
  const StepResponse truth = plant.ComputeStepResponse(
      options.sample_time, options.response_samples());
  const auto distance = [&](const ArxModel& model) {
    return SquaredDistance(truth, model.ComputeStepResponse(truth.samples()));
  };
  Outcome outcome;
  outcome.reference = distance(conversion.model);
  if (mismatch) {
    for (const double lambda : options.correction.lambdas) {
      outcome.reference =
          std::min(outcome.reference, distance(common.Model(lambda)));
    }
  }
  for (const NamedRule& rule : rules) {
    const Correction& correction = rule.window_intercepts ? by_window : common;
    const auto selection = correction.Select(rule.options);
    CHECK(selection.ok()) << selection.status();
    Eigen::VectorXd lambda = selection->lambda_star;
    if (rule.name == "paper") {
      // The grid of the paper: the best of it, not of the whole path.
      Eigen::Index best = 0;
      for (Eigen::Index i = 1; i < selection->lambdas.size() &&
                               selection->lambdas(i) <= kPaperGridEnd;
           ++i) {
        if (selection->loss(i) <= selection->loss(best)) best = i;
      }
      lambda.setConstant(selection->lambdas(best));
    }
    outcome.E[rule.name] = distance(correction.Model(lambda));
  }
  return outcome;
}

void PrintTable(const std::vector<NamedRule>& rules,
                const std::string& variance,
                const std::vector<std::string>& plants,
                const std::vector<std::vector<Outcome>>& outcomes) {
  std::cout << "\nvariance " << variance
            << ": E over that at the best λ (without mismatch: over that of "
               "leaving the model alone), mean of ratios / ratio of means / "
               "largest\n"
            << absl::StrFormat("%-40s", "rule");
  for (const std::string& plant : plants) {
    std::cout << absl::StrFormat("%-24s", plant);
  }
  std::cout << "\n";
  for (const NamedRule& rule : rules) {
    std::cout << absl::StrFormat("%-40s", rule.name);
    for (const std::vector<Outcome>& runs : outcomes) {
      double ratios = 0.0, largest = 0.0, sum = 0.0, reference = 0.0;
      for (const Outcome& run : runs) {
        const double ratio = run.E.at(rule.name) / run.reference;
        ratios += ratio / static_cast<double>(runs.size());
        largest = std::max(largest, ratio);
        sum += run.E.at(rule.name);
        reference += run.reference;
      }
      std::cout << absl::StrFormat("%-24s",
                                   absl::StrFormat("%.2f / %.2f / %.1f", ratios,
                                                   sum / reference, largest));
    }
    std::cout << "\n";
  }
}

int Main(int argc, char** argv) {
  const int threads = benchmarks::TakeThreads(argc, argv);
  int seeds = 0;
  const std::string which = argc > 1 ? argv[1] : "";
  if (threads < 0 || argc < 6 || (which != "core" && which != "all") ||
      !absl::SimpleAtoi(argv[3], &seeds) || seeds < 1) {
    std::cerr
        << "usage: selection_study core|all MODEL.json SEEDS VARIANCE,… "
           "NAME:PLANT.json … [--threads=N] (NAME:none has no mismatch)\n";
    return 2;
  }
  const std::vector<NamedRule> rules = Rules(which == "all");
  const auto initial = ReadProcessModel(argv[2]);
  CHECK(initial.ok()) << initial.status();
  std::vector<std::string> names;
  std::vector<ProcessModel> plants;
  std::vector<bool> mismatch;
  for (int i = 5; i < argc; ++i) {
    const std::pair<std::string, std::string> part =
        absl::StrSplit(argv[i], absl::MaxSplits(':', 1));
    names.push_back(part.first);
    mismatch.push_back(part.second != "none");
    plants.push_back(*initial);
    if (mismatch.back()) {
      const auto plant = ReadProcessModel(part.second);
      CHECK(plant.ok()) << plant.status();
      plants.back() = *plant;
    }
  }
  for (const std::string& text :
       std::vector<std::string>(absl::StrSplit(argv[4], ','))) {
    reproduce::ExperimentOptions options;
    CHECK(absl::SimpleAtod(text, &options.noise_variance)) << text;
    options.conversion_noise_variance = options.noise_variance;
    options.output_weight =
        Eigen::VectorXd::Constant(initial->num_outputs(), 0.2);
    options.move_weight = Eigen::VectorXd::Constant(initial->num_inputs(), 0.1);
    options.correction.lambdas = Grid(options.noise_variance);
    // The rules under study are applied afterwards.
    options.correction.selection.rule = Rule::kAic;
    CHECK(options.Validate(*initial).ok()) << options.Validate(*initial);
    std::vector<std::vector<Outcome>> outcomes(plants.size(),
                                               std::vector<Outcome>(seeds));
    std::mutex mutex;
    ParallelFor(seeds, threads, [&](int s) {
      const std::uint64_t seed = 1 + static_cast<std::uint64_t>(s);
      const auto conversion =
          reproduce::ConvertInitialModel(*initial, seed, options);
      CHECK(conversion.ok()) << conversion.status();
      for (std::size_t c = 0; c < plants.size(); ++c) {
        outcomes[c][s] = Run(rules, *initial, plants[c], mismatch[c],
                             *conversion, seed, options);
        const std::lock_guard<std::mutex> lock(mutex);
        std::cout << text << "," << seed << "," << names[c] << ","
                  << outcomes[c][s].reference;
        for (const auto& [rule, E] : outcomes[c][s].E) {
          std::cout << "," << rule << "," << E;
        }
        std::cout << std::endl;
      }
    });
    PrintTable(rules, text, names, outcomes);
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
