#include "mle/data/operation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

constexpr double kEqualSettings = 1e-9;  // of the range
constexpr int kLeastVisits = 3;
constexpr double kLongRuns = 10.0;
constexpr int kLeastAtLimit = 10;
constexpr double kLeastShare = 0.01;
constexpr double kElsewhere = 0.1;
constexpr int kLeastSplitMoves = 10;
constexpr double kSplitShare = 0.5;
constexpr double kFewestPerTimeConstant = 3.0;
constexpr double kMostPerTimeConstant = 500.0;
constexpr int kManyMoves = 50;
constexpr double kMovesPerSettling = 2.0;

struct Visits {
  int count = 0;
  int samples = 0;
  int longest = 0;

  bool IsLimit(double usual_run) const {
    return samples >= kLeastAtLimit &&
           (count >= kLeastVisits || longest > kLongRuns * usual_run);
  }
};

// To a value, of an input in all records.
Visits CountVisits(const std::vector<Record>& records, int input, double value,
                   double tolerance) {
  Visits visits;
  for (const Record& record : records) {
    int run = 0;
    for (const double sample : record.inputs.row(input)) {
      if (!std::isfinite(sample)) continue;
      const bool at = std::abs(sample - value) <= tolerance;
      visits.count += at && run == 0 ? 1 : 0;
      visits.samples += at ? 1 : 0;
      run = at ? run + 1 : 0;
      visits.longest = std::max(visits.longest, run);
    }
  }
  return visits;
}

// Samples for which an input usually keeps a value: the median.
double UsualRun(const std::vector<Record>& records, int input) {
  std::vector<double> runs;
  for (const Record& record : records) {
    double last = std::numeric_limits<double>::quiet_NaN();
    for (const double sample : record.inputs.row(input)) {
      if (!std::isfinite(sample)) continue;
      if (sample == last) {
        runs.back() += 1.0;
      } else {
        runs.push_back(1.0);
      }
      last = sample;
    }
  }
  return MedianInPlace(runs);
}

void CountMoves(const SampleRow& row, SplitMoves& moves) {
  const auto held = [&](Eigen::Index k) { return row(k) == row(k - 1); };
  for (Eigen::Index k = 2; k + 2 < row.size(); ++k) {
    const double step = row(k) - row(k - 1);
    if (step == 0.0 || !std::isfinite(step) || !held(k - 1)) continue;
    if (held(k + 1)) {
      ++moves.moves;
    } else if ((row(k + 1) - row(k)) * step > 0.0 && held(k + 2)) {
      ++moves.moves;
      ++moves.split;
    }
  }
}

}  // namespace

std::vector<TimeAtLimits> FindTimeAtLimits(const std::vector<Record>& records) {
  std::vector<TimeAtLimits> all;
  const int num_inputs = records.empty() ? 0 : records.front().num_inputs();
  for (int j = 0; j < num_inputs; ++j) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    double good = 0.0;
    for (const Record& record : records) {
      for (const double sample : record.inputs.row(j)) {
        if (!std::isfinite(sample)) continue;
        low = std::min(low, sample);
        high = std::max(high, sample);
        good += 1.0;
      }
    }
    if (!(high > low)) continue;
    const double tolerance = kEqualSettings * (high - low);
    const Visits at_low = CountVisits(records, j, low, tolerance);
    const Visits at_high = CountVisits(records, j, high, tolerance);
    const double usual = UsualRun(records, j);
    TimeAtLimits limits{.input = j, .low = low, .high = high};
    if (at_low.IsLimit(usual)) limits.share_low = at_low.samples / good;
    if (at_high.IsLimit(usual)) limits.share_high = at_high.samples / good;
    const double share = limits.share_low + limits.share_high;
    if (share >= kLeastShare && share <= 1.0 - kElsewhere) {
      all.push_back(limits);
    }
  }
  return all;
}

std::vector<SplitMoves> FindSplitMoves(const std::vector<Record>& records) {
  std::vector<SplitMoves> all;
  const int num_inputs = records.empty() ? 0 : records.front().num_inputs();
  for (int j = 0; j < num_inputs; ++j) {
    SplitMoves moves{.input = j};
    for (const Record& record : records)
      CountMoves(record.inputs.row(j), moves);
    if (moves.moves >= kLeastSplitMoves &&
        moves.split >= kSplitShare * moves.moves) {
      all.push_back(moves);
    }
  }
  return all;
}

std::vector<SamplingRate> FindUnusualSampling(const ProcessModel& model,
                                              double sample_time) {
  std::vector<SamplingRate> all;
  for (const auto& [i, j] : Pairs(model)) {
    const double samples =
        model.element(i, j).SlowestTimeConstant() / sample_time;
    if (samples > 0.0 &&
        (samples < kFewestPerTimeConstant || samples > kMostPerTimeConstant)) {
      all.push_back({i, j, samples});
    }
  }
  return all;
}

std::vector<ManyMoves> FindManySetPointMoves(const std::vector<Record>& records,
                                             const ProcessModel& model) {
  std::vector<std::vector<double>> sizes(model.num_outputs());
  double duration = 0.0;
  for (const Record& record : records) {
    duration += record.samples() * record.sample_time;
    for (const SetPointChange& change : FindSetPointChanges(record)) {
      sizes[change.output].push_back(std::abs(change.to - change.from));
    }
  }
  const double settlings = duration / SettlingTime(model);
  std::vector<ManyMoves> all;
  for (int i = 0; i < model.num_outputs(); ++i) {
    const int moves = static_cast<int>(sizes[i].size());
    if (moves > kManyMoves && moves > kMovesPerSettling * settlings) {
      all.push_back({i, moves, MedianInPlace(sizes[i])});
    }
  }
  return all;
}

}  // namespace mle
