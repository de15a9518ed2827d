// Options of a trial, and what it says of a model after the responses to
// changes of set points that it has seen (model_trial.h).

#ifndef MLE_TRIAL_TRIAL_VERDICT_H_
#define MLE_TRIAL_TRIAL_VERDICT_H_

#include <string_view>
#include <vector>

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

// A response to a change of set points, or to several that came in it.
struct TrialResponse {
  double time = 0.0;  // of its end
  int changes = 1;    // of set points
  // Of each output whose model changes: D, zᵀWz, σ(D); what set points drive of
  // the residuals of the model in use and of the proposed one.
  std::vector<double> gains = {};
  std::vector<double> sizes = {};
  std::vector<double> deviations = {};
  std::vector<double> in_use = {};
  std::vector<double> proposed = {};
  int shapes = 0;  // of set points, in all outputs that could be compared

  // Whether there was noise at rest to compare it with, and z.
  bool judged() const;
  double difference() const;  // X; 0 where it is not judged
  double size() const;        // Σ zᵀWz / Σ σ(D)
  bool operator==(const TrialResponse&) const = default;
};

enum class TrialAdvice { kWait, kAdopt, kDrop, kKeep, kRollBack };

// "wait", "adopt", "drop", "keep", "roll_back".
std::string_view NameOf(TrialAdvice advice);

// After a response.
struct TrialEvidencePoint {
  double time = 0.0;
  double log_for = 0.0;      // ln E for the proposed model
  double log_against = 0.0;  // ln E against it
};

struct TrialVerdict {
  TrialAdvice advice = TrialAdvice::kWait;
  std::vector<TrialEvidencePoint> evidence;
  int changes = 0;     // of set points with their whole response
  int responses = 0;   // that they are
  int not_judged = 0;  // of these
  // The share of what set points drive of the residuals of the model in use
  // that the proposed one leaves, and its standard error by noise; 1 where they
  // drive nothing.
  double left_share = 1.0;
  double left_error = 0.0;
  // The same in the records before the trial; 0 where these had no responses.
  double left_before = 0.0;
  double left_before_error = 0.0;
};

// Of the responses since the trial began, or since the model was adopted.
// `learned`: those of the records before.
TrialVerdict JudgeResponses(const std::vector<TrialResponse>& responses,
                            const std::vector<TrialResponse>& learned,
                            bool adopted, const TrialOptions& options);

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_VERDICT_H_
