#include "mle/maintain/stamps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "Eigen/Core"
#include "absl/strings/str_format.h"
#include "mle/data/civil_time.h"
#include "mle/data/sampling.h"

namespace mle {
namespace {

// By which a tag may be late since it waits for a scan or an average.
constexpr double kLateSamples = 5.0;
// Samples of outputs that are measured now and then are as far apart, at least.
constexpr int kNowAndThen = 3;
// Changes of dead times that agree to within this share are of one cause, and
// in standard errors, which count.
constexpr double kAlike = 0.3;
constexpr double kDeviations = 2.0;

Sampling DeclaredOf(const CorrectionResult& result, int output) {
  const auto place = static_cast<std::size_t>(output);
  return place < result.data.sampling.size() ? result.data.sampling[place]
                                             : Sampling();
}

// The time in which the output is measured once, if that is several samples and
// nothing is declared; 0 if not.
double TimeOfMeasurement(const CorrectionResult& result, int output) {
  if (DeclaredOf(result, output) != Sampling()) return 0.0;
  const int samples = MeasuredEvery(result.data.records, output);
  return samples >= kNowAndThen ? samples * result.data.sample_time() : 0.0;
}

// The mean of the response over `width` samples around each, 0 before it and
// its last value after it.
Eigen::VectorXd Averaged(const Eigen::VectorXd& response, double width) {
  const Eigen::Index n = response.size();
  const auto half = static_cast<Eigen::Index>(std::round(0.5 * width));
  Eigen::VectorXd means(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    double sum = 0.0;
    for (Eigen::Index l = k - half; l <= k + half; ++l) {
      const double edge = std::abs(l - k) == half ? 0.5 : 1.0;
      sum += l < 0 ? 0.0 : edge * response[std::min(l, n - 1)];
    }
    means[k] = sum / (2.0 * static_cast<double>(half));
  }
  return means;
}

}  // namespace

double MostOfClock(const CorrectionResult& result, int output) {
  const double seconds = result.options.decision.clock_error;
  if (!(seconds > 0.0)) return 0.0;
  return std::max(
      {seconds / SecondsPerUnit(result.initial.time_unit())
                     .value_or(std::numeric_limits<double>::infinity()),
       kLateSamples * result.data.sample_time(),
       TimeOfMeasurement(result, output)});
}

double LeastChange(const CorrectionResult& result, int output, int input) {
  const double least = result.options.decision.least_change;
  const double width =
      DeclaredOf(result, output).average / result.data.sample_time();
  const Eigen::VectorXd response =
      result.initial_response.element(output, input);
  if (!(width >= 1.0) || !(response.norm() > 0.0)) return least;
  return std::max(
      least, (Averaged(response, width) - response).norm() / response.norm());
}

std::optional<Message> ExplainedByStamps(const CorrectionResult& result,
                                         int output) {
  const double most = result.options.decision.clock_error > 0.0
                          ? TimeOfMeasurement(result, output)
                          : 0.0;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (int j = 0; j < result.initial.num_inputs(); ++j) {
    if (result.initial.element(output, j).IsZero()) continue;
    const ParameterEstimate& delay =
        result.estimate.fit.output_error.corrected.element(output, j).delay;
    const double change = delay.value - delay.initial;
    const bool counts = result.estimate.fit.output_error.aged(output, j) &&
                        std::abs(change) > kDeviations * delay.standard_error;
    lowest = std::min(lowest, counts ? change : 0.0);
    highest = std::max(highest, counts ? change : 0.0);
  }
  const double largest = std::max(std::abs(lowest), std::abs(highest));
  if (!(largest <= most) || !(lowest * highest > 0.0) ||
      highest - lowest > kAlike * largest) {
    return std::nullopt;
  }
  const std::string& name = result.initial.outputs()[output].name;
  const std::string& unit = result.initial.time_unit();
  return Message{
      MessageCode::kClock,
      name,
      absl::StrFormat(
          "All dead times of %s would be %.2g %s %s, no more than the %.3g %s "
          "in which it is measured once: its samples may be stamped late or "
          "early, or be averages. Declare its sampling (late_by, average) in "
          "the model or the file of tags.",
          name, 0.5 * std::abs(lowest + highest), unit,
          lowest > 0.0 ? "longer" : "shorter", most, unit),
      {"clock_error"}};
}

}  // namespace mle
