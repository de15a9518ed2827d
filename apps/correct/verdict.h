// The result in sentences.

#ifndef APPS_CORRECT_VERDICT_H_
#define APPS_CORRECT_VERDICT_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// Whether the initial value lies outside the estimate's interval.
bool HasMoved(const ParameterEstimate& estimate);

// Whether the proposed model has another element there than the initial one.
bool HasChanged(const Result& result, int output, int input);

// The reason of the decision to read first.
std::string MainReason(const Result& result);

// "8.5 min ahead": of the predictions over several samples.
std::string Ahead(const Result& result);

// The worth of the result: how well records that the fit had not seen are
// predicted or, without a correction, how small a change would have been seen.
// May be empty.
std::string WhatItIsWorth(const Result& result);

// Sentences on what to do and why: how sure and where; then what that is worth
// on records that the fit had not seen.
std::vector<std::string> DescribeVerdict(const Result& result);

// Grounds of the verdict: every change of an element, fits of every output, the
// distance to the truth where it is known.
std::vector<Finding> Findings(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_VERDICT_H_
