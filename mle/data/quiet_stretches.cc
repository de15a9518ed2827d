#include "mle/data/quiet_stretches.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"

namespace mle {

double SettlingTime(const ProcessModel& model) {
  double longest = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      longest = std::max(longest,
                         element.delay() + 5.0 * element.SlowestTimeConstant());
    }
  }
  return longest;
}

std::vector<QuietStretch> FindQuietStretches(
    const std::vector<Record>& records,
    const std::vector<std::vector<SetPointChange>>& changes, double settling,
    int min_samples) {
  CHECK_EQ(records.size(), changes.size());
  std::vector<QuietStretch> stretches;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const double wait = std::ceil(settling / records[r].sample_time - 1e-9);
    const int samples = records[r].samples();
    const int record = static_cast<int>(r);
    double first = 0.0;
    const auto end_before = [&](int end) {
      if (end - first >= std::max(min_samples, 1)) {
        stretches.push_back({record, static_cast<int>(first), end - 1});
      }
    };
    for (const SetPointChange& change : changes[r]) {
      end_before(change.sample);
      first = std::max(first, change.sample + wait);
    }
    end_before(samples);
  }
  return stretches;
}

}  // namespace mle
