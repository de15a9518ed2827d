#include "sim/archive.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

std::vector<int> FiniteSamples(const RowVectorXd& series) {
  std::vector<int> samples;
  for (int k = 0; k < series.size(); ++k) {
    if (!std::isnan(series[k])) samples.push_back(k);
  }
  return samples;
}

// The samples that exception reporting sends on.
std::vector<int> Reported(const TagOptions& tag, const RowVectorXd& series,
                          const std::vector<int>& samples, double longest) {
  std::vector<int> reported;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int k = samples[i];
    if (!reported.empty()) {
      const int last = reported.back();
      if (std::abs(series[k] - series[last]) <= tag.exception &&
          k - last < longest) {
        continue;
      }
      if (samples[i - 1] != last) reported.push_back(samples[i - 1]);
    }
    reported.push_back(k);
  }
  return reported;
}

// The swinging door: of the slopes from the last archived point, those that
// miss no point since by more than the deviation lie in [low, high].
std::vector<int> Compressed(const TagOptions& tag, const RowVectorXd& series,
                            const std::vector<int>& samples, double longest) {
  std::vector<int> archived;
  double low = -kInfinity;
  double high = kInfinity;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int k = samples[i];
    if (archived.empty()) {
      archived.push_back(k);
      continue;
    }
    const auto slope = [&](double deviation) {
      const int last = archived.back();
      return (series[k] + deviation - series[last]) / (k - last);
    };
    if (slope(0.0) < low || slope(0.0) > high ||
        (k - archived.back() > longest && samples[i - 1] != archived.back())) {
      archived.push_back(samples[i - 1]);
      low = -kInfinity;
      high = kInfinity;
    }
    low = std::max(low, slope(-tag.compression));
    high = std::min(high, slope(tag.compression));
  }
  if (!samples.empty() && archived.back() != samples.back()) {
    archived.push_back(samples.back());
  }
  return archived;
}

// The archive's value at `at`, in samples.
double ValueAt(const TagOptions& tag, const RowVectorXd& series,
               const std::vector<int>& archived, double at) {
  const auto next = std::upper_bound(archived.begin(), archived.end(), at);
  if (next == archived.begin()) return series[archived.front()];
  const int before = *std::prev(next);
  if (next == archived.end() || tag.step || at == before) {
    return series[before];
  }
  const double part = (at - before) / (*next - before);
  return (1.0 - part) * series[before] + part * series[*next];
}

void ExportTag(const TagOptions& tag, double sample_time,
               Eigen::Ref<MatrixXd> rows) {
  RowVectorXd series = rows.row(tag.channel);
  for (const Spike& spike : tag.spikes) {
    const double sample = std::ceil(spike.time / sample_time - 1e-9);
    if (sample < 0.0 || sample >= static_cast<double>(series.size())) continue;
    series[static_cast<Index>(sample)] += spike.size;
  }
  const std::vector<int> archived = ArchivedSamples(tag, series, sample_time);
  if (archived.empty()) return;
  const double offset = tag.clock_offset / sample_time;
  const double whole = std::round(offset);
  const double shift = std::abs(offset - whole) < 1e-9 ? whole : offset;
  for (Index k = 0; k < series.size(); ++k) {
    if (std::isnan(series[k])) continue;
    rows(tag.channel, k) =
        ValueAt(tag, series, archived, static_cast<double>(k) - shift);
  }
}

absl::Status ValidateTags(const std::vector<TagOptions>& tags,
                          int num_channels) {
  for (const TagOptions& tag : tags) {
    MLE_RETURN_IF_ERROR(tag.Validate(num_channels));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status TagOptions::Validate(int num_channels) const {
  if (channel < 0 || channel >= num_channels) {
    return InvalidArgument("archive: channel = ", channel,
                           ", but it must be one of 0 … ", num_channels - 1);
  }
  MLE_RETURN_IF_ERROR(CheckNotNegative("exception", exception));
  MLE_RETURN_IF_ERROR(CheckNotNegative("compression", compression));
  if (!(max_interval > 0.0)) {
    return InvalidArgument("max_interval = ", max_interval,
                           ", but it must be > 0");
  }
  if (!std::isfinite(clock_offset)) {
    return InvalidArgument("clock_offset = ", clock_offset,
                           ", but it must be finite");
  }
  for (const Spike& spike : spikes) {
    if (std::isfinite(spike.time) && std::isfinite(spike.size)) continue;
    return InvalidArgument("spike: time = ", spike.time,
                           ", size = ", spike.size,
                           ", but both must be finite");
  }
  return absl::OkStatus();
}

absl::Status ArchiveOptions::Validate(int num_outputs, int num_inputs) const {
  MLE_RETURN_IF_ERROR(ValidateTags(outputs, num_outputs));
  return ValidateTags(inputs, num_inputs);
}

std::vector<int> ArchivedSamples(const TagOptions& tag,
                                 const RowVectorXd& series,
                                 double sample_time) {
  const double longest = tag.max_interval / sample_time * (1.0 + 1e-9);
  std::vector<int> samples = FiniteSamples(series);
  if (tag.exception > 0.0) samples = Reported(tag, series, samples, longest);
  if (tag.compression > 0.0) {
    samples = Compressed(tag, series, samples, longest);
  }
  return samples;
}

void ExportFromArchive(const ArchiveOptions& options, Record& record) {
  for (const TagOptions& tag : options.outputs) {
    ExportTag(tag, record.sample_time, record.outputs);
  }
  for (const TagOptions& tag : options.inputs) {
    ExportTag(tag, record.sample_time, record.inputs);
  }
}

}  // namespace mle::sim
