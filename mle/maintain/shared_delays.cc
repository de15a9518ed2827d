#include "mle/maintain/shared_delays.h"

#include <cmath>
#include <optional>

#include "absl/strings/str_format.h"

namespace mle {
namespace {

constexpr double kDeviations = 3.0;
constexpr double kOfSample = 0.25;  // below it a dead time is not known anyway

// Of the elements of a row or a column.
std::optional<SharedDelay> Share(
    const std::vector<const ParameterEstimate*>& delays, double sample_time) {
  if (delays.size() < 2) return std::nullopt;
  const double least = kOfSample * sample_time;
  double weights = 0.0;
  double sum = 0.0;
  std::vector<double> variances;
  for (const ParameterEstimate* delay : delays) {
    variances.push_back(std::pow(delay->standard_error, 2) + least * least);
    if (!std::isfinite(variances.back())) return std::nullopt;
    weights += 1.0 / variances.back();
    sum += (delay->value - delay->initial) / variances.back();
  }
  const SharedDelay shared = {.change = sum / weights,
                              .error = 1.0 / std::sqrt(weights)};
  if (!(std::abs(shared.change) > kDeviations * shared.error)) {
    return std::nullopt;
  }
  for (std::size_t j = 0; j < delays.size(); ++j) {
    const double own = delays[j]->value - delays[j]->initial;
    const double rest = std::abs(own - shared.change);
    if (!(rest <= kDeviations * std::sqrt(variances[j])) ||
        rest > std::abs(own)) {
      return std::nullopt;
    }
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
  return absl::StrFormat(
      "All dead times %s %s seem to be %.3g %s %s (standard error %.2g): "
      "either "
      "they have changed, or the time stamps of %s are %s by as much",
      is_output ? "to" : "from", name, std::abs(change), model.time_unit(),
      change > 0.0 ? "longer" : "shorter", error, name,
      (change > 0.0) == is_output ? "late" : "early");
}

std::vector<SharedDelay> FindSharedDelays(const OutputErrorFit& fit,
                                          double sample_time) {
  const int p = fit.model.num_outputs();
  const int m = fit.model.num_inputs();
  std::vector<SharedDelay> found;
  std::vector<bool> taken(p, false);
  const auto add = [&](bool is_output, int channel) {
    std::vector<const ParameterEstimate*> delays;
    for (int other = 0; other < (is_output ? m : p); ++other) {
      const int i = is_output ? channel : other;
      const int j = is_output ? other : channel;
      const ElementEstimate& element = fit.element(i, j);
      if (element.state != ElementState::kFitted) continue;
      if (!is_output && taken[i]) return;
      delays.push_back(&element.delay);
    }
    std::optional<SharedDelay> shared = Share(delays, sample_time);
    if (!shared.has_value()) return;
    shared->is_output = is_output;
    shared->channel = channel;
    if (is_output) taken[channel] = true;
    found.push_back(*shared);
  };
  for (int i = 0; i < p; ++i) add(true, i);
  for (int j = 0; j < m; ++j) add(false, j);
  return found;
}

}  // namespace mle
