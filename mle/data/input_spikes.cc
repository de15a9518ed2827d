#include "mle/data/input_spikes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

constexpr int kLongestPeriod = 100;
constexpr double kOnGrid = 0.9;  // share of moves at the period's instants
constexpr int kLeastSpikeMoves = 20;
constexpr double kUnusual = 5.0;
constexpr double kOfAMove = 0.5;
constexpr double kPercentile = 0.99;
constexpr int kKickSamples = 2;  // after a change of set point
// Fewer excursions than this say nothing of what is usual.
constexpr std::size_t kLeastExcursions = 20;

double Quantile(std::vector<double>& values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(
      share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

// By how much sample k is beyond both its neighbours; 0 if it is not.
double Excursion(const SampleRow& row, Eigen::Index k) {
  const double before = row(k) - row(k - 1);
  const double after = row(k) - row(k + 1);
  if (!(before * after > 0.0)) return 0.0;
  return std::min(std::abs(before), std::abs(after));
}

std::vector<int> MovesOf(const SampleRow& row) {
  std::vector<int> moves;
  for (Eigen::Index k = 1; k < row.size(); ++k) {
    if (std::isfinite(row(k)) && std::isfinite(row(k - 1)) &&
        row(k) != row(k - 1)) {
      moves.push_back(static_cast<int>(k));
    }
  }
  return moves;
}

// A change of set point at this sample or up to kKickSamples before.
std::vector<bool> Kicks(const Record& record) {
  std::vector<bool> kicks(record.samples(), false);
  for (const SetPointChange& change : FindSetPointChanges(record)) {
    const int end =
        std::min(record.samples(), change.sample + kKickSamples + 1);
    for (int k = change.sample; k < end; ++k) kicks[k] = true;
  }
  return kicks;
}

// Excursions larger than this are spikes, with a period of one sample.
double UnusualExcursion(const SampleRow& row, const std::vector<int>& moves) {
  std::vector<double> excursions;
  for (Eigen::Index k = 1; k + 1 < row.size(); ++k) {
    const double excursion = Excursion(row, k);
    if (excursion > 0.0) excursions.push_back(excursion);
  }
  if (excursions.size() >= kLeastExcursions) {
    return kUnusual * Quantile(excursions, kPercentile);
  }
  std::vector<double> sizes;
  for (const int k : moves) sizes.push_back(std::abs(row(k) - row(k - 1)));
  return kUnusual * Quantile(sizes, kPercentile);
}

}  // namespace

int MovePeriod(const Record& record, int input, int& phase) {
  const std::vector<int> moves = MovesOf(record.inputs.row(input));
  phase = 0;
  if (moves.size() < kLeastSpikeMoves) return 1;
  const auto longest = static_cast<int>(std::min<std::size_t>(
      kLongestPeriod,
      static_cast<std::size_t>(record.samples()) / moves.size() + 1));
  for (int period = longest; period >= 2; --period) {
    std::vector<int> counts(period, 0);
    for (const int k : moves) ++counts[k % period];
    const auto most = std::max_element(counts.begin(), counts.end());
    if (*most < kOnGrid * static_cast<double>(moves.size())) continue;
    phase = static_cast<int>(most - counts.begin());
    return period;
  }
  return 1;
}

std::vector<InputSpike> FindInputSpikes(const Record& record, int input) {
  std::vector<InputSpike> spikes;
  const SampleRow row = record.inputs.row(input);
  const std::vector<int> moves = MovesOf(row);
  if (moves.empty()) return spikes;
  int phase = 0;
  const int period = MovePeriod(record, input, phase);
  const std::vector<bool> kicks = Kicks(record);
  double least = 0.0;
  if (period > 1) {
    std::vector<double> sizes;
    for (const int k : moves) sizes.push_back(std::abs(row(k) - row(k - 1)));
    least = kOfAMove * MedianInPlace(sizes);
  } else {
    least = UnusualExcursion(row, moves);
  }
  for (int k = 1; k + 1 < record.samples(); ++k) {
    if (!(Excursion(row, k) > least) || (period == 1 && kicks[k])) continue;
    const bool at_instant = period > 1 && (k - phase) % period == 0;
    const double usual = period == 1  ? 0.5 * (row(k - 1) + row(k + 1))
                         : at_instant ? row(k + 1)
                                      : row(k - 1);
    const InputSpike spike{k, row(k), usual};
    const bool adjacent = !spikes.empty() && spikes.back().sample == k - 1;
    // Beside a spike a move looks like one.
    if (!adjacent) {
      spikes.push_back(spike);
    } else if (Excursion(row, k) > Excursion(row, k - 1)) {
      spikes.back() = spike;
    }
  }
  return spikes;
}

}  // namespace mle
