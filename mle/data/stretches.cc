#include "mle/data/stretches.h"

#include <cmath>

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

// Windows first … end − 1 side by side.
Record Joined(const std::vector<Record>& windows, std::size_t first,
              std::size_t end) {
  Record all = windows[first];
  if (end == first + 1) return all;
  int samples = 0;
  for (std::size_t w = first; w < end; ++w) samples += windows[w].samples();
  const auto join = [&](Eigen::MatrixXd Record::*rows) {
    if ((all.*rows).rows() == 0) return;
    (all.*rows).resize(Eigen::NoChange, samples);
    Eigen::Index column = 0;
    for (std::size_t w = first; w < end; ++w) {
      const Eigen::MatrixXd& part = windows[w].*rows;
      (all.*rows).middleCols(column, part.cols()) = part;
      column += part.cols();
    }
  };
  join(&Record::outputs);
  join(&Record::inputs);
  join(&Record::set_points);
  return all;
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
    stretches.records.push_back(Joined(windows, first, end));
    first = end;
  }
  return stretches;
}

}  // namespace mle
