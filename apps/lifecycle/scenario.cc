#include "apps/lifecycle/scenario.h"

#include <cmath>
#include <random>

#include "absl/strings/str_cat.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::lifecycle {
namespace {

constexpr double kMaxEvents = 1e5;

}  // namespace

absl::Status SetPointOptions::Validate() const {
  MLE_RETURN_IF_ERROR(sim::CheckPositive("duration", duration));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("change_every", change_every));
  MLE_RETURN_IF_ERROR(sim::CheckPositive("grid", grid));
  if (change_every > duration) {
    return absl::InvalidArgumentError(absl::StrCat(
        "change_every = ", change_every, ", but all years are only ", duration,
        "; there would be no change"));
  }
  if (duration / change_every > kMaxEvents) {
    return absl::InvalidArgumentError(absl::StrCat(
        "change_every = ", change_every, " makes ", duration / change_every,
        " changes; up to ", kMaxEvents, " are possible"));
  }
  for (const double value : range) {
    MLE_RETURN_IF_ERROR(sim::CheckPositive("range", value));
  }
  return absl::OkStatus();
}

std::vector<SetPointEvent> DrawSetPointEvents(const SetPointOptions& options,
                                              std::uint64_t seed) {
  std::mt19937_64 times = SeededEngine(seed, kRunStream, kSetPointTimes);
  std::mt19937_64 sizes = SeededEngine(seed, kRunStream, kSetPointSizes);
  const Eigen::Index p = options.range.size();
  const double end = std::floor(options.duration / options.grid) * options.grid;
  std::vector<SetPointEvent> events;
  Eigen::VectorXd set_points = Eigen::VectorXd::Zero(p);
  double time = 0.0;
  for (;;) {
    const double gap = options.change_every * (0.5 + DrawUniform(times));
    time = std::round((time + gap) / options.grid) * options.grid;
    // What follows the last change has to fit in before the end.
    if (time > end - options.ShortestGap()) break;
    SetPointEvent& event = events.emplace_back();
    event.time = time;
    event.output =
        static_cast<int>(DrawUniform(sizes) * static_cast<double>(p));
    event.before = set_points;
    const double range = options.range[event.output];
    double target = 0.0;
    do {
      target = range * (2.0 * DrawUniform(sizes) - 1.0);
    } while (std::abs(target - set_points[event.output]) < 0.5 * range);
    set_points[event.output] = target;
    event.after = set_points;
  }
  events.push_back({end, -1, set_points, set_points});
  return events;
}

}  // namespace mle::lifecycle
