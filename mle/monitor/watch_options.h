// Options of the watch of a model: the probability of a false alarm, the
// model's life, and which changes count.

#ifndef MLE_MONITOR_WATCH_OPTIONS_H_
#define MLE_MONITOR_WATCH_OPTIONS_H_

#include "absl/status/status.h"

namespace mle {

struct WatchOptions {
  // α in (0, 1): the probability of ever raising an alarm on a model that does
  // not change, over all its outputs and elements and its whole life.
  double level = 0.05;
  // Batches over which a change may begin, ≥ 64: the life that `level` is of,
  // 10 years of days. Later ones add evidence of changes that began before.
  int life = 3650;
  // Relative changes of a gain, a time constant or a dead time up to this are
  // no change, in [0, 0.5).
  double least_change = 0.005;
  // Standard deviation beforehand of the relative errors that the model's
  // parameters have when the watch begins, in (0, 10]: these are not changes.
  double model_error = 0.05;
  // Standard deviation beforehand of the relative change of what has changed,
  // in (0, 10].
  double change_deviation = 0.3;
  // Innovations count up to this, in robust standard deviations, ≥ 2: single
  // outliers say nothing of a model.
  double clip = 4.0;
  // A batch is disturbed where the mean square of its innovations, less what a
  // change of the model could explain, exceeds this, > 1, of that of the
  // reference.
  double disturbed = 2.5;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

}  // namespace mle

#endif  // MLE_MONITOR_WATCH_OPTIONS_H_
