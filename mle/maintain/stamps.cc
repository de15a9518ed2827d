#include "mle/maintain/stamps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "mle/data/civil_time.h"
#include "mle/data/sampling.h"
#include "mle/model/process_simulator.h"

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
// Shifts that are tried to each side; the share of what the proposed model
// explains that is as much, and of what it leaves that is far less.
constexpr int kShifts = 8;
constexpr double kAsMuch = 0.8;
constexpr double kFarLess = 0.5;
// The share of a sample by which means of what lies between samples shift it,
// with what they seem to.
constexpr double kOfSample = 0.75;
// What an estimate makes of an average, in what the average does.
constexpr double kOfAverage = 1.5;

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

// By how much its samples may seem late or early since they are averages, or
// stamped so, if nothing is declared.
double MostOfStamps(const CorrectionResult& result, int output) {
  if (!(result.options.decision.clock_error > 0.0) ||
      DeclaredOf(result, output) != Sampling()) {
    return 0.0;
  }
  return std::max(TimeOfMeasurement(result, output),
                  kOfSample * result.data.sample_time());
}

// The sum of squares that an output leaves of a model's row simulated in the
// windows, each with an offset, its samples `late` samples after what they are
// of; NaN where it cannot be simulated.
double Misfit(const CorrectionResult& result, const ProcessModel& model,
              int output, double late) {
  double sum = 0.0;
  for (const Record& record : result.data.Records()) {
    const absl::StatusOr<Eigen::MatrixXd> z =
        SimulateResponse(model, record.sample_time, record.inputs);
    if (!z.ok()) return std::numeric_limits<double>::quiet_NaN();
    const double last = record.samples() - 1.0;
    std::vector<double> residuals;
    for (int k = 0; k < record.samples(); ++k) {
      if (!std::isfinite(record.outputs(output, k))) continue;
      const double at = std::clamp(k - late, 0.0, last);
      const auto whole = static_cast<Eigen::Index>(at);
      const double rest = at - static_cast<double>(whole);
      residuals.push_back(
          record.outputs(output, k) - (1.0 - rest) * (*z)(output, whole) -
          rest * (*z)(output, std::min(whole + 1, z->cols() - 1)));
    }
    const Eigen::Map<const Eigen::ArrayXd> all(
        residuals.data(), static_cast<Eigen::Index>(residuals.size()));
    if (all.size() > 0) sum += (all - all.mean()).square().sum();
  }
  return sum;
}

// By how much the output's samples would have to be late, up to `most`, for the
// controller's model to explain as much as the proposed one, or for this to
// leave far less; 0: by nothing.
double LateInstead(const CorrectionResult& result, int output, double most) {
  const ProcessModel& proposed =
      result.estimate.fit.output_error.corrected.model;
  const double before = Misfit(result, result.initial, output, 0.0);
  const double left = Misfit(result, proposed, output, 0.0);
  double best = 0.0;
  for (const auto& [model, enough] :
       {std::pair(&result.initial,
                  before - kAsMuch * std::max(before - left, 0.0)),
        std::pair(&proposed, kFarLess * left)}) {
    if (best != 0.0) break;
    double least = enough;
    for (int step = -kShifts; step <= kShifts; ++step) {
      const double late = most * step / kShifts;
      const double misfit =
          Misfit(result, *model, output, late / result.data.sample_time());
      if (misfit < least) {
        least = misfit;
        best = late;
      }
    }
  }
  return best;
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

// By how much the proposal makes all dead times of an output longer, alike; 0
// where it does something else.
double CommonDelay(const CorrectionResult& result, int output) {
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
  const bool alike =
      lowest * highest > 0.0 && highest - lowest <= kAlike * largest;
  return alike ? 0.5 * (lowest + highest) : 0.0;
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
      least, kOfAverage * LostByAverage(response, width) / response.norm());
}

bool MayBeStamps(const CorrectionResult& result, int output, double late) {
  return std::abs(late) <= kOfSample * result.data.sample_time() &&
         MostOfStamps(result, output) > 0.0;
}

bool IsAveraged(const CorrectionResult& result, int output) {
  return DeclaredOf(result, output).average > 0.0;
}

std::optional<Message> ExplainedByStamps(const CorrectionResult& result,
                                         int output) {
  const double most = MostOfStamps(result, output);
  if (most == 0.0) return std::nullopt;
  double late = CommonDelay(result, output);
  if (!(std::abs(late) <= most)) late = 0.0;
  if (late == 0.0) late = LateInstead(result, output, most);
  if (late == 0.0) return std::nullopt;
  const std::string& name = result.initial.outputs()[output].name;
  const std::string& unit = result.initial.time_unit();
  return Message{
      MessageCode::kClock,
      name,
      absl::StrFormat(
          "The samples of %s seem to be %.2g %s too %s, no more than the time "
          "in which it is measured once: they may be stamped so, or be "
          "averages, or all its dead times have changed. Declare its sampling "
          "(late_by, average) in the model or the file of tags.",
          name, std::abs(late), unit, late > 0.0 ? "late" : "early"),
      {"clock_error"}};
}

}  // namespace mle
