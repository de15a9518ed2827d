// What may explain the records: the model as it was, the estimate by
// likelihood, and the competition of explanations. Internal to mle/maintain.
//
// The way of a correction is one of values, each made once and not edited
// afterwards:
//
//   RecordData   records examined and cut into windows (records.h)
//   Candidates   what may explain them (FindCandidates)
//   Validation   how the estimate predicts what it has not seen (validation.h)
//   Verdict      what is taken of it, and why (decision.h)
//   CorrectionResult   the model for use and all that is told (correct.h)

#ifndef MLE_MAINTAIN_CANDIDATES_H_
#define MLE_MAINTAIN_CANDIDATES_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/explain/competition.h"
#include "mle/maintain/correct.h"

namespace mle {

struct Candidates {
  ProcessModel initial;
  CorrectOptions options;
  RecordData given;             // before outliers were marked
  RecordData data;              // outliers marked
  std::vector<Record> windows;  // of `data`
  StepResponse initial_response;
  // Changes that are not worth making are left out: those that change no
  // element's response by more than decision.least_change, one by one where
  // they are parametric, output by output where they are ΔR's; an absent pair
  // counts by the largest response of its output.
  Estimate estimate;
  PairInformation information;
  // Nothing where the data forbid a correction, for the estimator arx, and
  // without CorrectOptions::examine.
  std::optional<Competition> competition;

  double sample_time() const { return data.sample_time(); }
  // Of the ARX model, and of the lags of diagnostics.
  int order() const {
    return options.estimation.conversion.OrderFor(initial, sample_time());
  }
};

// `data` have windows. Errors as of CorrectFromRecords().
absl::StatusOr<Candidates> FindCandidates(const ProcessModel& model,
                                          RecordData data,
                                          const CorrectOptions& options);

// The change of a gain that the records would have shown, as a share
// (DetectableGain() of correct.h); `explanations` may be empty.
double DetectableGain(const std::vector<OutputExplanation>& explanations,
                      const Estimate& estimate, int output, int input);

}  // namespace mle

#endif  // MLE_MAINTAIN_CANDIDATES_H_
