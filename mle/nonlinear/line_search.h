// Periodic disturbances of one output: sines of one frequency each, whose
// amplitude and phase every segment has for itself. Internal to mle/nonlinear.
//
//   1. The periodogram of the whitened residuals of a fit,
//
//        I(f) = Σ_s 2 |Σ_k e_k exp(2πi f k)|² / (N_s v),
//
//      χ² with two degrees of freedom for each segment s (N_s samples, v their
//      variance) where there is no period; f from four cycles in the shortest
//      segment to four samples a cycle. The highest peak counts where its
//      probability, times the number of frequencies, is below 1e-4 (Fisher,
//      Proc. R. Soc. A 125, 1929, by Bonferroni's bound).
//   2. The frequency is refined by likelihood, with the noise shape estimated
//      beside it: a filter that follows the sine must not hide it.
//   3. The line is kept where −2 ln L falls by more than ln N for each of its
//      parameters (Schwarz), and by more than the inputs explain: a response to
//      them that the model lacks, expanded in sums over ranges of lags, must
//      not be taken for a period (each with Schwarz's price).

#ifndef MLE_NONLINEAR_LINE_SEARCH_H_
#define MLE_NONLINEAR_LINE_SEARCH_H_

#include <optional>
#include <vector>

#include "mle/nonlinear/extended_fit.h"

namespace mle {

struct FoundPeriod {
  double period = 0.0;  // in samples
  double gain = 0.0;    // of −2 ln L beyond its price, > 0
};

// The line that the residuals of the fit show; what its problem has already is
// fitted beside it.
std::optional<FoundPeriod> FindPeriod(const ExtendedFit& extended);

}  // namespace mle

#endif  // MLE_NONLINEAR_LINE_SEARCH_H_
