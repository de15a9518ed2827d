// The likeliest AR component (ar_component.h) of one order, beside white noise
// and a random walk. Internal to mle/nonlinear and mle/filter.
//
// From the best of a coarse grid, or from an AR component that is known, Nelder
// and Mead's simplex (Computer Journal 7, 1965) moves ln ρ, ln σ, ln 1/ω and,
// of second order, ln ζ. An AR component of first order that is slower than a
// third of the shortest segment is not told from a walk. One behind a lag is,
// by the lag; its slow pole may be three times as slow as a segment is long.

#ifndef MLE_NONLINEAR_AR_SEARCH_H_
#define MLE_NONLINEAR_AR_SEARCH_H_

#include "mle/nonlinear/noise_search.h"

namespace mle {

// `walk`: the likeliest shape without an AR component. The simplex is left out
// where nothing of the grid is better than it.
Profile FindBestAr(const ShapeLikelihood& likelihood, int order,
                   const Profile& walk);

// The best AR component of the order that `start` has.
Profile ContinueAr(const ShapeLikelihood& likelihood, const NoiseShape& start);

}  // namespace mle

#endif  // MLE_NONLINEAR_AR_SEARCH_H_
