#include "mle/maintain/shared_changes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/strings/str_format.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

constexpr double kSharedDeviations = 3.0;
constexpr double kSupport = 4.0;    // twice the difference of log-likelihoods
constexpr double kOfSample = 0.25;  // below it a dead time is not known anyway
constexpr double kOfGain = 0.01;

struct Change {
  double value = 0.0;
  double error = 0.0;     // standard error
  bool at_bound = false;  // it may have been less
};

// Whether an element that says little, and is nearer to no change, may share
// one that others show.
enum class Undetermined { kMayShare, kMayNot };

// Of the elements of a row or a column; ε is `least`.
std::optional<Change> Share(const std::vector<Change>& changes, double least,
                            Undetermined undetermined) {
  int telling = 0;
  double weights = 0.0;
  double sum = 0.0;
  std::vector<double> variances;
  for (const Change& change : changes) {
    variances.push_back(change.error * change.error + least * least);
    if (change.at_bound) continue;
    if (!std::isfinite(variances.back())) return std::nullopt;
    ++telling;
    weights += 1.0 / variances.back();
    sum += change.value / variances.back();
  }
  if (telling < 2) return std::nullopt;
  const Change shared = {sum / weights, 1.0 / std::sqrt(weights)};
  if (!(std::abs(shared.value) > kSharedDeviations * shared.error)) {
    return std::nullopt;
  }
  int supporting = 0;
  bool all_nearer = true;
  for (std::size_t j = 0; j < changes.size(); ++j) {
    const double own = changes[j].value;
    if (changes[j].at_bound && shared.value <= own) continue;
    const double rest = own - shared.value;
    // Twice the nats by which δ is likelier than no change.
    const double support = (own * own - rest * rest) / variances[j];
    if (!(std::abs(rest) <= kSharedDeviations * std::sqrt(variances[j])) ||
        support < -kSupport) {
      return std::nullopt;
    }
    if (support > kSupport) ++supporting;
    all_nearer = all_nearer && support >= 0.0;
  }
  if (!all_nearer &&
      (undetermined == Undetermined::kMayNot || supporting < 2)) {
    return std::nullopt;
  }
  return shared;
}

}  // namespace

const std::string& SharedDelay::Channel(const ProcessModel& model) const {
  return is_output ? model.outputs()[channel].name
                   : model.inputs()[channel].name;
}

std::string SharedDelay::Describe(const ProcessModel& model) const {
  const std::string& name = Channel(model);
  const char* const late = (change > 0.0) == is_output ? "late" : "early";
  if (impossible) {
    return absl::StrFormat(
        "The time stamps of %s seem to be %.3g %s %s (standard error %.2g): "
        "all dead times %s it seem %s by as much, and one of them would have "
        "to be negative",
        name, std::abs(change), model.time_unit(), late, error,
        is_output ? "to" : "from", change > 0.0 ? "longer" : "shorter");
  }
  return absl::StrFormat(
      "All dead times %s %s seem to be %.3g %s %s (standard error %.2g): "
      "either "
      "they have changed, or the time stamps of %s are %s by as much",
      is_output ? "to" : "from", name, std::abs(change), model.time_unit(),
      change > 0.0 ? "longer" : "shorter", error, name, late);
}

std::optional<double> FindSharedGain(const OutputErrorFit& fit, int input) {
  std::vector<Change> gains;
  for (int i = 0; i < fit.model.num_outputs(); ++i) {
    const ElementEstimate& element = fit.element(i, input);
    if (element.state != ElementState::kFitted) continue;
    const double initial = element.gain.initial;
    gains.push_back({element.gain.value / initial - 1.0,
                     element.gain.standard_error / std::abs(initial)});
  }
  const std::optional<Change> shared =
      Share(gains, kOfGain, Undetermined::kMayNot);
  if (!shared.has_value()) return std::nullopt;
  return shared->value;
}

std::vector<SharedDelay> FindSharedDelays(const OutputErrorFit& fit,
                                          double sample_time) {
  const int p = fit.model.num_outputs();
  const int m = fit.model.num_inputs();
  std::vector<SharedDelay> found;
  std::vector<bool> taken(p, false);
  const auto add = [&](bool is_output, int channel) {
    std::vector<Change> delays;
    double shortest = kInfinity;  // of the model's
    for (int other = 0; other < (is_output ? m : p); ++other) {
      const int i = is_output ? channel : other;
      const int j = is_output ? other : channel;
      const ElementEstimate& element = fit.element(i, j);
      if (element.state != ElementState::kFitted) continue;
      if (!is_output && taken[i]) return;
      delays.push_back(
          {.value = element.delay.value - element.delay.initial,
           .error = element.delay.standard_error,
           .at_bound = element.delay.value < kOfSample * sample_time});
      shortest = std::min(shortest, element.delay.initial);
    }
    const std::optional<Change> shared =
        Share(delays, kOfSample * sample_time, Undetermined::kMayShare);
    if (!shared.has_value()) return;
    if (is_output) taken[channel] = true;
    found.push_back({.is_output = is_output,
                     .channel = channel,
                     .change = shared->value,
                     .error = shared->error,
                     .impossible = shortest + shared->value <
                                   -kSharedDeviations * shared->error});
  };
  for (int i = 0; i < p; ++i) add(true, i);
  for (int j = 0; j < m; ++j) add(false, j);
  return found;
}

}  // namespace mle
