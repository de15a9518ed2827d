#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "mle/data/channel_health.h"

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

}  // namespace

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
