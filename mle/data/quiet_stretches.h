// Where a record is quiet: no set point has changed for so long that the plant
// has settled, so that outputs show their noise and their drift alone.

#ifndef MLE_DATA_QUIET_STRETCHES_H_
#define MLE_DATA_QUIET_STRETCHES_H_

#include <vector>

#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// Samples first … last (both included) of records[record].
struct QuietStretch {
  int record = 0;
  int first = 0;
  int last = -1;

  int samples() const { return last - first + 1; }
};

// Dead time plus five times the slowest time constant of the slowest element:
// what is left of a step's response then is 0.7 % of it.
double SettlingTime(const ProcessModel& model);

// The stretches of at least `min_samples` that begin at a record's first sample
// or `settling` (≥ 0, in time units) after a change of set point, and end
// before the next. `changes` has those of each record, in order of time. A
// record without set-point changes is quiet throughout.
std::vector<QuietStretch> FindQuietStretches(
    const std::vector<Record>& records,
    const std::vector<std::vector<SetPointChange>>& changes, double settling,
    int min_samples);

}  // namespace mle

#endif  // MLE_DATA_QUIET_STRETCHES_H_
