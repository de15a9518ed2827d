// The corrected model as a discrete state-space model (balanced_reduction.h).
//
// A process model is reduced itself. Of an ARX model, the transfer functions
// nearest to it are (CorrectedModel, TransferFunctionsOf()), and what the
// result is held to are the ARX model's step responses.

#ifndef MLE_MAINTAIN_STATE_SPACE_FORM_H_
#define MLE_MAINTAIN_STATE_SPACE_FORM_H_

#include <optional>
#include <string>

#include "mle/maintain/corrected_model.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"

namespace mle {

struct StateSpaceForm {
  // With the model's names and its accuracy; absent where there is none within
  // ReductionOptions::tolerance. The error bounds of an ARX model are those to
  // `transfer_functions`.
  std::optional<NamedStateSpace> model;
  std::string reason;  // why there is none; empty where none is wanted

  // The largest over the outputs; 0 where there is no model.
  double error_bound() const;
  double largest_difference() const;
};

// `transfer_functions` as of TransferFunctionsOf(corrected); outputs are worked
// at by `threads` (0: one for each processor).
StateSpaceForm MakeStateSpaceForm(const ProcessModel& transfer_functions,
                                  const CorrectedModel& corrected,
                                  int threads = 1);

}  // namespace mle

#endif  // MLE_MAINTAIN_STATE_SPACE_FORM_H_
