// Options of a trial of a model beside the one in use.

#ifndef MLE_TRIAL_TRIAL_OPTIONS_H_
#define MLE_TRIAL_TRIAL_OPTIONS_H_

#include "absl/status/status.h"

namespace mle {

struct TrialOptions {
  // α in (0, 1): the probability of ever adopting, dropping or rolling back
  // where the mean of the differences says the opposite.
  double level = 0.01;
  // γ in [0.5, 1): the share of the proposed change that must be right. At 0.5
  // a change of twice the true size is as good as none.
  double right_share = 0.6;
  // κ > 0: adopted is a model that leaves at most this share of what set points
  // drive of the residuals of the model in use.
  double left_share = 0.2;
  // Responses to changes of set points that a decision rests on, ≥ 2.
  int least_changes = 2;
  // A model that is not adopted by then is dropped, ≥ least_changes.
  int most_changes = 30;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_OPTIONS_H_
