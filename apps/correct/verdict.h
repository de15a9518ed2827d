// The result in sentences.

#ifndef APPS_CORRECT_VERDICT_H_
#define APPS_CORRECT_VERDICT_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// "3.1×10⁻⁹"; what is too small for a double is below its smallest.
std::string FormatProbability(double p);

// Aged or not and how sure; which elements and by how much; what that is worth
// on what the fit had not seen; the distance to the truth where it is known.
std::vector<std::string> Verdict(const Result& result);

// How an element of the structured correction has changed: "gain 12.8 → 6.40 ±
// 0.02 (× 0.50), dead time + 0.1 ± 0.2 min".
std::string DescribeChange(const ElementEstimate& element,
                           const std::string& time_unit);

}  // namespace mle::correct

#endif  // APPS_CORRECT_VERDICT_H_
