// trial_benchmark SET LIVES FIRST_SEED [LEVEL LEFT_SHARE]: how often a trial
// adopts a model that is worse than the one in use, after how many changes of
// set points it adopts one that is better, how many of these it loses, and how
// it rolls back.
//
// SET: `tuning` or `reporting`, which have other plants. Half of the lives have
// a correction that was estimated from a record, the others one that is drawn
// right or wrong (benchmarks/trial/trial_life.h). A model is worse where E is
// larger with it, or the cost of control by more than 1 %, than with the model
// in use and with the plant's own. After adoption the plant stays as it is, or,
// in every other life, is what it was before it aged. Models that are not
// adopted are taken into use nevertheless, to see them rolled back.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "benchmarks/trial/trial_life.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::benchmarks {
namespace {

constexpr int kTrialDays = 60;
constexpr int kDaysInUse = 60;
constexpr int kNever = -1;
// Costs of control that differ by less are the same.
constexpr double kSameCost = 1.01;

struct Outcome {
  Proposal proposal = Proposal::kEstimated;
  int disturbance = 0;
  bool proposed = false;
  bool better = false;          // by E
  bool better_control = false;  // by the cost of control
  TrialAdvice advice = TrialAdvice::kWait;
  int changes = 0;  // until the advice
  // By the losses on all rows, day by day, as an e-process of their own.
  TrialAdvice by_losses = TrialAdvice::kWait;
  int changes_by_losses = 0;
  // In use: whether the plant went back; changes until the advice to roll back.
  bool went_back = false;
  int rolled_back = kNever;
};

// Bets on bounded differences of the losses of each day, (L⁰ − L¹)/(L⁰ + L¹).
class DailyLosses {
 public:
  TrialAdvice Add(const TrialState& state, double level) {
    const double in_use = Total(state.losses, &StepLosses::in_use);
    const double proposed = Total(state.losses, &StepLosses::proposed);
    const double a = in_use - in_use_;
    const double b = proposed - proposed_;
    in_use_ = in_use;
    proposed_ = proposed;
    if (!(a + b > 0.0)) return advice_;
    const double d = (a - b) / (a + b);
    double wealth = 0.0;
    double against = 0.0;
    for (std::size_t i = 0; i < std::size(kBets); ++i) {
      for_[i] *= 1.0 + kBets[i] * d;
      against_[i] *= 1.0 - kBets[i] * d;
      wealth += for_[i] / std::size(kBets);
      against += against_[i] / std::size(kBets);
    }
    if (advice_ == TrialAdvice::kWait && wealth >= 1.0 / level) {
      advice_ = TrialAdvice::kAdopt;
    }
    if (advice_ == TrialAdvice::kWait && against >= 1.0 / level) {
      advice_ = TrialAdvice::kDrop;
    }
    return advice_;
  }

 private:
  static constexpr double kBets[] = {0.1, 0.3, 0.6, 0.9};
  static double Total(const std::vector<StepLosses>& losses,
                      std::vector<double> StepLosses::*of) {
    double sum = 0.0;
    for (const StepLosses& output : losses) {
      for (const double value : output.*of) sum += value;
    }
    return sum;
  }
  double in_use_ = 0.0;
  double proposed_ = 0.0;
  double for_[4] = {1.0, 1.0, 1.0, 1.0};
  double against_[4] = {1.0, 1.0, 1.0, 1.0};
  TrialAdvice advice_ = TrialAdvice::kWait;
};

void RunInUse(const TrialPlant& plant, const TrialLife& life, ModelTrial trial,
              Outcome& outcome) {
  trial.Adopt();
  for (int day = kTrialDays; day < kTrialDays + kDaysInUse; ++day) {
    const Record record = life.Day(
        *life.proposed(), outcome.went_back ? plant.model : life.truth(), day);
    if (record.samples() == 0) {  // Switched off by the operators.
      outcome.rolled_back = 0;
      return;
    }
    CHECK(trial.Look(record).ok());
    const TrialVerdict verdict = trial.verdict();
    if (verdict.advice == TrialAdvice::kRollBack) {
      outcome.rolled_back = verdict.changes;
      return;
    }
  }
}

Outcome RunLife(const TrialPlant& plant, Proposal proposal, std::uint64_t seed,
                const TrialOptions& options) {
  const TrialLife life(plant, proposal, seed);
  Outcome outcome{.proposal = proposal, .disturbance = life.disturbance()};
  if (!life.proposed().has_value()) return outcome;
  absl::StatusOr<ModelTrial> made = ModelTrial::Create(
      plant.model, *life.proposed(), plant.sample_time, options);
  if (!made.ok()) return outcome;
  ModelTrial trial = *std::move(made);
  outcome.proposed = true;
  outcome.better =
      life.Distance(*life.proposed()) <= life.Distance(plant.model);
  // The plant's own model can cost more than one that makes the controller
  // slower: a tuning is not the model's fault.
  outcome.better_control = life.ControlCost(*life.proposed()) <=
                           kSameCost * std::max(life.ControlCost(plant.model),
                                                life.ControlCost(life.truth()));
  CHECK(trial.Learn(life.first_record()).ok());
  DailyLosses losses;
  for (int day = 0; day < kTrialDays; ++day) {
    const Record record = life.Day(plant.model, life.truth(), day);
    if (record.samples() == 0) break;
    CHECK(trial.Look(record).ok());
    const TrialVerdict verdict = trial.verdict();
    if (outcome.by_losses == TrialAdvice::kWait) {
      outcome.by_losses = losses.Add(trial.state(), options.level);
      outcome.changes_by_losses = verdict.changes;
    }
    outcome.advice = verdict.advice;
    outcome.changes = verdict.changes;
    if (verdict.advice != TrialAdvice::kWait) break;
  }
  outcome.went_back = proposal != Proposal::kNothingAged && (seed / 5) % 2 == 0;
  RunInUse(plant, life, std::move(trial), outcome);
  return outcome;
}

double Median(std::vector<int> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void PrintRow(const char* name, const std::vector<Outcome>& outcomes) {
  int lives = 0;
  int adopted = 0;
  int dropped = 0;
  int worse = 0;
  int worse_control = 0;
  int by_losses = 0;
  int worse_by_losses = 0;
  std::vector<int> changes;
  for (const Outcome& outcome : outcomes) {
    ++lives;
    const bool took = outcome.advice == TrialAdvice::kAdopt;
    adopted += took ? 1 : 0;
    dropped += outcome.advice == TrialAdvice::kDrop ? 1 : 0;
    worse += took && !outcome.better ? 1 : 0;
    worse_control += took && !outcome.better_control ? 1 : 0;
    const bool by_loss = outcome.by_losses == TrialAdvice::kAdopt;
    by_losses += by_loss ? 1 : 0;
    worse_by_losses += by_loss && !outcome.better ? 1 : 0;
    if (took) changes.push_back(outcome.changes);
  }
  std::printf("%-16s %5d %7d %7d %5d %7d %8.0f   %7d %5d\n", name, lives,
              adopted, dropped, worse, worse_control, Median(changes),
              by_losses, worse_by_losses);
}

template <typename Is>
std::vector<Outcome> Those(const std::vector<Outcome>& outcomes, const Is& is) {
  std::vector<Outcome> those;
  for (const Outcome& outcome : outcomes) {
    if (is(outcome)) those.push_back(outcome);
  }
  return those;
}

void PrintInUse(const char* name, const std::vector<Outcome>& outcomes) {
  std::vector<int> changes;
  for (const Outcome& outcome : outcomes) {
    if (outcome.rolled_back != kNever) changes.push_back(outcome.rolled_back);
  }
  std::printf(
      "%-42s %5zu lives, %5zu rolled back, after %.0f changes (median)\n", name,
      outcomes.size(), changes.size(), Median(changes));
}

void Print(const std::vector<Outcome>& all) {
  const std::vector<Outcome> tried =
      Those(all, [](const Outcome& o) { return o.proposed; });
  std::printf("%zu lives, %zu with a proposal\n", all.size(), tried.size());
  std::printf("%-16s %5s %7s %7s %5s %7s %8s   %s\n", "proposal", "lives",
              "adopted", "dropped", "worse", "control", "changes",
              "by losses of all rows: adopted, worse");
  for (int k = 0; k < kProposals; ++k) {
    PrintRow(kProposalNames[k], Those(tried, [&](const Outcome& o) {
               return static_cast<int>(o.proposal) == k;
             }));
  }
  for (int k = 0; k < kDisturbances; ++k) {
    PrintRow(kDisturbanceNames[k], Those(tried, [&](const Outcome& o) {
               return o.disturbance == k;
             }));
  }
  PrintRow("better by E",
           Those(tried, [](const Outcome& o) { return o.better; }));
  PrintRow("all", tried);
  const std::vector<Outcome> right = Those(tried, [](const Outcome& o) {
    return o.proposal == Proposal::kEstimated && o.better;
  });
  std::vector<int> changes;
  int lost = 0;
  for (const Outcome& outcome : right) {
    lost += outcome.advice != TrialAdvice::kAdopt ? 1 : 0;
    if (outcome.advice == TrialAdvice::kAdopt) {
      changes.push_back(outcome.changes);
    }
  }
  std::printf(
      "right corrections: %zu, lost %d, adopted after %.0f changes "
      "(median)\n",
      right.size(), lost, Median(changes));
  PrintInUse("adopted, the plant stays", Those(tried, [](const Outcome& o) {
               return o.advice == TrialAdvice::kAdopt && !o.went_back;
             }));
  PrintInUse("adopted, the plant goes back", Those(tried, [](const Outcome& o) {
               return o.advice == TrialAdvice::kAdopt && o.went_back;
             }));
  PrintInUse(
      "worse, taken into use nevertheless",
      Those(tried, [](const Outcome& o) { return !o.better && !o.went_back; }));
}

std::vector<TrialPlant> PlantsOf(const std::string& set) {
  const std::string configs = MLE_CONFIG_DIR;
  const std::string plants = MLE_PLANT_DIR;
  if (set == "tuning") {
    return {
        ReadTrialPlant(configs + "/wood_berry.json", {1, 1}, 0.5, 1, 30),
        ReadTrialPlant(plants + "/two_by_two.json", {1, 1}, 0.4, 1.2, 30),
        ReadTrialPlant(plants + "/three_by_three.json", {1, 1, 1}, 2, 6, 30)};
  }
  return {ReadTrialPlant(plants + "/vinante_luyben.json", {1, 1}, 0.2, 0.6, 40),
          ReadTrialPlant(configs + "/splitter.json", {0.5, 0.5, 2}, 1, 2, 40),
          ReadTrialPlant(plants + "/wardle_wood.json", {0.1, 0.1}, 2, 6, 30),
          ReadTrialPlant(plants + "/ogunnaike_ray.json", {0.5, 0.5, 10}, 0.5, 1,
                         40)};
}

}  // namespace
}  // namespace mle::benchmarks

int main(int argc, char** argv) {
  using namespace mle::benchmarks;
  const std::string set = argc > 1 ? argv[1] : "";
  if ((set != "tuning" && set != "reporting") || (argc != 4 && argc != 6)) {
    std::fprintf(stderr,
                 "usage: %s tuning|reporting LIVES FIRST_SEED [LEVEL "
                 "LEFT_SHARE]\n",
                 argv[0]);
    return 2;
  }
  const int lives = std::atoi(argv[2]);
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[3]));
  mle::TrialOptions options;
  if (argc == 6) {
    options.level = std::atof(argv[4]);
    options.left_share = std::atof(argv[5]);
  }
  const std::vector<TrialPlant> plants = PlantsOf(set);
  std::vector<Outcome> outcomes(lives);
  mle::ParallelFor(lives, /*threads=*/0, [&](int r) {
    const auto seed = first + static_cast<std::uint64_t>(r);
    const auto kind = static_cast<int>(seed % 15);
    const auto proposal = static_cast<Proposal>(kind < kProposals ? kind : 0);
    outcomes[r] =
        RunLife(plants[(seed / 15) % plants.size()], proposal, seed, options);
  });
  Print(outcomes);
  return 0;
}
