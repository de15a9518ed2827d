#include "apps/lifecycle/scenario.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

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
  if (!(change_every <= duration)) {
    return InvalidArgument("change_every = ", change_every,
                           ", but all years are only ", duration,
                           "; there would be no change");
  }
  if (!(duration / change_every <= kMaxEvents)) {
    return InvalidArgument("change_every = ", change_every, " makes ",
                           duration / change_every, " changes; up to ",
                           kMaxEvents, " are possible");
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
    // The shortest gap has to fit in between the last change and the end.
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

SlowDisturbance::SlowDisturbance(std::uint64_t seed, Eigen::VectorXd deviation,
                                 double time, double sample_time)
    : seed_(seed),
      deviation_(std::move(deviation)),
      time_(time),
      sample_time_(sample_time),
      level_(deviation_.size()) {
  GaussianNoise source(seed_, kRunStream, kSlowDisturbance);
  for (Eigen::Index i = 0; i < level_.size(); ++i) {
    level_[i] = source.Draw(deviation_[i]);
  }
}

Eigen::MatrixXd SlowDisturbance::Draw(std::uint64_t stream, double start,
                                      int samples) const {
  GaussianNoise source(seed_, stream, kSlowDisturbance);
  Eigen::MatrixXd path(level_.size(), samples + 1);
  const auto step = [&](double time, const Eigen::VectorXd& from) {
    const double phi = std::exp(-time / time_);
    Eigen::VectorXd to = phi * from;
    for (Eigen::Index i = 0; i < to.size(); ++i) {
      to[i] += source.Draw(std::sqrt(1.0 - phi * phi) * deviation_[i]);
    }
    return to;
  };
  path.col(0) = step(std::max(start - level_time_, 0.0), level_);
  for (int k = 1; k <= samples; ++k) {
    path.col(k) = step(sample_time_, path.col(k - 1));
  }
  return path;
}

void SlowDisturbance::Keep(const Eigen::MatrixXd& path, double time) {
  level_ = path.rightCols<1>();
  level_time_ = time;
}

Eigen::VectorXd StepTestPlan::InputsAt(double time, int num_inputs) const {
  Eigen::VectorXd deviation = Eigen::VectorXd::Zero(num_inputs);
  // The millionth keeps times on the boundary on its later side.
  const auto part =
      static_cast<std::size_t>(std::max(0.0, std::floor(time / hold + 1e-6)));
  const std::size_t place = part / (2 * static_cast<std::size_t>(cycles));
  if (part % 2 == 0 && place < inputs.size()) {
    deviation[inputs[place]] = steps[static_cast<Eigen::Index>(place)];
  }
  return deviation;
}

StepTestPlan PlanStepTest(const ProcessModel& model,
                          const StepTestOptions& options) {
  StepTestPlan plan;
  plan.hold = options.hold;
  plan.cycles = options.cycles;
  std::vector<double> steps;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].role != InputRole::kManipulated) continue;
    double relative = 0.0;  // the largest |K_ij| / move_i
    for (int i = 0; i < model.num_outputs(); ++i) {
      relative = std::max(relative, std::abs(model.element(i, j).StaticGain()) /
                                        options.move[i]);
    }
    if (!(relative > 0.0)) continue;
    plan.inputs.push_back(j);
    steps.push_back(1.0 / relative);
  }
  plan.steps = Eigen::Map<const Eigen::VectorXd>(
      steps.data(), static_cast<Eigen::Index>(steps.size()));
  return plan;
}

}  // namespace mle::lifecycle
