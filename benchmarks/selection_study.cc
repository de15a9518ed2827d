// The rules for the penalty λ against each other.
//
//   selection_study core|all MODEL.json SEEDS VARIANCE,… NAME:PLANT.json …
//
// Corrects MODEL on every plant with every seed and noise variance, in the
// paper's experiment, lets each rule choose λ over the whole path, and compares
// E there with E at the best λ of the path. A plant NAME:none has no mismatch;
// there E is held against that of leaving the model alone. Writes a line of CSV
// for each run, then a table for each variance.

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
#include "glog/logging.h"
#include "mle/base/parallel.h"

namespace mle {
namespace {

using Rule = SelectionOptions::Rule;

struct NamedRule {
  std::string name;
  SelectionOptions options;
};

std::vector<NamedRule> Rules(bool all) {
  std::vector<NamedRule> rules;
  const auto add = [&](std::string name, Rule rule, int block, int horizon,
                       bool one_standard_error = false,
                       bool per_output = false) {
    SelectionOptions options;
    options.rule = rule;
    options.block_length = block;
    options.horizon = horizon;
    options.one_standard_error = one_standard_error;
    options.per_output = per_output;
    rules.push_back({std::move(name), options});
  };
  SelectionOptions paper;
  paper.rule = Rule::kLeaveChangeOut;
  paper.horizon = 1;
  paper.on_grid = true;
  rules.push_back({"paper", paper});
  add("leave_change_out", Rule::kLeaveChangeOut, 0, 1);
  add("blocks 2d", Rule::kBlocks, 300, 1);
  add("blocks 2d, d/5 ahead", Rule::kBlocks, 300, 30);
  add("blocks 4d", Rule::kBlocks, 600, 1);
  add("aic", Rule::kAic, 0, 1);
  add("bic", Rule::kBic, 0, 1);
  add("gcv", Rule::kGcv, 0, 1);
  if (!all) return rules;
  add("leave_change_out simulated", Rule::kLeaveChangeOut, 0, 0);
  add("blocks d", Rule::kBlocks, 150, 1);
  add("blocks 2d, d ahead", Rule::kBlocks, 300, 150);
  add("blocks 2d simulated", Rule::kBlocks, 300, 0);
  add("blocks 4d simulated", Rule::kBlocks, 600, 0);
  add("blocks 2d, d/5 ahead, 1 s.e.", Rule::kBlocks, 300, 30, true);
  add("blocks 2d, d/5 ahead, λ each", Rule::kBlocks, 300, 30, false, true);
  return rules;
}

// 0, then 24 a decade from 1e-6 to 10: above any λ_max of these records.
Eigen::VectorXd Grid() {
  std::vector<double> lambdas = {0.0};
  for (int i = 0; i <= 7 * 24; ++i) {
    lambdas.push_back(std::pow(10.0, -6.0 + i / 24.0));
  }
  return Eigen::Map<Eigen::VectorXd>(lambdas.data(), lambdas.size());
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
  const auto correction =
      CorrectModel(conversion.model, *windows, options.correction);
  CHECK(correction.ok()) << correction.status();
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
          std::min(outcome.reference, distance(correction->Model(lambda)));
    }
  }
  for (const NamedRule& rule : rules) {
    const auto selection = correction->Select(rule.options);
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
    outcome.E[rule.name] = distance(correction->Model(lambda));
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
            << absl::StrFormat("%-28s", "rule");
  for (const std::string& plant : plants) {
    std::cout << absl::StrFormat("%-24s", plant);
  }
  std::cout << "\n";
  for (const NamedRule& rule : rules) {
    std::cout << absl::StrFormat("%-28s", rule.name);
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
  int seeds = 0;
  const std::string which = argc > 1 ? argv[1] : "";
  if (argc < 6 || (which != "core" && which != "all") ||
      !absl::SimpleAtoi(argv[3], &seeds) || seeds < 1) {
    std::cerr << "usage: selection_study core|all MODEL.json SEEDS VARIANCE,… "
                 "NAME:PLANT.json … (NAME:none has no mismatch)\n";
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
    options.correction.lambdas = Grid();
    CHECK(options.Validate(*initial).ok()) << options.Validate(*initial);
    std::vector<std::vector<Outcome>> outcomes(plants.size(),
                                               std::vector<Outcome>(seeds));
    std::mutex mutex;
    ParallelFor(seeds, 0, [&](int s) {
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
