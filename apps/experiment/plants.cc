#include <algorithm>
#include <cmath>

#include "Eigen/Core"
#include "Eigen/SVD"
#include "absl/strings/str_format.h"
#include "apps/experiment/campaign.h"
#include "control/loop_analysis.h"
#include "control/mpc.h"
#include "control/prediction_model.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/ageing.h"
#include "sim/schedule.h"

namespace mle::experiment {
namespace {

constexpr int kMaxDraws = 1000;

double Uniform(const Interval& interval, std::mt19937_64& engine) {
  return interval.from + (interval.to - interval.from) * DrawUniform(engine);
}

double LogUniform(const Interval& interval, std::mt19937_64& engine) {
  // One number stays what it is, to the last digit.
  const double u = DrawUniform(engine);
  if (interval.from == interval.to) return interval.from;
  return interval.from * std::pow(interval.to / interval.from, u);
}

ProcessModel DrawOnce(const RandomPlants& plants, std::mt19937_64& engine) {
  ProcessModel model = ChannelsOf(plants);
  for (int i = 0; i < plants.outputs; ++i) {
    for (int j = 0; j < plants.inputs; ++j) {
      const double size = LogUniform(plants.gain, engine);
      const double gain = DrawUniform(engine) < 0.5 ? -size : size;
      const double time_constant = Uniform(plants.time_constant, engine);
      model.element(i, j) = TransferFunction::FirstOrder(
          gain, time_constant, Uniform(plants.delay, engine));
    }
  }
  return model;
}

// Ratio of the largest singular value to the smallest.
double ConditionNumber(const ProcessModel& model) {
  const Eigen::VectorXd values =
      Eigen::JacobiSVD<Eigen::MatrixXd>(StaticGains(model)).singularValues();
  return values(0) / values(values.size() - 1);
}

// Whether the loop is stable and calm with the model true.
absl::StatusOr<bool> IsControlled(const ProcessModel& model,
                                  const ControllerSpec& spec,
                                  double max_sensitivity) {
  MLE_ASSIGN_OR_RETURN(const control::MpcOptions options,
                       spec.For(model.num_outputs(), model.num_inputs()));
  MLE_ASSIGN_OR_RETURN(const control::Mpc mpc,
                       control::Mpc::Create(model, options));
  MLE_ASSIGN_OR_RETURN(
      const control::PredictionModel plant,
      control::PredictFromProcess(model, options.control_period));
  MLE_ASSIGN_OR_RETURN(const control::LoopAnalysis loop,
                       control::AnalyseLoop(mpc, plant));
  return loop.stable && loop.sensitivity_peak <= max_sensitivity;
}

std::vector<PairPlace> MatchingElements(const ProcessModel& model,
                                        const Change& change) {
  std::vector<PairPlace> pairs;
  for (const auto& [i, j] : Pairs(model)) {
    const bool matches =
        (change.output == "*" || change.output == model.outputs()[i].name) &&
        (change.input == "*" || change.input == model.inputs()[j].name);
    if (matches && !model.element(i, j).IsZero()) pairs.push_back({i, j});
  }
  return pairs;
}

absl::Status CheckChange(const ProcessModel& model, const Change& change,
                         double size) {
  const std::vector<PairPlace> pairs = MatchingElements(model, change);
  if (pairs.empty()) {
    return InvalidArgument("a change of output '", change.output,
                           "' and input '", change.input,
                           "' matches no element that is not zero");
  }
  if (change.elements > static_cast<int>(pairs.size())) {
    return InvalidArgument("a change of ", change.elements,
                           " elements matches only ", pairs.size(),
                           " that are not zero");
  }
  const double shift =
      std::min(size * change.delay_shift.from, size * change.delay_shift.to);
  for (const auto& [i, j] : pairs) {
    const double delay = model.element(i, j).delay();
    if (delay + shift >= 0.0) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "a shift of %g would make the dead time of %s ← %s, %g, negative",
        shift, model.outputs()[i].name, model.inputs()[j].name, delay));
  }
  return absl::OkStatus();
}

// Those of a change that are to be changed, in the order of the model.
std::vector<PairPlace> DrawElements(const ProcessModel& model,
                                    const Change& change,
                                    std::mt19937_64& engine) {
  std::vector<PairPlace> pairs = MatchingElements(model, change);
  if (change.elements == 0) return pairs;
  std::vector<PairPlace> drawn;
  auto left = static_cast<double>(pairs.size());
  int wanted = change.elements;
  for (const PairPlace& pair : pairs) {
    if (DrawUniform(engine) * left < wanted) {
      drawn.push_back(pair);
      --wanted;
    }
    --left;
  }
  return drawn;
}

}  // namespace

absl::StatusOr<ProcessModel> DrawModel(
    const RandomPlants& plants, std::uint64_t seed,
    const std::vector<ControllerSpec>& controllers) {
  std::mt19937_64 engine = SeededEngine(seed, kPlantStream, 0);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    ProcessModel model = DrawOnce(plants, engine);
    if (!(ConditionNumber(model) <= plants.max_condition_number)) continue;
    bool good = true;
    for (const ControllerSpec& controller : controllers) {
      MLE_ASSIGN_OR_RETURN(
          const bool controlled,
          IsControlled(model, controller, plants.max_sensitivity));
      good = good && controlled;
    }
    if (good) return model;
  }
  return absl::FailedPreconditionError(absl::StrFormat(
      "none of %d plants drawn has a condition number up to %g and a loop with "
      "a sensitivity peak up to %g: widen the ranges",
      kMaxDraws, plants.max_condition_number, plants.max_sensitivity));
}

absl::Status CheckAgeing(const ProcessModel& model, const Mismatch& mismatch) {
  for (const Change& change : mismatch.changes) {
    MLE_RETURN_IF_ERROR(CheckChange(model, change, mismatch.size));
  }
  return absl::OkStatus();
}

absl::StatusOr<ProcessModel> AgeModel(const ProcessModel& model,
                                      const Mismatch& mismatch,
                                      std::uint64_t seed) {
  if (mismatch.plant.has_value()) return *mismatch.plant;
  ProcessModel aged = model;
  for (std::size_t c = 0; c < mismatch.changes.size(); ++c) {
    const Change& change = mismatch.changes[c];
    std::mt19937_64 engine =
        SeededEngine(seed, kAgeingStream, static_cast<std::uint32_t>(c));
    for (const auto& [i, j] : DrawElements(aged, change, engine)) {
      const double gain = LogUniform(change.gain_factor, engine);
      const double tau = LogUniform(change.time_constant_factor, engine);
      const double shift = mismatch.size * Uniform(change.delay_shift, engine);
      if (!(aged.element(i, j).delay() + shift >= 0.0)) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "mismatch '%s': a shift of %g would make the dead time of %s ← %s, "
            "%g, negative",
            mismatch.name, shift, aged.outputs()[i].name, aged.inputs()[j].name,
            aged.element(i, j).delay()));
      }
      const sim::ElementAgeing ageing = {
          .output = i,
          .input = j,
          .gain = sim::Schedule(std::pow(gain, mismatch.size)),
          .time_constant = sim::Schedule(std::pow(tau, mismatch.size)),
          .delay = sim::Schedule(shift)};
      aged.element(i, j) = sim::AgedElement(aged.element(i, j), ageing, 0.0);
    }
  }
  const absl::Status valid = aged.Validate();
  if (!valid.ok()) return valid;
  return aged;
}

}  // namespace mle::experiment
