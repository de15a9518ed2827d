#include "mle/data/empty_cells.h"

#include <algorithm>

#include "mle/data/record_rows.h"

namespace mle {
namespace {

constexpr std::int64_t kFewestRows = 20;
constexpr double kMostlyEmpty = 0.5;
constexpr double kFewEmptyRows = 0.01;

}  // namespace

void EmptyCells::Add(const std::vector<double>& values) {
  channels_.resize(values.size());
  bool is_empty = true;
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (IsNoSample(values[v])) continue;
    is_empty = false;
    Channel& channel = channels_[v];
    if (channel.samples > 0) {
      const std::int64_t distance = rows_ - channel.last;
      channel.longest = std::max(channel.longest, distance);
      channel.shortest = channel.samples == 1
                             ? distance
                             : std::min(channel.shortest, distance);
    }
    ++channel.samples;
    channel.last = rows_;
  }
  if (is_empty) ++empty_rows_;
  ++rows_;
}

double EmptyCells::share() const {
  std::int64_t samples = 0;
  std::int64_t cells = 0;
  for (const Channel& channel : channels_) {
    if (channel.samples == 0) continue;
    samples += channel.samples;
    cells += rows_;
  }
  return cells == 0
             ? 0.0
             : 1.0 - static_cast<double>(samples) / static_cast<double>(cells);
}

bool EmptyCells::MeanUnchanged() const {
  int sparse = 0;
  int uneven = 0;
  for (const Channel& channel : channels_) {
    if (channel.samples < 3 || 2 * channel.samples > rows_) continue;
    ++sparse;
    if (channel.longest >= 2 * channel.shortest) ++uneven;
  }
  return rows_ >= kFewestRows && share() >= kMostlyEmpty &&
         static_cast<double>(empty_rows_) <=
             kFewEmptyRows * static_cast<double>(rows_) &&
         sparse > 0 && 2 * uneven > sparse;
}

}  // namespace mle
