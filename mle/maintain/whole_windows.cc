#include "mle/maintain/whole_windows.h"

#include <utility>
#include <vector>

namespace mle {

std::vector<SampleRange> WholeParts(const Record& record, int samples) {
  std::vector<SampleRange> parts;
  int first = 0;
  for (int k = 0; k <= record.samples(); ++k) {
    if (k < record.samples() && record.inputs.col(k).array().isFinite().all()) {
      continue;
    }
    if (k > first && k - first >= samples) parts.push_back({first, k - 1});
    first = k + 1;
  }
  return parts;
}

SampleRange WholeInputs(const Record& record) {
  SampleRange best;
  for (const SampleRange& part : WholeParts(record, 1)) {
    if (part.samples() > best.samples()) best = part;
  }
  return best;
}

void Cut(SampleRange range, SetPointWindow& window) {
  window.record = PartOf(window.record, range.first, range.samples());
  window.first_sample += range.first;
  std::vector<SetPointChange> changes;
  for (SetPointChange change : window.changes) {
    change.sample -= range.first;
    if (change.sample >= 0 && change.sample < range.samples()) {
      changes.push_back(change);
    }
  }
  window.changes = std::move(changes);
}

SetPointWindow WholeWindow(const Record& record, std::size_t source) {
  SetPointWindow window;
  window.record = record;
  window.source = static_cast<int>(source);
  window.changes = FindChanges({record}, WindowOptions()).front();
  return window;
}

}  // namespace mle
