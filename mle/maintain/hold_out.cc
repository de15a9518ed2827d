#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/data/line.h"
#include "mle/data/segments.h"
#include "mle/maintain/stage.h"
#include "mle/maintain/validation.h"

namespace mle {
namespace {

// Parts of a window over which the products of a standard error are summed.
constexpr std::array<int, 3> kBlockCounts = {10, 3, 1};
constexpr int kBlocksPerFold = 2;
// The samples that one fold holds out.
struct Fold {
  std::string name;
  // For each window: whether each of its samples after the lead is held out.
  std::vector<std::vector<bool>> held;
};

// In every window, blocks of equal length go to the folds in turn, beginning
// with another fold in each: set points change at the same place in many
// windows, and a fold that hid all changes would leave nothing to estimate
// from.
std::vector<Fold> FoldsOfBlocks(const std::vector<Record>& windows, int count) {
  const int blocks = count * kBlocksPerFold;
  // Neighbouring windows differ by more than neighbouring blocks.
  const int shift = count % 2 == 1 ? 2 : 1;
  std::vector<Fold> folds(count);
  for (int f = 0; f < count; ++f) {
    folds[f].name = absl::StrCat("fold ", f + 1, " of ", count);
  }
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const int n = windows[w].samples() - windows[w].lead();
    const int first = static_cast<int>(w % count) * shift;
    for (Fold& fold : folds) fold.held.emplace_back(n);
    for (int k = 0; k < n; ++k) {
      const auto block =
          static_cast<int>(static_cast<std::int64_t>(k) * blocks / n);
      folds[(block + first) % count].held.back()[k] = true;
    }
  }
  return folds;
}

// The windows for the fit: the outputs held out are lost.
std::vector<Record> Remaining(std::vector<Record> windows, const Fold& fold) {
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const int lead = windows[w].lead();
    for (int k = 0; k < std::ssize(fold.held[w]); ++k) {
      if (fold.held[w][k]) windows[w].outputs.col(lead + k).setConstant(kNaN);
    }
  }
  return windows;
}

// Sums of one output at one horizon.
struct Sums {
  double initial = 0.0;    // Σ ε₀²
  double corrected = 0.0;  // Σ ε_c²
  double total = 0.0;      // Σ (y − ȳ)²
  double count = 0.0;
  // Σ_b (Σ_{k∈b} x_k ε_k)² with either model's errors, for each size of blocks.
  std::array<double, kBlockCounts.size()> by_initial = {};
  std::array<double, kBlockCounts.size()> by_corrected = {};

  void Add(const Sums& other) {
    initial += other.initial;
    corrected += other.corrected;
    total += other.total;
    count += other.count;
    for (std::size_t b = 0; b < kBlockCounts.size(); ++b) {
      by_initial[b] += other.by_initial[b];
      by_corrected[b] += other.by_corrected[b];
    }
  }

  HorizonScore Score() const {
    HorizonScore score;
    if (!(count > 0.0) || !(total > 0.0)) return score;
    score.initial = 100.0 * (1.0 - std::sqrt(initial / total));
    score.corrected = 100.0 * (1.0 - std::sqrt(corrected / total));
    // Predictions that are exact have nothing to gain.
    if (!(initial > 0.0)) {
      score.gain = corrected > 0.0 ? -kInfinity : 0.0;
      score.error = 0.0;
      return score;
    }
    const auto& products = corrected < initial ? by_corrected : by_initial;
    score.gain = 1.0 - corrected / initial;
    score.error =
        2.0 * std::sqrt(*std::max_element(products.begin(), products.end())) /
        initial;
    return score;
  }
};

// Over the samples of a window that are held out and that both models predict.
Sums Compare(const Eigen::RowVectorXd& measured, const std::vector<bool>& held,
             const Eigen::RowVectorXd& initial,
             const Eigen::RowVectorXd& corrected) {
  std::vector<int> scored;
  for (int k = 0; k < measured.size(); ++k) {
    if (held[k] && std::isfinite(initial(k)) && std::isfinite(corrected(k))) {
      scored.push_back(k);
    }
  }
  Sums sums;
  if (scored.empty()) return sums;
  const Eigen::ArrayXd y = measured(scored).transpose();
  const Eigen::ArrayXd before = initial(scored).transpose();
  const Eigen::ArrayXd after = corrected(scored).transpose();
  const auto n = y.size();
  sums.initial = before.square().sum();
  sums.corrected = after.square().sum();
  sums.total = (y - y.mean()).square().sum();
  sums.count = static_cast<double>(n);
  const Eigen::ArrayXd by_initial = (before - after) * before;
  const Eigen::ArrayXd by_corrected = (before - after) * after;
  for (std::size_t b = 0; b < kBlockCounts.size(); ++b) {
    for (Eigen::Index i = 0; i < kBlockCounts[b]; ++i) {
      const Eigen::Index first = n * i / kBlockCounts[b];
      const Eigen::Index size = n * (i + 1) / kBlockCounts[b] - first;
      const double one = by_initial.segment(first, size).sum();
      const double other = by_corrected.segment(first, size).sum();
      sums.by_initial[b] += one * one;
      sums.by_corrected[b] += other * other;
    }
  }
  return sums;
}

// By window, output and horizon.
using Scores = std::vector<std::vector<std::array<Sums, 3>>>;

// Errors of the model in one window. Those of a free simulation are less their
// mean or, for outputs that integrate, less their line.
Eigen::MatrixXd PartOf(const Eigen::MatrixXd& errors, const SegmentPart& window,
                       int horizon, const std::vector<bool>& integrating) {
  Eigen::MatrixXd part = errors.middleCols(window.first, window.samples);
  if (horizon > 0) return part;
  for (Eigen::Index i = 0; i < part.rows(); ++i) {
    auto row = part.row(i);
    if (integrating[i]) {
      row = WithoutLine(row.transpose()).transpose();
      continue;
    }
    const Eigen::Array<bool, 1, Eigen::Dynamic> known = row.array().isFinite();
    const auto count = static_cast<double>(known.count());
    if (count > 0.0) {
      row.array() -= known.select(row.array(), 0.0).sum() / count;
    }
  }
  return part;
}

Scores ScoreFold(const std::vector<Record>& windows, const Fold& fold,
                 const Predictor& before, const Predictor& after,
                 const std::array<int, 3>& horizons,
                 const std::vector<bool>& integrating) {
  const int p = windows.front().num_outputs();
  const Segments segments = JoinAdjoining(windows);
  Scores scores(windows.size(), std::vector<std::array<Sums, 3>>(p));
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    std::vector<Eigen::MatrixXd> initial;
    std::vector<Eigen::MatrixXd> corrected;
    for (const Record& record : segments.records) {
      initial.push_back(before(record, horizons[h]));
      corrected.push_back(after(record, horizons[h]));
    }
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const SegmentPart& part = segments.windows[w];
      const Eigen::MatrixXd one =
          PartOf(initial[part.segment], part, horizons[h], integrating);
      const Eigen::MatrixXd other =
          PartOf(corrected[part.segment], part, horizons[h], integrating);
      for (int i = 0; i < p; ++i) {
        scores[w][i][h] = Compare(windows[w].outputs.row(i).tail(part.samples),
                                  fold.held[w], one.row(i), other.row(i));
      }
    }
  }
  return scores;
}

void AddScores(const Scores& scores, Scores& all) {
  if (all.empty()) {
    all = scores;
    return;
  }
  for (std::size_t w = 0; w < scores.size(); ++w) {
    for (std::size_t i = 0; i < scores[w].size(); ++i) {
      for (std::size_t h = 0; h < scores[w][i].size(); ++h) {
        all[w][i][h].Add(scores[w][i][h]);
      }
    }
  }
}

std::vector<OutputScores> ScoresOf(
    const std::vector<std::array<Sums, 3>>& outputs) {
  std::vector<OutputScores> scores;
  for (const std::array<Sums, 3>& sums : outputs) {
    scores.push_back({sums[0].Score(), sums[1].Score(), sums[2].Score()});
  }
  return scores;
}

std::vector<OutputScores> ScoresOfAll(const Scores& windows) {
  if (windows.empty()) return {};
  Scores total(1, windows.front());
  for (std::size_t w = 1; w < windows.size(); ++w) {
    AddScores(Scores(1, windows[w]), total);
  }
  return ScoresOf(total.front());
}

// How the correction without a fold predicts the fold.
struct FoldResult {
  absl::Status status;
  Scores corrected;
};

// Whether windows have offsets is decided by all the data, too, where they
// leave no doubt.
WindowOffsets OffsetsOf(const OutputErrorCorrection& structure) {
  const double weight = structure.full.offset_weight;
  if (weight == structure.corrected.offset_weight) {
    if (weight == 0.0) return WindowOffsets::kNever;
    if (weight == 1.0) return WindowOffsets::kAlways;
  }
  return WindowOffsets::kAveraged;
}

FoldResult HoldOut(const Estimate& estimate, const std::vector<Record>& windows,
                   const Fold& fold, const Predictor& in_use,
                   const std::array<int, 3>& horizons) {
  FoldResult result;
  EstimationOptions options = estimate.setting.options;
  // Whether a change is proposed at all, and of which outputs, is decided, by
  // all the data: a fold may be too short to find it again. What has changed,
  // where they leave a doubt, and how, is its own.
  const OutputErrorCorrection& structure = estimate.fit.output_error;
  options.output_error.change_given = structure.change_proposed;
  if (structure.change_proposed) {
    options.output_error.start =
        std::make_shared<const OutputErrorCorrection>(structure);
    options.output_error.offsets = OffsetsOf(structure);
  }
  for (int i = 0; i < estimate.setting.initial.num_outputs(); ++i) {
    options.output_error.outputs.push_back(ProposesChange(estimate, i));
  }
  if (options.change_test == ChangeTest::kCalibrated) {
    options.change_test = ChangeTest::kChiSquare;
  }
  const absl::StatusOr<Estimate> part = EstimateModel(
      estimate.setting.initial, Remaining(windows, fold), options);
  result.status = part.status();
  if (!part.ok()) return result;
  const Predictor& before = in_use ? in_use : part->fit.initial;
  const std::vector<bool> integrating =
      IntegratingOutputs(estimate.setting.initial);
  result.corrected = ScoreFold(windows, fold, before, part->fit.corrected,
                               horizons, integrating);
  return result;
}

// All windows by the initial model.
void ScoreInitial(const Estimate& estimate, const std::vector<Record>& windows,
                  const Predictor& in_use, Validation& validation) {
  Fold all;
  for (const Record& window : windows) {
    all.held.emplace_back(window.samples() - window.lead(), true);
  }
  const Predictor& initial = in_use ? in_use : estimate.fit.initial;
  validation.outputs = ScoresOfAll(
      ScoreFold(windows, all, initial, initial, {1, validation.horizon, 0},
                IntegratingOutputs(estimate.setting.initial)));
  for (OutputScores& output : validation.outputs) {
    for (HorizonScore* score :
         {&output.one_step, &output.several_steps, &output.simulated}) {
      score->corrected = kNaN;
      score->gain = kNaN;
      score->error = kNaN;
    }
  }
}

}  // namespace

absl::Status HoldOutOptions::Validate() const {
  if (folds < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("hold_out.folds = ", folds, ": it must be at least 2"));
  }
  if (fewest_changes < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("hold_out.fewest_changes = ", fewest_changes,
                     ": it must be at least 2"));
  }
  if (horizon < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "hold_out.horizon = ", horizon, ": it must not be negative"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Validation> ValidateByHoldOut(
    const Estimate& estimate, const std::vector<Record>& windows, int changes,
    int order, const HoldOutOptions& options, const Predictor& in_use,
    int threads, const ProgressCallback& progress) {
  MLE_RETURN_IF_ERROR(options.Validate());
  Validation validation;
  validation.horizon =
      options.horizon > 0 ? options.horizon : std::max(order / 5, 1);
  ScoreInitial(estimate, windows, in_use, validation);
  if (!ProposesAny(estimate)) return validation;
  if (windows.size() == 1 && changes < options.fewest_changes) {
    validation.missing =
        absl::StrCat("there is one window, with ", changes,
                     changes == 1 ? " set-point change" : " set-point changes",
                     "; another window is needed, or ", options.fewest_changes,
                     " changes in this one");
    return validation;
  }
  const std::vector<Fold> folds = FoldsOfBlocks(windows, options.folds);
  const int count = static_cast<int>(folds.size());
  const std::array<int, 3> horizons = {1, validation.horizon, 0};
  std::vector<FoldResult> results(count);
  Stage stage(progress, "predicting held-out data", count);
  ParallelFor(count, threads, [&](int f) {
    if (stage.cancelled()) return;
    results[f] = HoldOut(estimate, windows, folds[f], in_use, horizons);
    stage.Done();
  });
  MLE_RETURN_IF_ERROR(stage.status());
  Scores corrected;
  for (int f = 0; f < count; ++f) {
    if (!results[f].status.ok()) {
      // The remaining data may be too short, or move too little, to be fitted.
      validation.missing = absl::StrCat("without ", folds[f].name, ": ",
                                        results[f].status.message());
      return validation;
    }
    validation.folds.push_back(folds[f].name);
    AddScores(results[f].corrected, corrected);
  }
  validation.held_out = true;
  validation.outputs = ScoresOfAll(corrected);
  for (const auto& outputs : corrected) {
    validation.windows.push_back(ScoresOf(outputs));
  }
  return validation;
}

}  // namespace mle
