#include "sim/continuous_plant.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/status.h"

namespace mle::sim {
namespace {

using Eigen::VectorXd;

// How far inside its side of a break f is evaluated, of Δt. Above the rounding
// of a time of 10⁷ samples.
constexpr double kInside = 1e-8;
constexpr double kMaxStepsPerSample = 1e9;

absl::Status CheckSize(const char* field, Eigen::Index size, int wanted) {
  if (size == 0 || size == wanted) return absl::OkStatus();
  return InvalidArgument(field, " has ", size, " values, but it needs ", wanted,
                         " or none");
}

}  // namespace

absl::Status ContinuousSystem::Validate() const {
  if (num_inputs < 1 || num_outputs < 1) {
    return InvalidArgument("num_inputs = ", num_inputs,
                           ", num_outputs = ", num_outputs,
                           ", but both must be at least 1");
  }
  if (!derivative || !output) {
    return absl::InvalidArgumentError(
        "derivative and output must both be given");
  }
  if (!(largest_step > 0.0)) {
    return InvalidArgument("largest_step = ", largest_step,
                           ", but it must be > 0");
  }
  if (!initial_state.allFinite()) {
    return absl::InvalidArgumentError("initial_state is not finite");
  }
  MLE_RETURN_IF_ERROR(
      CheckSize("input_origin", input_origin.size(), num_inputs));
  return CheckSize("output_origin", output_origin.size(), num_outputs);
}

absl::StatusOr<ContinuousPlant> ContinuousPlant::Create(
    ContinuousSystem system, const ContinuousPlantOptions& options) {
  if (!(options.sample_time > 0.0) || !std::isfinite(options.sample_time) ||
      !std::isfinite(options.start_time)) {
    return InvalidArgument("sample_time = ", options.sample_time,
                           ", start_time = ", options.start_time,
                           ", but both must be finite and the first > 0");
  }
  MLE_RETURN_IF_ERROR(system.Validate());
  if (!(options.sample_time / system.largest_step <= kMaxStepsPerSample)) {
    return InvalidArgument("largest_step = ", system.largest_step,
                           " is too fine for sample_time ", "= ",
                           options.sample_time, ": at most ",
                           kMaxStepsPerSample, " steps a sample");
  }
  if (system.paths.empty()) {
    for (int j = 0; j < system.num_inputs; ++j) {
      system.paths.push_back({.input = j});
    }
  }
  if (system.input_origin.size() == 0) {
    system.input_origin = VectorXd::Zero(system.num_inputs);
  }
  if (system.output_origin.size() == 0) {
    system.output_origin = VectorXd::Zero(system.num_outputs);
  }
  std::sort(system.breaks.begin(), system.breaks.end());
  MLE_ASSIGN_OR_RETURN(DelayedInputs inputs,
                       DelayedInputs::Create(system.num_inputs, system.paths,
                                             options.sample_time));
  return ContinuousPlant(std::move(system), std::move(inputs), options);
}

ContinuousPlant::ContinuousPlant(ContinuousSystem system, DelayedInputs inputs,
                                 const ContinuousPlantOptions& options)
    : system_(std::move(system)),
      inputs_(std::move(inputs)),
      options_(options),
      scheme_(system_.initial_state),
      state_(system_.initial_state),
      path_inputs_(inputs_.num_paths()),
      outputs_(system_.num_outputs) {
  for (int i = 0; i < inputs_.num_paths(); ++i) {
    path_inputs_[i] = system_.input_origin[system_.paths[i].input];
  }
  ComputeOutputs(time());
}

double ContinuousPlant::time() const {
  return options_.start_time +
         static_cast<double>(sample_) * options_.sample_time;
}

void ContinuousPlant::Advance(const Eigen::Ref<const VectorXd>& input) {
  inputs_.Hold(time(), input);
  FindBreaks();
  double now = 0.0;
  for (const DelayedInputs::Event& event : inputs_.events()) {
    Integrate(now, event.at);
    now = std::max(now, event.at);
    path_inputs_[event.path] =
        system_.input_origin[system_.paths[event.path].input] +
        inputs_.Value(event);
  }
  Integrate(now, 1.0);
  ComputeOutputs(InsideBreaks(0.0, 1.0, 1.0));
  ++sample_;
}

void ContinuousPlant::FindBreaks() {
  breaks_.clear();
  const double begin = time();
  const double slack = kSnap * options_.sample_time;
  auto next = std::lower_bound(system_.breaks.begin(), system_.breaks.end(),
                               begin - slack);
  for (; next != system_.breaks.end(); ++next) {
    const double at = (*next - begin) / options_.sample_time;
    if (at > 1.0 + kSnap) break;
    if (!breaks_.empty() && at - breaks_.back() <= kSnap) continue;
    breaks_.push_back(std::clamp(at, 0.0, 1.0));
  }
}

// From one fraction of the sample to another, cut at the breaks between.
void ContinuousPlant::Integrate(double from, double to) {
  if (to - from <= kSnap) return;
  double end = to;
  for (const double at : breaks_) {
    if (at > from + kSnap && at < to - kSnap) {
      end = at;
      break;
    }
  }
  const double interval = (end - from) * options_.sample_time;
  // A whole number of largest steps, but for rounding, is not cut once more.
  const double steps =
      std::max(1.0, std::ceil(interval / system_.largest_step * (1.0 - 1e-12)));
  const double h = interval / steps;
  if (state_.size() > 0) {
    for (double i = 0.0; i < steps; i += 1.0) {
      const auto derivative = [&](double since, const VectorXd& x,
                                  VectorXd& dx) {
        const double at = from + (i * h + since) / options_.sample_time;
        system_.derivative(InsideBreaks(from, end, at), x, path_inputs_, dx);
      };
      scheme_.Step(derivative, h, state_);
    }
  }
  Integrate(end, to);
}

// The time of the fraction `at` of the sample, moved to the inner side of
// [from, to] where that begins or ends with a break.
double ContinuousPlant::InsideBreaks(double from, double to, double at) const {
  for (const double one : breaks_) {
    if (std::abs(one - from) <= kSnap) at = std::max(at, from + kInside);
    if (std::abs(one - to) <= kSnap) at = std::min(at, to - kInside);
  }
  return time() + at * options_.sample_time;
}

void ContinuousPlant::ComputeOutputs(double at_time) {
  system_.output(at_time, state_, path_inputs_, outputs_);
  outputs_ -= system_.output_origin;
}

}  // namespace mle::sim
