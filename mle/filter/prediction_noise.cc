#include "mle/filter/prediction_noise.h"

#include <algorithm>
#include <cmath>

#include "mle/data/record.h"
#include "mle/nonlinear/ar_search.h"
#include "mle/nonlinear/brent_search.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kLeastRun = 20;
// Akaike's price of a parameter: the class is the one that predicts best, where
// an explanation would ask for more (noise_search.h).
constexpr double kPrice = 2.0;
// Time constant of what does not return within the records, in samples of all.
constexpr double kIntegrates = 10.0;
constexpr double kLagStep = 2.0;
constexpr double kLongestLag = 0.1;      // of the samples of all
constexpr double kLogRatioRange = 13.0;  // of ρ about 1
constexpr int kSearchBits = 10;

// The time constant of the lag, in samples, of a noise that does not return.
double LagOf(const NoiseShape& shape) {
  const double damping = shape.ar_damping;
  return MemoryOf(shape.ar_pole) *
         (damping - std::sqrt(damping * damping - 1.0));
}

// The likeliest walk behind a lag, as coloured noise that all but integrates.
Profile BestWalkBehindLag(const ShapeLikelihood& likelihood) {
  const double samples = likelihood.problem().num_samples();
  const double slow = kIntegrates * samples;
  Profile best;
  const auto search = [&](double lag) {
    const double natural = std::sqrt(lag * slow);
    NoiseShape shape{.ar_pole = PoleOf(natural),
                     .ar_damping = 0.5 * (lag + slow) / natural};
    // Shocks of a walk reach 1/(1 − exp(−1/lag)) of their size behind it.
    const double lost = -2.0 * std::log(-std::expm1(-1.0 / lag));
    Profile of_lag;
    SearchLeast(-kLogRatioRange, kLogRatioRange, kSearchBits,
                [&](double log_ratio) {
                  shape.ar_ratio = std::exp(log_ratio - lost);
                  const Profile profile = likelihood.At(shape);
                  if (profile.value < of_lag.value) of_lag = profile;
                  return profile.value;
                });
    if (of_lag.value < best.value) best = of_lag;
    return of_lag.value;
  };
  double best_lag = 1.0;
  double least = best.value;
  for (double lag = 1.0; lag <= kLongestLag * samples; lag *= kLagStep) {
    const double value = search(lag);
    if (value >= least) continue;
    least = value;
    best_lag = lag;
  }
  SearchLeast(std::log(best_lag / kLagStep), std::log(best_lag * kLagStep),
              kSearchBits,
              [&](double log_lag) { return search(std::exp(log_lag)); });
  return best;
}

struct FoundShape {
  Profile profile;
  bool walk_behind_lag = false;
};

FoundShape LikeliestForPrediction(const ShapeLikelihood& likelihood) {
  const Profile walk = FindBestShape(likelihood, NoiseShape(),
                                     /*estimate_drift=*/true,
                                     /*search_ar=*/false);
  FoundShape best{.profile = walk};
  double least = walk.value;
  const auto compare = [&](const FoundShape& found, double price) {
    if (!(found.profile.value + price < least)) return;
    least = found.profile.value + price;
    best = found;
  };
  compare({BestWalkBehindLag(likelihood), true}, kPrice);
  for (const int order : {1, 2}) {
    compare({FindBestAr(likelihood, order, walk)}, kPrice * (order + 1));
  }
  return best;
}

// The mean ratio of the walk, the coloured component as it is.
NoiseShape WithMeanRatio(const ShapeLikelihood& likelihood,
                         const NoiseShape& shape) {
  std::vector<double> values;
  const std::vector<PossibleRatio> ratios =
      PossibleRatios(likelihood.problem());
  NoiseShape at = shape;
  for (const PossibleRatio& possible : ratios) {
    at.ratio = possible.ratio;
    values.push_back(likelihood.At(at).value);
  }
  const double least = *std::min_element(values.begin(), values.end());
  double sum = 0.0;
  double mean = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double weight =
        ratios[i].prior * std::exp(-0.5 * (values[i] - least));
    sum += weight;
    mean += weight * ratios[i].ratio;
  }
  at.ratio = mean / sum;
  return at;
}

// The walk behind a lag that coloured noise all but integrating stands for.
PredictionNoise WalkOf(const ShapeLikelihood& likelihood,
                       const Profile& behind_lag) {
  const NoiseEstimate coloured = NoiseOf(likelihood, behind_lag);
  PredictionNoise found;
  found.walk_lag = LagOf(behind_lag.shape);
  found.noise.variance = coloured.variance;
  // Of the walk a shock is 1/(1 − exp(−1/lag)) as large.
  found.noise.ratio =
      coloured.ar_ratio * std::pow(std::expm1(-1.0 / found.walk_lag), -2.0);
  found.noise.log_deviations[0] = coloured.log_deviations[1];
  return found;
}

}  // namespace

PredictionNoise EstimatePredictionNoise(const std::vector<VectorXd>& residuals,
                                        double sample_time) {
  std::vector<Record> records;
  Index longest = 1;
  for (const VectorXd& residual : residuals) {
    records.push_back({.sample_time = sample_time,
                       .outputs = residual.transpose(),
                       .inputs = Eigen::MatrixXd(0, residual.size())});
    longest = std::max(longest, residual.size());
  }
  const OutputErrorProblem problem({}, records, /*output=*/0, /*skip=*/0,
                                   kLeastRun);
  if (problem.num_samples() < kLeastNoiseSamples) return {};
  const ShapeLikelihood likelihood(problem, OutputPoint(), {}, NoiseShape(),
                                   /*restricted=*/true);
  const auto [best, walk_behind_lag] = LikeliestForPrediction(likelihood);
  if (walk_behind_lag) return WalkOf(likelihood, best);
  PredictionNoise found{
      .noise = NoiseOf(likelihood,
                       likelihood.At(WithMeanRatio(likelihood, best.shape)))};
  // Less drift cannot be seen in a record; with none, a constant disturbance
  // would never be followed.
  const auto length = static_cast<double>(longest);
  found.noise.ratio = std::max(found.noise.ratio, 1.0 / (length * length));
  return found;
}

}  // namespace mle
