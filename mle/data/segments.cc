#include "mle/data/segments.h"

#include <cmath>
#include <span>

namespace mle {
namespace {

constexpr double kSampleTolerance = 1e-6;  // of a sample

bool RecordsAdjoin(const Record& before, const Record& after) {
  return before.sample_time == after.sample_time &&
         before.num_outputs() == after.num_outputs() &&
         before.num_inputs() == after.num_inputs() &&
         before.set_points.rows() == after.set_points.rows() &&
         std::abs(before.time(before.samples()) - after.start_time) <=
             kSampleTolerance * before.sample_time;
}

}  // namespace

bool Adjoin(const SegmentPart& before, const SegmentPart& after) {
  return before.segment == after.segment &&
         before.first + before.samples == after.first;
}

int Segments::WindowAt(int segment, double time) const {
  int found = -1;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (windows[w].segment != segment) continue;
    const Record& record = records[segment];
    const double begin = record.time(windows[w].first);
    if (found >= 0 && time < begin - 0.5 * record.sample_time) break;
    found = static_cast<int>(w);
  }
  return found;
}

Segments JoinAdjoining(const std::vector<Record>& windows) {
  Segments segments;
  for (std::size_t first = 0; first < windows.size();) {
    const int segment = static_cast<int>(segments.records.size());
    std::size_t end = first;
    int sample = 0;
    do {
      const int samples = windows[end].samples();
      const int lead = windows[end].lead();
      segments.windows.push_back({segment, sample + lead, samples - lead});
      sample += samples;
      ++end;
    } while (end < windows.size() &&
             RecordsAdjoin(windows[end - 1], windows[end]));
    segments.records.push_back(
        JoinRecords(std::span(windows).subspan(first, end - first)));
    first = end;
  }
  return segments;
}

}  // namespace mle
