#include "mle/maintain/stamps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "Eigen/Core"
#include "mle/data/civil_time.h"
#include "mle/data/sampling.h"

namespace mle {
namespace {

// By which a tag may be late since it waits for a scan or an average.
constexpr double kLateSamples = 5.0;
// Samples of outputs that are measured now and then are as far apart, at least.
constexpr int kNowAndThen = 3;
// What an estimate makes of an average, in what the average does.
constexpr double kOfAverage = 1.5;

Sampling DeclaredOf(const Candidates& candidates, int output) {
  const auto place = static_cast<std::size_t>(output);
  return place < candidates.data.sampling.size()
             ? candidates.data.sampling[place]
             : Sampling();
}

// The time in which the output is measured once, if that is several samples and
// nothing is declared; 0 if not.
double TimeOfMeasurement(const Candidates& candidates, int output) {
  if (DeclaredOf(candidates, output) != Sampling()) return 0.0;
  const int samples = MeasuredEvery(candidates.data.records, output);
  return samples >= kNowAndThen ? samples * candidates.data.sample_time() : 0.0;
}

// What the mean over `width` samples around each takes from a response, which
// is 0 before it and its last value after it: the norm of the difference.
double LostByAverage(const Eigen::VectorXd& response, double width) {
  const Eigen::Index n = response.size();
  const auto half = static_cast<Eigen::Index>(std::round(0.5 * width));
  const auto at = [&](Eigen::Index k) {
    return k < 0 ? 0.0 : response[std::min(k, n - 1)];
  };
  double lost = 0.0;
  for (Eigen::Index k = -half; k < n; ++k) {
    double sum = 0.0;
    for (Eigen::Index l = k - half; l <= k + half; ++l) {
      sum += (std::abs(l - k) == half ? 0.5 : 1.0) * at(l);
    }
    const double mean = sum / (2.0 * static_cast<double>(half));
    lost += (mean - at(k)) * (mean - at(k));
  }
  return std::sqrt(lost);
}

}  // namespace

double MostOfClock(const Candidates& candidates, int output) {
  const double seconds = candidates.options.decision.clock_error;
  if (!(seconds > 0.0)) return 0.0;
  return std::max(
      {seconds / SecondsPerUnit(candidates.initial.time_unit())
                     .value_or(std::numeric_limits<double>::infinity()),
       kLateSamples * candidates.data.sample_time(),
       TimeOfMeasurement(candidates, output)});
}

double LeastChange(const Candidates& candidates, int output, int input) {
  const double least = candidates.options.decision.least_change;
  const double width =
      DeclaredOf(candidates, output).average / candidates.data.sample_time();
  const Eigen::VectorXd response =
      candidates.initial_response.element(output, input);
  if (!(width >= 1.0) || !(response.norm() > 0.0)) return least;
  return std::max(
      least, kOfAverage * LostByAverage(response, width) / response.norm());
}

}  // namespace mle
