#include "mle/data/stretches.h"

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

bool Adjoin(const StretchPart& before, const StretchPart& after) {
  return before.stretch == after.stretch &&
         before.first + before.samples == after.first;
}

int Stretches::WindowAt(int stretch, double time) const {
  int found = -1;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (windows[w].stretch != stretch) continue;
    const Record& record = records[stretch];
    const double begin = record.time(windows[w].first);
    if (found >= 0 && time < begin - 0.5 * record.sample_time) break;
    found = static_cast<int>(w);
  }
  return found;
}

Stretches JoinAdjoining(const std::vector<Record>& windows) {
  Stretches stretches;
  for (std::size_t first = 0; first < windows.size();) {
    const int stretch = static_cast<int>(stretches.records.size());
    std::size_t end = first;
    int sample = 0;
    do {
      const int samples = windows[end].samples();
      const int lead = windows[end].lead();
      stretches.windows.push_back({stretch, sample + lead, samples - lead});
      sample += samples;
      ++end;
    } while (end < windows.size() &&
             RecordsAdjoin(windows[end - 1], windows[end]));
    stretches.records.push_back(
        JoinRecords(std::span(windows).subspan(first, end - first)));
    first = end;
  }
  return stretches;
}

}  // namespace mle
