// Options of a trial of a model beside the one in use.

#ifndef MLE_TRIAL_TRIAL_OPTIONS_H_
#define MLE_TRIAL_TRIAL_OPTIONS_H_

#include "absl/status/status.h"

namespace mle {

struct TrialOptions {
  // α in (0, 1): the probability of ever adopting a model that is no better, of
  // dropping one that is no worse in any output, and of rolling back to one
  // that is no better, each.
  double level = 0.01;
  // κ > 0: adopted is a model that leaves at most this share of what set points
  // drive of the residuals of the model in use. One with twice the true change
  // leaves as much, one with half of it a quarter.
  double left_share = 0.05;
  // Responses to changes of set points that a decision rests on, ≥ 2.
  int least_changes = 2;
  // A model that is not adopted by then is dropped, ≥ least_changes.
  int most_changes = 30;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_OPTIONS_H_
