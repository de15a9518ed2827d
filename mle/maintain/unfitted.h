// The stand-in for an estimate where nothing is estimated: the initial model,
// every element at its values.

#ifndef MLE_MAINTAIN_UNFITTED_H_
#define MLE_MAINTAIN_UNFITTED_H_

#include <vector>

#include "mle/correction/pair_information.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// Every element held, in noise that nothing is known of.
OutputErrorCorrection UnfittedStructure(const ProcessModel& initial);

// The estimate from windows that cannot be used: no change is proposed, and the
// model predicts as it is, or nothing where it cannot.
Estimate UnfittedEstimate(const ProcessModel& initial,
                          const std::vector<Record>& windows,
                          const EstimationOptions& options);

// No pair is determined.
PairInformation NoInformation(const ProcessModel& initial);

}  // namespace mle

#endif  // MLE_MAINTAIN_UNFITTED_H_
