#include "mle/exchange/step_response_model.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "glog/logging.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Beyond, a fit would overflow.
constexpr double kLargestCoefficient = 1e100;

}  // namespace

absl::Status StepResponseModel::Validate() const {
  MLE_RETURN_IF_ERROR(channels.Validate());
  MLE_RETURN_IF_ERROR(ValidateSampleTime("interval", interval));
  if (length() < kFewestCoefficients) {
    return InvalidArgument("there are ", length(), " coefficients, at least ",
                           kFewestCoefficients, " are needed");
  }
  std::set<std::pair<int, int>> seen;
  for (const PairResponse& pair : pairs) {
    const bool known = pair.output >= 0 && pair.input >= 0 &&
                       pair.output < channels.num_outputs() &&
                       pair.input < channels.num_inputs();
    if (!known || !seen.insert({pair.output, pair.input}).second) {
      return InvalidArgument(
          "output ", pair.output, ", input ", pair.input,
          known ? ": the pair is duplicated" : ": there is no such channel");
    }
    if (pair.coefficients.size() != length() ||
        !(pair.coefficients.cwiseAbs().maxCoeff() <= kLargestCoefficient)) {
      return InvalidArgument(PairName(channels, pair.output, pair.input),
                             ": there must be ", length(),
                             " coefficients of at most ", kLargestCoefficient,
                             " in magnitude");
    }
  }
  return absl::OkStatus();
}

absl::Status StepResponseModel::CheckSteadyState(double stated) const {
  const double end = time_to_steady_state();
  if (std::abs(stated - end) <= kTimeTolerance * interval) {
    return absl::OkStatus();
  }
  return InvalidArgument("is ", stated, ", but ", length(),
                         " coefficients at an interval of ", interval,
                         " end at ", end);
}

StepResponseModel WithChange(const StepResponseModel& model,
                             const StepResponse& before,
                             const StepResponse& after) {
  const int length = model.length();
  CHECK_EQ(before.samples(), length + 1);
  CHECK_EQ(after.samples(), length + 1);
  StepResponseModel changed = model;
  for (int i = 0; i < model.channels.num_outputs(); ++i) {
    for (int j = 0; j < model.channels.num_inputs(); ++j) {
      const Eigen::VectorXd difference =
          (after.element(i, j) - before.element(i, j)).tail(length);
      if (difference.isZero(0.0)) continue;
      const auto found = std::find_if(
          changed.pairs.begin(), changed.pairs.end(),
          [&](const PairResponse& p) { return p.output == i && p.input == j; });
      if (found != changed.pairs.end()) {
        found->coefficients += difference;
      } else {
        changed.pairs.push_back({i, j, difference, false});
      }
    }
  }
  return changed;
}

}  // namespace mle
