// The result in sentences.

#ifndef APPS_CORRECT_VERDICT_H_
#define APPS_CORRECT_VERDICT_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// "3.1×10⁻⁹"; what is too small for a double is below its smallest.
std::string FormatProbability(double p);
// The same, but what is far below any level is not told apart: "< 10⁻⁹".
std::string ShortProbability(double p);

// Whether the initial value lies outside the estimate's interval.
bool HasMoved(const ParameterEstimate& estimate);

// Two sentences: aged or not, how sure and where; what that is worth on records
// that the fit had not seen, and so what to do.
std::vector<std::string> DescribeVerdict(const Result& result);

// What it rests on: every change of an element, fits of every output, the
// distance to the truth where it is known.
std::vector<Finding> Findings(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_VERDICT_H_
