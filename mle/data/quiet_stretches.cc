#include "mle/data/quiet_stretches.h"

#include <algorithm>

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

}  // namespace mle
