#include "mle/maintain/hold_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kBlockFolds = 5;
constexpr int kBlocksPerFold = 2;

// What one fold holds out.
struct Fold {
  std::string name;
  // For each window: whether each of its samples is held out; empty: none is.
  std::vector<std::vector<bool>> held;
};

bool HoldsAll(const std::vector<bool>& held) {
  return !held.empty() &&
         std::all_of(held.begin(), held.end(), [](bool h) { return h; });
}

std::vector<Fold> FoldsOfWindows(const std::vector<Record>& windows,
                                 int max_folds) {
  const int size = static_cast<int>(windows.size());
  const int count = std::min(size, max_folds);
  std::vector<Fold> folds(count);
  for (int f = 0; f < count; ++f) {
    folds[f].held.resize(size);
    std::vector<std::string> numbers;
    for (int w = f; w < size; w += count) {
      folds[f].held[w].assign(windows[w].samples(), true);
      numbers.push_back(absl::StrCat(w + 1));
    }
    folds[f].name = absl::StrCat(numbers.size() > 1 ? "windows " : "window ",
                                 absl::StrJoin(numbers, ", "));
  }
  return folds;
}

// Of every window, blocks of equal length go to the folds in turn.
std::vector<Fold> FoldsOfBlocks(const std::vector<Record>& windows) {
  const int blocks = kBlockFolds * kBlocksPerFold;
  std::vector<Fold> folds(kBlockFolds);
  for (int f = 0; f < kBlockFolds; ++f) {
    folds[f].name = absl::StrCat("blocks ", f + 1, " and ", f + 1 + kBlockFolds,
                                 " of ", blocks);
  }
  for (const Record& window : windows) {
    const int n = window.samples();
    for (Fold& fold : folds) fold.held.emplace_back(n);
    for (int k = 0; k < n; ++k) {
      const auto block =
          static_cast<int>(static_cast<std::int64_t>(k) * blocks / n);
      folds[block % kBlockFolds].held.back()[k] = true;
    }
  }
  return folds;
}

// What remains for the fit: windows held out whole are gone, in others the
// outputs held out are lost.
std::vector<Record> Remaining(const std::vector<Record>& windows,
                              const Fold& fold) {
  std::vector<Record> records;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const std::vector<bool>& held = fold.held[w];
    if (HoldsAll(held)) continue;
    Record& record = records.emplace_back(windows[w]);
    for (std::size_t k = 0; k < held.size(); ++k) {
      if (held[k])
        record.outputs.col(static_cast<Eigen::Index>(k)).setConstant(kNaN);
    }
  }
  return records;
}

struct Sums {
  double initial = 0.0;    // Σ ε² of the initial model
  double corrected = 0.0;  // of the corrected one
  double total = 0.0;      // Σ (y − ȳ)²
  double count = 0.0;

  void Add(const Sums& other) {
    initial += other.initial;
    corrected += other.corrected;
    total += other.total;
    count += other.count;
  }
};

// Over the samples of a window that are held out and that both models predict.
Sums Score(const Eigen::RowVectorXd& measured, const std::vector<bool>& held,
           const Eigen::RowVectorXd& initial,
           const Eigen::RowVectorXd& corrected) {
  std::vector<int> scored;
  double sum = 0.0;
  for (int k = 0; k < measured.size(); ++k) {
    if (!held[k] || !std::isfinite(initial(k)) ||
        !std::isfinite(corrected(k))) {
      continue;
    }
    scored.push_back(k);
    sum += measured(k);
  }
  Sums sums;
  const double mean =
      scored.empty() ? 0.0 : sum / static_cast<double>(scored.size());
  for (const int k : scored) {
    sums.initial += initial(k) * initial(k);
    sums.corrected += corrected(k) * corrected(k);
    sums.total += (measured(k) - mean) * (measured(k) - mean);
    sums.count += 1.0;
  }
  return sums;
}

// By output and horizon.
using Scores = std::vector<std::array<Sums, 3>>;

Scores ScoreFold(const std::vector<Record>& windows, const Fold& fold,
                 const Predictor& before, const Predictor& after,
                 const std::array<int, 3>& horizons) {
  const int p = windows.front().num_outputs();
  Scores scores(p);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const std::vector<bool>& held = fold.held[w];
    if (held.empty()) continue;
    const Record& record = windows[w];
    for (std::size_t h = 0; h < horizons.size(); ++h) {
      const Eigen::MatrixXd initial = before(record, horizons[h]);
      const Eigen::MatrixXd corrected = after(record, horizons[h]);
      for (int i = 0; i < p; ++i) {
        scores[i][h].Add(Score(record.outputs.row(i), held, initial.row(i),
                               corrected.row(i)));
      }
    }
  }
  return scores;
}

double Percent(double squares, const Sums& sums) {
  return sums.count > 0.0 && sums.total > 0.0
             ? 100.0 * (1.0 - std::sqrt(squares / sums.total))
             : kNaN;
}

FitPercent InitialPercent(const std::array<Sums, 3>& sums) {
  return {Percent(sums[0].initial, sums[0]), Percent(sums[1].initial, sums[1]),
          Percent(sums[2].initial, sums[2])};
}

FitPercent CorrectedPercent(const std::array<Sums, 3>& sums) {
  return {Percent(sums[0].corrected, sums[0]),
          Percent(sums[1].corrected, sums[1]),
          Percent(sums[2].corrected, sums[2])};
}

absl::StatusOr<HeldOut> HoldOut(const Estimate& estimate,
                                const std::vector<Record>& windows,
                                const std::vector<Fold>& folds, int horizon,
                                int threads, const ProgressCallback& progress) {
  const int count = static_cast<int>(folds.size());
  const std::array<int, 3> horizons = {1, horizon, 0};
  std::vector<absl::Status> status(count);
  std::vector<Scores> scores(count);
  Stage stage(progress, "predicting held-out data", count);
  ParallelFor(count, threads, [&](int f) {
    if (stage.cancelled()) return;
    const absl::StatusOr<Predictor> corrected = PredictFromPart(
        estimate.setting, estimate.fit, Remaining(windows, folds[f]));
    status[f] = corrected.status();
    if (!corrected.ok()) return;
    scores[f] = ScoreFold(windows, folds[f], estimate.fit.initial, *corrected,
                          horizons);
    stage.Done();
  });
  MLE_RETURN_IF_ERROR(stage.status());
  HeldOut held_out;
  Scores all(windows.front().num_outputs());
  for (int f = 0; f < count; ++f) {
    if (!status[f].ok()) {
      // What remains may be too short, or move too little, to be fitted.
      held_out.missing =
          absl::StrCat("without ", folds[f].name, ": ", status[f].message());
      return held_out;
    }
    held_out.folds.push_back(folds[f].name);
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t h = 0; h < horizons.size(); ++h) {
        all[i][h].Add(scores[f][i][h]);
      }
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::array<Sums, 3>& sums = all[i];
    held_out.outputs.push_back({InitialPercent(sums), CorrectedPercent(sums)});
    const Sums& decisive = sums[estimate.setting.arx_outputs[i] ? 2 : 0];
    if (decisive.initial > 0.0 && decisive.corrected > 0.0) {
      held_out.gain -= 0.5 * decisive.count *
                       std::log(decisive.corrected / decisive.initial);
    }
  }
  return held_out;
}

// What the rule for λ has held out already: its loss at λ* against that of the
// largest λ, which corrects nothing.
HeldOut BlocksOfTheRule(const Correction& correction,
                        const std::vector<Record>& windows) {
  HeldOut held_out;
  const SelectionSummary& selection = correction.selection();
  const Eigen::VectorXd& loss = selection.loss;
  if (loss.size() < 2 || !(loss.minCoeff() > 0.0)) {
    held_out.missing = "the rule for λ holds nothing out";
    return held_out;
  }
  Eigen::Index chosen = 0;
  (selection.lambdas.array() - selection.lambda_star(0))
      .abs()
      .minCoeff(&chosen);
  double samples = 0.0;
  for (const Record& window : windows) {
    samples += window.samples();
  }
  held_out.folds = {"the blocks held out by the rule for λ"};
  held_out.gain =
      -0.5 * samples * std::log(loss(chosen) / loss(loss.size() - 1));
  return held_out;
}

}  // namespace

absl::Status HoldOutOptions::Validate() const {
  if (max_folds < 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        "hold_out.max_folds = ", max_folds, ": it must be at least 2"));
  }
  if (horizon < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "hold_out.horizon = ", horizon, ": it must not be negative"));
  }
  return absl::OkStatus();
}

std::optional<double> Validation::WorstGain() const {
  std::optional<double> worst;
  for (const auto* way : {&windows, &blocks}) {
    if (!way->has_value() || !(*way)->available()) continue;
    worst = std::min(worst.value_or((*way)->gain), (*way)->gain);
  }
  return worst;
}

const HeldOut* Validation::shown() const {
  if (windows.has_value() && !windows->outputs.empty()) return &*windows;
  if (blocks.has_value() && !blocks->outputs.empty()) return &*blocks;
  return nullptr;
}

absl::StatusOr<Validation> ValidateByHoldOut(const Estimate& estimate,
                                             const std::vector<Record>& windows,
                                             int order,
                                             const HoldOutOptions& options,
                                             int threads,
                                             const ProgressCallback& progress) {
  MLE_RETURN_IF_ERROR(options.Validate());
  Validation validation;
  validation.horizon =
      options.horizon > 0 ? options.horizon : std::max(order / 5, 1);
  if (!estimate.fit.change_proposed) {
    Fold all;
    for (const Record& window : windows) {
      all.held.emplace_back(window.samples(), true);
    }
    const Scores scores =
        ScoreFold(windows, all, estimate.fit.initial, estimate.fit.initial,
                  {1, validation.horizon, 0});
    for (const std::array<Sums, 3>& sums : scores) {
      validation.initial.push_back(InitialPercent(sums));
    }
    return validation;
  }
  if (windows.size() > 1) {
    MLE_ASSIGN_OR_RETURN(
        validation.windows,
        HoldOut(estimate, windows, FoldsOfWindows(windows, options.max_folds),
                validation.horizon, threads, progress));
  }
  if (estimate.fit.arx.has_value()) {
    validation.blocks = BlocksOfTheRule(*estimate.fit.arx, windows);
    return validation;
  }
  MLE_ASSIGN_OR_RETURN(validation.blocks,
                       HoldOut(estimate, windows, FoldsOfBlocks(windows),
                               validation.horizon, threads, progress));
  return validation;
}

}  // namespace mle
