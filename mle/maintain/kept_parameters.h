// Parameters of a correction that have not changed keep the model's values.
//
// Of an element that has aged a parameter whose interval has the model's value
// in it is held there, and the others of the output take the values that the
// estimate gives them then. With the parameters S that are held, the others F,
// values θ̂ with covariance C, and the model's values θ₀,
//
//   θ_F = θ̂_F − C_FS C_SS⁻¹ (θ̂_S − θ₀_S).
//
// Intervals keep their widths, and those of S their places: what was not seen
// to change may have changed by as much as they say. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_KEPT_PARAMETERS_H_
#define MLE_MAINTAIN_KEPT_PARAMETERS_H_

#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// An element of which nothing would be left to change is left as it is, and so
// is an output of which a time would be negative or a gain change its sign.
void KeepUnchangedParameters(OutputErrorFit& fit);

}  // namespace mle

#endif  // MLE_MAINTAIN_KEPT_PARAMETERS_H_
