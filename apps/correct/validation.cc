#include "apps/correct/validation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::correct {
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

std::vector<Fold> FoldsOfWindows(const RecordData& data, int max_folds) {
  const int windows = static_cast<int>(data.windows.size());
  const int count = std::min(windows, max_folds);
  std::vector<Fold> folds(count);
  for (int f = 0; f < count; ++f) {
    folds[f].held.resize(windows);
    std::vector<std::string> numbers;
    for (int w = f; w < windows; w += count) {
      folds[f].held[w].assign(data.windows[w].record.samples(), true);
      numbers.push_back(absl::StrCat(w + 1));
    }
    folds[f].name = absl::StrCat(numbers.size() > 1 ? "windows " : "window ",
                                 absl::StrJoin(numbers, ", "));
  }
  return folds;
}

// Blocks of equal length go to the folds in turn.
std::vector<Fold> FoldsOfBlocks(const RecordData& data) {
  const int n = data.windows.front().record.samples();
  const int blocks = kBlockFolds * kBlocksPerFold;
  std::vector<Fold> folds(kBlockFolds);
  for (int f = 0; f < kBlockFolds; ++f) {
    folds[f].name = absl::StrCat("blocks ", f + 1, " and ", f + 1 + kBlockFolds,
                                 " of ", blocks);
    folds[f].held.resize(1);
    folds[f].held[0].resize(n);
  }
  for (int k = 0; k < n; ++k) {
    const auto block =
        static_cast<int>(static_cast<std::int64_t>(k) * blocks / n);
    folds[block % kBlockFolds].held[0][k] = true;
  }
  return folds;
}

// What remains for the fit: windows held out whole are gone, in others the
// outputs held out are lost.
std::vector<Record> Remaining(const RecordData& data, const Fold& fold) {
  std::vector<Record> records;
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const std::vector<bool>& held = fold.held[w];
    if (HoldsAll(held)) continue;
    Record& record = records.emplace_back(data.windows[w].record);
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

Scores ScoreFold(const RecordData& data, const Fold& fold, const Fit& fit,
                 const std::array<int, 3>& horizons) {
  const int p = data.windows.front().record.num_outputs();
  Scores scores(p);
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const std::vector<bool>& held = fold.held[w];
    if (held.empty()) continue;
    const Record& record = data.windows[w].record;
    for (std::size_t h = 0; h < horizons.size(); ++h) {
      const Eigen::MatrixXd initial = fit.initial(record, horizons[h]);
      const Eigen::MatrixXd corrected = fit.corrected(record, horizons[h]);
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

void Summarise(const Scores& scores, Validation& validation) {
  for (const std::array<Sums, 3>& sums : scores) {
    OutputValidation output;
    output.initial = {Percent(sums[0].initial, sums[0]),
                      Percent(sums[1].initial, sums[1]),
                      Percent(sums[2].initial, sums[2])};
    output.corrected = {Percent(sums[0].corrected, sums[0]),
                        Percent(sums[1].corrected, sums[1]),
                        Percent(sums[2].corrected, sums[2])};
    validation.outputs.push_back(output);
    const Sums& several = sums[1];
    if (several.initial > 0.0 && several.corrected > 0.0) {
      validation.gain -=
          0.5 * several.count * std::log(several.corrected / several.initial);
    }
  }
}

}  // namespace

absl::StatusOr<Validation> Validate(const Setting& setting,
                                    const RecordData& data,
                                    const ValidationOptions& options) {
  Validation validation;
  validation.blocked = data.windows.size() == 1;
  validation.horizon =
      options.horizon > 0 ? options.horizon : std::max(options.order / 5, 1);
  const std::vector<Fold> folds = validation.blocked
                                      ? FoldsOfBlocks(data)
                                      : FoldsOfWindows(data, options.max_folds);
  const int count = static_cast<int>(folds.size());
  const std::array<int, 3> horizons = {1, validation.horizon, 0};
  std::vector<absl::Status> status(count);
  std::vector<FoldSummary> summaries(count);
  std::vector<Scores> scores(count);
  ParallelFor(count, options.threads, [&](int f) {
    const absl::StatusOr<Fit> fit =
        FitWindows(setting, Remaining(data, folds[f]));
    status[f] = fit.status();
    if (!fit.ok()) return;
    summaries[f] = {folds[f].name, fit->change_proposed};
    scores[f] = ScoreFold(data, folds[f], *fit, horizons);
  });
  Scores all(data.windows.front().record.num_outputs());
  for (int f = 0; f < count; ++f) {
    if (!status[f].ok()) {
      // What remains may be too short, or move too little, to be fitted.
      validation.missing =
          absl::StrCat("without ", folds[f].name, ": ", status[f].message());
      return validation;
    }
    validation.folds.push_back(summaries[f]);
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t h = 0; h < horizons.size(); ++h) {
        all[i][h].Add(scores[f][i][h]);
      }
    }
  }
  Summarise(all, validation);
  return validation;
}

}  // namespace mle::correct
