#include "mle/data/channel_health.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/data/outliers.h"
#include "mle/data/robust_statistics.h"

namespace mle {
namespace {

constexpr std::size_t kShownRuns = 5;

int SamplesIn(const std::vector<SampleRun>& runs) {
  int samples = 0;
  for (const SampleRun& run : runs) samples += run.samples;
  return samples;
}

std::string ShowRuns(const std::vector<SampleRun>& runs,
                     const std::vector<Record>& records,
                     const TimeNames& times) {
  std::string text;
  for (std::size_t r = 0; r < std::min(runs.size(), kShownRuns); ++r) {
    const SampleRun& run = runs[r];
    const Record& record = records[run.record];
    absl::StrAppend(&text, r > 0 ? ", " : "",
                    times.Short(record.time(run.first)));
    if (run.samples > 1) {
      absl::StrAppend(&text, " … ",
                      times.Short(record.time(run.first + run.samples - 1)));
    }
  }
  if (runs.size() > kShownRuns) text += ", …";
  return text;
}

// Means of equal samples differ by rounding.
constexpr double kEqualSamples = 1e-12;
// Probability that a freeze is found in a record where there is none.
constexpr double kFalseFreeze = 1e-4;
// A smooth signal that has settled still changes by up to this share of its
// largest sample.
constexpr double kNoMovement = 1e-9;
constexpr double kMovement = 1e-6;  // a moving one by more
constexpr int kLongRun = 20;        // kept out of the share of repeated samples
// Saturation lasts this many times longer than the channel's usual holding.
constexpr double kHoldFactor = 3.0;
constexpr int kMinSaturated = 10;

bool Same(double a, double b, double scale) {
  return std::abs(a - b) <= kEqualSamples * scale;
}

double ScaleOf(const SampleRow& row) {
  double scale = 0.0;
  for (const double value : row) {
    if (std::isfinite(value)) scale = std::max(scale, std::abs(value));
  }
  return scale;
}

// A run of samples of which those that are good are equal.
struct EqualRun {
  SampleRun extent;  // from its first good sample to its last
  int good = 0;
};

std::vector<EqualRun> RunsOf(const SampleRow& row, int record) {
  std::vector<EqualRun> runs;
  const double scale = ScaleOf(row);
  const int n = static_cast<int>(row.size());
  for (int k = 0; k < n; ++k) {
    if (!std::isfinite(row(k))) continue;
    const bool goes_on =
        !runs.empty() && Same(row(k), row(runs.back().extent.first), scale);
    if (!goes_on) runs.push_back({{record, k, 0}, 0});
    runs.back().extent.samples = k - runs.back().extent.first + 1;
    ++runs.back().good;
  }
  return runs;
}

// In the second half of the run: what came before may still be settling.
bool Moves(const SampleRow& row, const SampleRun& run) {
  double first = kNaN;
  const double scale = ScaleOf(row.segment(run.first, run.samples));
  const int end = run.first + run.samples;
  for (int k = run.first + run.samples / 2; k < end; ++k) {
    if (!std::isfinite(row(k))) continue;
    if (!std::isfinite(first)) first = row(k);
    if (std::abs(row(k) - first) > kNoMovement * scale) return true;
  }
  return false;
}

// The run ends a movement, rather than what had come to rest.
bool StopsShort(const SampleRow& row, const SampleRun& run) {
  if (run.first == 0 || !std::isfinite(row(run.first - 1))) return false;
  return std::abs(row(run.first) - row(run.first - 1)) >
         kMovement * ScaleOf(row);
}

// A channel other than this one moves during the run.
bool OthersMove(const Record& record, const SampleRun& run, bool is_output,
                int channel) {
  for (int i = 0; i < record.num_outputs(); ++i) {
    if (is_output && i == channel) continue;
    if (Moves(record.outputs.row(i), run)) return true;
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    if (!is_output && j == channel) continue;
    if (Moves(record.inputs.row(j), run)) return true;
  }
  return false;
}

// There is more noise than movement: what differs between neighbours changes
// its sign from one to the next.
bool IsNoisy(const SampleRow& row) {
  std::vector<double> first;
  std::vector<double> second;
  const double least = kNoMovement * ScaleOf(row);
  for (Eigen::Index k = 2; k < row.size(); ++k) {
    const double step = row(k) - row(k - 1);
    const double before = row(k - 1) - row(k - 2);
    if (!std::isfinite(step) || !std::isfinite(before)) continue;
    if (std::abs(step) <= least || std::abs(before) <= least) continue;
    first.push_back(std::abs(step));
    second.push_back(std::abs(step - before));
  }
  return !first.empty() && MedianInPlace(second) > MedianInPlace(first);
}

// How long a run has to be before chance does not explain it: neighbours are
// equal with the probability that they have outside long runs.
double FreezeLength(const std::vector<EqualRun>& runs, int min_samples) {
  double repeated = 0.0;
  double steps = 0.0;
  double samples = 0.0;
  std::vector<double> lengths;
  for (const EqualRun& run : runs) {
    samples += run.good;
    lengths.push_back(run.good);
    if (run.good >= std::max(kLongRun, 2 * min_samples)) continue;
    repeated += run.good - 1;
    steps += run.good;
  }
  if (steps == 0.0) return std::numeric_limits<double>::infinity();
  const double share =
      std::clamp((repeated + 1.0) / (steps + 2.0), 1e-6, 1.0 - 1e-9);
  const double by_chance =
      2.0 + std::log(kFalseFreeze / std::max(samples, 1.0)) / std::log(share);
  // A channel that is updated every so often holds its values in between.
  return std::max({static_cast<double>(min_samples), by_chance,
                   kHoldFactor * MedianInPlace(lengths)});
}

// `rows`: of the output in each record, without its outliers.
void FindFrozen(const std::vector<Record>& records,
                const std::vector<Eigen::RowVectorXd>& rows,
                const HealthOptions& options, ChannelHealth& health) {
  std::vector<EqualRun> runs;
  bool noisy = false;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::vector<EqualRun> found = RunsOf(rows[r], static_cast<int>(r));
    runs.insert(runs.end(), found.begin(), found.end());
    noisy = noisy || IsNoisy(rows[r]);
  }
  const double longest = FreezeLength(runs, options.min_frozen_samples);
  for (const EqualRun& run : runs) {
    if (run.good <= longest) continue;
    const SampleRun& extent = run.extent;
    if (noisy ||
        (StopsShort(rows[extent.record], extent) &&
         OthersMove(records[extent.record], extent, true, health.channel))) {
      health.frozen.push_back(extent);
    }
  }
}

void FindSaturated(const std::vector<Record>& records, int input,
                   const HealthOptions& options, ChannelHealth& health) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::vector<SampleRun> runs;
  std::vector<double> lengths;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const auto row = records[r].inputs.row(input);
    for (const EqualRun& run : RunsOf(row, static_cast<int>(r))) {
      low = std::min(low, row(run.extent.first));
      high = std::max(high, row(run.extent.first));
      runs.push_back(run.extent);
      lengths.push_back(run.extent.samples);
    }
  }
  if (runs.empty()) return;
  const double usual = MedianInPlace(lengths);
  const double range = high - low;
  const auto limit = [&](const Eigen::VectorXd& limits) {
    return input < limits.size() ? limits(input) : kNaN;
  };
  const double min = limit(options.input_min);
  const double max = limit(options.input_max);
  for (const SampleRun& run : runs) {
    const Record& record = records[run.record];
    const double value = record.inputs(input, run.first);
    const bool at_limit =
        value <= min + 1e-9 * range || value >= max - 1e-9 * range;
    const bool at_end = Same(value, low, range) || Same(value, high, range);
    const bool is_long =
        run.samples >= kMinSaturated && run.samples > kHoldFactor * usual;
    if (at_limit || (!health.is_constant && at_end && is_long &&
                     OthersMove(record, run, false, input))) {
      health.saturated.push_back(run);
    }
  }
}

// Single samples that leave a value which two samples before and two after
// hold.
void FindInputOutliers(const Record& record, int record_index, int input,
                       std::vector<SampleRun>& outliers) {
  const auto row = record.inputs.row(input);
  const double scale = ScaleOf(row);
  for (int k = 2; k + 2 < record.samples(); ++k) {
    const double held = row(k - 1);
    if (std::isfinite(row(k)) && !Same(row(k), held, scale) &&
        Same(row(k - 2), held, scale) && Same(row(k + 1), held, scale) &&
        Same(row(k + 2), held, scale)) {
      outliers.push_back({record_index, k, 1});
    }
  }
}

bool IsConstant(const std::vector<Record>& records, bool is_output,
                int channel) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Record& record : records) {
    const Eigen::MatrixXd& rows = is_output ? record.outputs : record.inputs;
    for (const double value : rows.row(channel)) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return low <= high &&
         high - low <= kEqualSamples * std::max(std::abs(low), std::abs(high));
}

ChannelHealth CheckChannel(const std::vector<Record>& records,
                           const HealthOptions& options, bool is_output,
                           int channel) {
  ChannelHealth health;
  health.is_output = is_output;
  health.channel = channel;
  std::vector<double> noises;
  std::vector<SampleRow> rows;
  for (const Record& record : records) {
    const Eigen::MatrixXd& all = is_output ? record.outputs : record.inputs;
    rows.emplace_back(all.row(channel));
    health.samples += record.samples();
    health.bad += static_cast<int>(record.samples() -
                                   all.row(channel).array().isFinite().count());
    noises.push_back(WhiteDeviation(rows.back()));
  }
  health.is_constant = IsConstant(records, is_output, channel);
  if (health.is_constant) return health;
  health.noise = MedianInPlace(noises);
  health.quantum = FindQuantum(rows, health.noise);
  if (!is_output) {
    FindSaturated(records, channel, options, health);
    for (std::size_t r = 0; r < records.size(); ++r) {
      FindInputOutliers(records[r], static_cast<int>(r), channel,
                        health.outliers);
    }
    return health;
  }
  std::vector<Eigen::RowVectorXd> cleaned;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    cleaned.emplace_back(rows[r]);
    for (const int k : FindOutliers(rows[r], options.outliers)) {
      health.outliers.push_back({static_cast<int>(r), k, 1});
      cleaned.back()(k) = kNaN;
    }
  }
  FindFrozen(records, cleaned, options, health);
  if (health.frozen.empty()) return health;
  // Frozen samples show no noise: it is estimated again without them.
  noises.clear();
  for (const SampleRun& run : health.frozen) {
    cleaned[run.record].segment(run.first, run.samples).setConstant(kNaN);
  }
  for (const Eigen::RowVectorXd& row : cleaned) {
    if (row.array().isFinite().any()) noises.push_back(WhiteDeviation(row));
  }
  if (!noises.empty()) health.noise = MedianInPlace(noises);
  return health;
}

}  // namespace

HealthReport CheckHealth(const std::vector<Record>& records,
                         const ProcessModel& model,
                         const HealthOptions& options) {
  HealthReport report;
  for (int i = 0; i < model.num_outputs(); ++i) {
    report.channels.push_back(CheckChannel(records, options, true, i));
    report.channels.back().name = model.outputs()[i].name;
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    report.channels.push_back(CheckChannel(records, options, false, j));
    report.channels.back().name = model.inputs()[j].name;
  }
  return report;
}

int MarkBad(const HealthReport& report, const MarkOptions& options,
            std::vector<Record>& records) {
  int marked = 0;
  for (const ChannelHealth& channel : report.channels) {
    const auto mark = [&](const SampleRun& run, int skip) {
      Record& record = records[run.record];
      Eigen::MatrixXd& rows =
          channel.is_output ? record.outputs : record.inputs;
      for (int k = run.first + skip; k < run.first + run.samples; ++k) {
        marked += std::isfinite(rows(channel.channel, k)) ? 1 : 0;
        // An input that is held on both sides is known in between.
        rows(channel.channel, k) =
            channel.is_output ? kNaN : rows(channel.channel, k - 1);
      }
    };
    if (options.outliers) {
      for (const SampleRun& run : channel.outliers) mark(run, 0);
    }
    if (options.frozen) {
      for (const SampleRun& run : channel.frozen) mark(run, 1);
    }
  }
  return marked;
}

int ChannelHealth::frozen_samples() const { return SamplesIn(frozen); }

int ChannelHealth::saturated_samples() const { return SamplesIn(saturated); }

bool ChannelHealth::is_healthy() const {
  return bad == 0 && !is_constant && frozen.empty() && saturated.empty() &&
         quantum == 0.0 && outliers.empty();
}

std::string ChannelHealth::Report(const std::vector<Record>& records,
                                  const TimeNames& times) const {
  std::string text;
  const auto line = [&](const auto&... parts) {
    absl::StrAppend(&text, name, ": ", parts..., "\n");
  };
  if (bad > 0) line(bad, " of ", samples, " samples are bad");
  if (is_constant) line("does not move at all");
  if (!frozen.empty()) {
    line("frozen for ", frozen_samples(), " samples in ", frozen.size(),
         " places: ", ShowRuns(frozen, records, times));
  }
  if (!saturated.empty()) {
    line("at a limit, or not under control, for ", saturated_samples(),
         " samples in ", saturated.size(),
         " places: ", ShowRuns(saturated, records, times));
  }
  if (quantum > 0.0) {
    line("rounded to multiples of ", quantum, "; its noise is ", noise);
  }
  if (!outliers.empty()) {
    line(outliers.size(), " outliers: ", ShowRuns(outliers, records, times));
  }
  return text;
}

std::string HealthReport::Report(const std::vector<Record>& records) const {
  std::string text;
  for (const ChannelHealth& channel : channels) text += channel.Report(records);
  return text.empty() ? "nothing is wrong with the channels\n" : text;
}

}  // namespace mle
