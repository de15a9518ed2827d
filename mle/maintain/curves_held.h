// Curves that won among the explanations, put into the model as transforms of
// its channels. Where they are right, the elements between transformed
// variables are linear, and are corrected as those of any model. Internal to
// mle/maintain.

#ifndef MLE_MAINTAIN_CURVES_HELD_H_
#define MLE_MAINTAIN_CURVES_HELD_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/explain/curves.h"
#include "mle/maintain/candidates.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Those that won, where nothing else explains as much, nothing misleads, and
// every output that shows one predicts blocks held out better.
std::vector<FoundCurve> CurvesToHold(const Candidates& candidates);

// A model with curves, the records in its variables.
struct BentPlant {
  ProcessModel model;
  RecordData data;
};

// Beside a transform that the model has, points of both are the transform, and
// the elements keep their meaning: they are the model at its operating point.
// InvalidArgument where the records have values that the curve does not.
absl::StatusOr<BentPlant> WithCurves(const ProcessModel& model,
                                     const RecordData& data,
                                     const std::vector<FoundCurve>& curves);

// Curves of later rounds upon those of the same channels, and beside others.
std::vector<FoundCurve> Upon(std::vector<FoundCurve> curves,
                             std::vector<FoundCurve> later);

}  // namespace mle

#endif  // MLE_MAINTAIN_CURVES_HELD_H_
