#include "mle/trial/trial_state.h"

#include <algorithm>
#include <cmath>

namespace mle {
namespace {

bool AreOf(const std::vector<TrialResponse>& responses, std::size_t outputs) {
  return std::all_of(responses.begin(), responses.end(),
                     [&](const TrialResponse& response) {
                       return response.gains.size() == outputs &&
                              response.sizes.size() == outputs &&
                              response.deviations.size() == outputs &&
                              response.in_use.size() == outputs &&
                              response.proposed.size() == outputs;
                     });
}

bool AreOf(const std::vector<Variogram>& noise, std::size_t outputs,
           Eigen::Index lags) {
  return noise.size() == outputs &&
         std::all_of(noise.begin(), noise.end(), [&](const Variogram& of) {
           return of.sums.size() == lags && of.counts.size() == lags;
         });
}

bool AreOf(const std::vector<StepLosses>& losses, std::size_t outputs,
           std::size_t horizons) {
  return losses.size() == outputs &&
         std::all_of(losses.begin(), losses.end(), [&](const StepLosses& of) {
           return of.in_use.size() == horizons &&
                  of.proposed.size() == horizons &&
                  of.counts.size() == horizons;
         });
}

bool IsSized(const Eigen::MatrixXd& values, Eigen::Index rows,
             Eigen::Index columns) {
  return values.rows() == rows && values.cols() == columns;
}

}  // namespace

double LossRatio(const std::vector<StepLosses>& losses) {
  double count = 0.0;
  double ratios = 0.0;
  for (const StepLosses& output : losses) {
    for (std::size_t h = 0; h < output.counts.size(); ++h) {
      if (!(output.in_use[h] > 0.0)) continue;
      count += 1.0;
      ratios += output.proposed[h] / output.in_use[h];
    }
  }
  return count > 0.0 ? std::sqrt(ratios / count) : 1.0;
}

bool Fits(const TrialState& state, std::size_t outputs, Eigen::Index rows,
          std::size_t horizons) {
  const auto r = static_cast<Eigen::Index>(outputs);
  const Eigen::Index q = state.shapes.rows();
  const Eigen::Index n = state.shapes.cols();
  return n <= rows && IsSized(state.differences, r, n) &&
         IsSized(state.in_use, r, n) && IsSized(state.proposed, r, n) &&
         IsSized(state.normal, q, q) &&
         IsSized(state.moments, q, q > 0 ? r : 0) &&
         AreOf(state.noise, outputs, rows - 1) &&
         AreOf(state.always, outputs, rows - 1) &&
         AreOf(state.losses, outputs, horizons) &&
         AreOf(state.learned, outputs) && AreOf(state.before, outputs) &&
         AreOf(state.responses, outputs);
}

}  // namespace mle
