#include "mle/maintain/sticking_inputs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/outliers.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/play_regression.h"

namespace mle {
namespace {

constexpr double kLeastPlaySamples = 200.0;
constexpr double kMostProducts = 2e7;
// An output that repeats itself for so many samples is not measured there.
constexpr int kStandsStill = 10;
constexpr double kWorthTrying = 3.0;  // nats
constexpr double kLeastPlayNats = 12.0;
constexpr double kLeastScore = 8.0;
constexpr double kLeastOwnNats = 15.0;
constexpr double kLeastPlayFactor = 0.4;
constexpr double kMostFactor = 2.5;
constexpr double kMostShare = 0.45;
constexpr std::array<double, 4> kNearWidths = {0.7, 0.85, 1.2, 1.4};

// Samples of an output that say nothing: not known, far from their neighbours,
// or the same for long.
Eigen::RowVectorXd BadSamples(const Eigen::RowVectorXd& samples) {
  const auto n = static_cast<int>(samples.size());
  Eigen::RowVectorXd bad = samples.unaryExpr(
      [](double value) { return std::isfinite(value) ? 0.0 : 1.0; });
  for (const int k : FindOutliers(samples)) bad(k) = 1.0;
  int first = 0;
  for (int k = 1; k <= n; ++k) {
    if (k < n && samples(k) == samples(first)) continue;
    if (k - first >= kStandsStill) bad.segment(first, k - first).setOnes();
    first = k;
  }
  return bad;
}

// The parts of records around changes of set points, and which of their samples
// are bad (p × N each).
struct Material {
  std::vector<Record> parts;
  std::vector<Eigen::MatrixXd> bad;
};

Material MaterialOf(const std::vector<Record>& records,
                    const std::vector<bool>& usable, double most_samples) {
  std::vector<Record> good = records;
  std::vector<Record> marks = records;
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (int i = 0; i < records[r].num_outputs(); ++i) {
      Eigen::RowVectorXd bad = BadSamples(records[r].outputs.row(i));
      for (Eigen::Index k = 0; k < bad.size(); ++k) {
        if (bad(k) != 0.0) {
          good[r].outputs(i, k) = std::numeric_limits<double>::quiet_NaN();
        }
      }
      if (!usable[i]) bad.setOnes();
      marks[r].outputs.row(i) = bad;
    }
  }
  Material material{.parts = AroundSetPointChanges(good, most_samples),
                    .bad = {}};
  for (const Record& part : AroundSetPointChanges(marks, most_samples)) {
    material.bad.push_back(part.outputs);
  }
  return material;
}

class PlaySearch {
 public:
  PlaySearch(const ProcessModel& model, PlayRegression regression)
      : model_(model), regression_(std::move(regression)) {}

  absl::StatusOr<std::vector<StickingInput>> Run();

 private:
  int m() const { return model_.num_inputs(); }
  absl::Status AddPlays();
  // Of the plays that are not proved the weakest; false if all are. By the nats
  // of their own first, for which nothing is fitted.
  absl::StatusOr<bool> DropWeakest();
  absl::StatusOr<StickingInput> Describe(int input) const;

  const ProcessModel& model_;
  PlayRegression regression_;
  Eigen::VectorXd widths_;
  Eigen::VectorXd nats_;
};

absl::Status PlaySearch::AddPlays() {
  widths_ = Eigen::VectorXd::Zero(m());
  nats_ = Eigen::VectorXd::Zero(m());
  for (int round = 0; round < 3 * m(); ++round) {
    int input = -1;
    PlayScore best{.nats = kWorthTrying};
    MLE_ASSIGN_OR_RETURN(const std::vector<PlayScore> scores,
                         regression_.Scores());
    for (int j = 0; j < m(); ++j) {
      if (scores[j].nats <= best.nats) continue;
      best = scores[j];
      input = j;
    }
    if (input < 0) break;
    widths_(input) = best.width;
    MLE_RETURN_IF_ERROR(regression_.SetWidths(widths_));
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> PlaySearch::DropWeakest() {
  int weakest = -1;
  double least = 1.0;  // of what is needed
  const auto consider = [&](int input, double share) {
    if (share >= least) return;
    least = share;
    weakest = input;
  };
  for (int j = 0; j < m(); ++j) {
    if (widths_(j) == 0.0) continue;
    MLE_ASSIGN_OR_RETURN(const double own, regression_.OwnNats(j));
    consider(j, own / kLeastOwnNats);
  }
  // The rest costs a fit for each.
  const bool proved_so_far = weakest < 0;
  for (int j = 0; j < m() && proved_so_far; ++j) {
    if (widths_(j) == 0.0) continue;
    Eigen::VectorXd without = widths_;
    without(j) = 0.0;
    PlayRegression rival = regression_;
    MLE_RETURN_IF_ERROR(rival.SetWidths(without));
    MLE_ASSIGN_OR_RETURN(const PlayScore score, rival.Score(j));
    nats_(j) = regression_.GainOver(rival);
    const bool plausible = score.factor >= kLeastPlayFactor &&
                           score.factor <= kMostFactor &&
                           widths_(j) <= kMostShare * regression_.ranges()(j);
    consider(j, plausible ? std::min(nats_(j) / kLeastPlayNats,
                                     score.nats / kLeastScore)
                          : 0.0);
  }
  if (weakest >= 0) widths_(weakest) = 0.0;
  MLE_RETURN_IF_ERROR(regression_.SetWidths(widths_));
  return weakest >= 0;
}

// The best width near the one of the grid, by a parabola through the
// log-likelihoods of the best one tried and its neighbours.
absl::StatusOr<StickingInput> PlaySearch::Describe(int input) const {
  std::vector<std::pair<double, double>> tried;  // width, log-likelihood
  const auto add = [&](double factor) -> absl::Status {
    Eigen::VectorXd widths = widths_;
    widths(input) *= factor;
    MLE_ASSIGN_OR_RETURN(const double likelihood,
                         regression_.LogLikelihood(widths));
    tried.emplace_back(widths(input), likelihood);
    return absl::OkStatus();
  };
  MLE_RETURN_IF_ERROR(add(1.0));
  for (const double factor : kNearWidths) MLE_RETURN_IF_ERROR(add(factor));
  std::sort(tried.begin(), tried.end());
  const auto best = std::max_element(
      tried.begin(), tried.end(),
      [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto at = std::clamp(best, tried.begin() + 1, tried.end() - 2);
  const double left =
      (at->second - (at - 1)->second) / (at->first - (at - 1)->first);
  const double right =
      ((at + 1)->second - at->second) / ((at + 1)->first - at->first);
  const double span = ((at + 1)->first - (at - 1)->first) / 2.0;
  const double curvature = (left - right) / span;
  StickingInput found;
  found.input = input;
  found.width = best->first;
  found.error = best->first;
  if (curvature > 0.0) {
    const double middle = (at->first + (at - 1)->first) / 2.0;
    found.width = std::clamp(middle + left / curvature, tried.front().first,
                             tried.back().first);
    found.error = 1.0 / std::sqrt(curvature);
  }
  found.share = found.width / regression_.ranges()(input);
  found.log_likelihood = nats_(input);
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (!model_.element(i, input).IsZero()) found.outputs.push_back(i);
  }
  return found;
}

absl::StatusOr<std::vector<StickingInput>> PlaySearch::Run() {
  MLE_RETURN_IF_ERROR(AddPlays());
  while (!widths_.isZero()) {
    MLE_ASSIGN_OR_RETURN(const bool dropped, DropWeakest());
    if (!dropped) break;
  }
  std::vector<StickingInput> found;
  for (int j = 0; j < m(); ++j) {
    if (widths_(j) == 0.0) continue;
    MLE_ASSIGN_OR_RETURN(found.emplace_back(), Describe(j));
  }
  return found;
}

}  // namespace

std::string StickingInput::Describe(const ProcessModel& model) const {
  const InputChannel& channel = model.inputs()[input];
  const std::string unit =
      channel.unit.empty() ? "" : absl::StrCat(" ", channel.unit);
  std::vector<std::string> names;
  for (const int i : outputs) names.push_back(model.outputs()[i].name);
  return absl::StrFormat(
      "The valve of %s seems to stick: the plant does not follow its reversals "
      "within %.3g%s (standard error %.2g%s), %.2g %% of its range in the "
      "records. With such a play between the input recorded and the plant, the "
      "records are explained better by %.0f nats of log-likelihood than with "
      "any gains, dead times and time constants alone (outputs %s).",
      channel.name, width, unit, error, unit, 100.0 * share, log_likelihood,
      absl::StrJoin(names, ", "));
}

absl::StatusOr<std::vector<StickingInput>> FindStickingInputs(
    const ProcessModel& model, const std::vector<Record>& records,
    const std::vector<bool>& usable, int threads) {
  // Of all columns of each output with each other.
  const double elements = NumElements(model);
  const Material material =
      MaterialOf(records, usable,
                 kMostProducts * model.num_outputs() / elements / elements);
  double samples = 0.0;
  for (const Record& part : material.parts) samples += part.samples();
  if (samples < kLeastPlaySamples) return std::vector<StickingInput>();
  MLE_ASSIGN_OR_RETURN(
      PlayRegression regression,
      PlayRegression::Create(model, material.parts, material.bad, threads));
  if (regression.empty()) return std::vector<StickingInput>();
  return PlaySearch(model, std::move(regression)).Run();
}

void CorrectPlay(const StickingInput& sticking, std::vector<Record>& records) {
  for (Record& record : records) {
    // Where the input is not known, it is held.
    const Eigen::RowVectorXd asked =
        WithoutGaps(record).inputs.row(sticking.input);
    const Eigen::RowVectorXd valve = PassThroughPlay(asked, sticking.width);
    for (Eigen::Index k = 0; k < valve.size(); ++k) {
      double& input = record.inputs(sticking.input, k);
      if (std::isfinite(input)) input = valve(k);
    }
  }
}

}  // namespace mle
