#include "apps/correct/next_move.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/result.h"
#include "apps/correct/usual_operation.h"
#include "control/first_order.h"
#include "control/mpc.h"
#include "control/retuning.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/segments.h"
#include "mle/maintain/stage.h"
#include "sim/closed_loop.h"
#include "sim/set_point_profile.h"

namespace mle::correct {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLongestInSettlingTimes = 10.0;
// Of a tuning that is not told, control periods until the model has settled.
constexpr double kPeriodsToSettle = 60.0;
// Samples of a plan beyond which none is sought.
constexpr double kMostPlanSamples = 2e5;
// Limits that are not told: standard deviations of usual operation at least,
// and shares of the width of the range there, beyond it.
constexpr double kLeastRoom = 15.0;
constexpr double kBeyondRange = 1.0;

// The questions: gains that are not known as well as wanted and, where it
// cannot be told whether an output has aged, all of its gains by the plan
// alone.
std::vector<PlanQuestion> QuestionsOf(const Result& result) {
  const ProcessModel& model = result.initial;
  const double wanted = result.request.next_move.error;
  std::vector<PlanQuestion> questions;
  for (const auto& [i, j] : Pairs(model)) {
    const PairErrors& pair = result.information.pair(i, j);
    if (pair.state == PairState::kAbsent ||
        model.inputs()[j].role != InputRole::kManipulated) {
      continue;
    }
    const std::string& name = model.outputs()[i].name;
    const bool doubtful =
        result.decision == Decision::kCannotTell &&
        std::any_of(result.reasons.begin(), result.reasons.end(),
                    [&](const Message& reason) {
                      return reason.place == name &&
                             reason.code != MessageCode::kPredictsBetter;
                    });
    if (!doubtful && pair.gain <= wanted) continue;
    questions.push_back(
        {.output = i, .input = j, .error = wanted, .alone = doubtful});
  }
  return questions;
}

// Drops questions about outputs without a noise. Why none is left, or empty.
std::string LeaveOutUnmeasured(const Result& result,
                               std::vector<PlanQuestion>& questions,
                               NextMove& move) {
  std::string last;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    const double variance = result.estimate.setting.noise[i].variance;
    if (variance > 0.0 && std::isfinite(variance)) continue;
    const auto is_of = [i](const PlanQuestion& one) { return one.output == i; };
    if (std::erase_if(questions, is_of) == 0) continue;
    last = absl::StrCat(result.initial.outputs()[i].name,
                        " is not measured in these records: nothing is planned "
                        "for it.");
    move.assumptions.push_back(last);
  }
  return questions.empty() ? last : "";
}

// As it is told, or by published rules.
absl::StatusOr<control::MpcOptions> TuningOf(const Result& result,
                                             const VectorXd& deviations,
                                             NextMove& move) {
  if (result.request.controller_known()) return result.request.controller;
  move.assumptions.push_back(
      "The controller's tuning is not told (--control_period and others): the "
      "loop is taken to be that of a predictive controller tuned by published "
      "rules.");
  const double sample_time = result.data.sample_time();
  control::MpcOptions before;
  before.control_period =
      sample_time * std::max(std::round(SettlingTime(result.initial) /
                                        (kPeriodsToSettle * sample_time)),
                             1.0);
  before.output_weight =
      deviations.cwiseAbs2().cwiseInverse().asDiagonal().toDenseMatrix();
  before.move_weight = MatrixXd::Identity(result.initial.num_inputs(),
                                          result.initial.num_inputs());
  const int samples = static_cast<int>(std::ceil(
                          3.0 * SettlingTime(result.initial) / sample_time)) +
                      1;
  MLE_ASSIGN_OR_RETURN(
      const std::vector<control::FirstOrder> elements,
      control::DescribeAsFirstOrder(result.initial.ComputeStepResponse(
          sample_time, std::max(samples, 10))));
  std::vector<std::string> unused;
  return control::TuneByRules(elements, InputRoles(result.initial), sample_time,
                              before, {.keep_control_period = true}, unused);
}

PlannedLoop LoopOf(control::Mpc mpc, double sample_time) {
  return [tuned = std::make_shared<const control::Mpc>(std::move(mpc)),
          sample_time](const ProcessModel& plant,
                       const MatrixXd& set_points) -> absl::StatusOr<Record> {
    control::Mpc running = *tuned;
    sim::ClosedLoopOptions options;
    options.sample_time = sample_time;
    options.control_period = running.options().control_period;
    options.duration = sample_time * static_cast<double>(set_points.cols() - 1);
    options.noise_variance = 0.0;
    absl::StatusOr<Record> record = sim::SimulateClosedLoop(
        plant,
        [&running](const auto& measured, const auto& wanted, auto next) {
          running.Step(measured, wanted, next);
        },
        sim::ProfileOf(set_points, sample_time), options);
    if (!record.ok()) {
      return absl::FailedPreconditionError(record.status().message());
    }
    if (!ComesToRest(*record)) {
      return absl::FailedPreconditionError("the loop does not settle");
    }
    return record;
  };
}

// "--plan_max_output" for what the library calls max_output.
absl::Status NamePlanFlag(const absl::Status& status) {
  constexpr std::string_view kBy = "plan: ";
  constexpr std::string_view kHold = "shortest_hold ";
  std::string text(status.message());
  if (!text.starts_with(kBy)) return status;
  text.erase(0, kBy.size());
  if (text.starts_with(kHold)) text.replace(0, kHold.size(), "quiet ");
  for (const char* name : {"min_output ", "max_output ", "min_input ",
                           "max_input ", "longest ", "quiet "}) {
    if (!text.starts_with(name)) continue;
    return absl::Status(status.code(), absl::StrCat("--plan_", text));
  }
  return absl::Status(status.code(), absl::StrCat("--plan: ", text));
}

// The limits told, or what the range in usual operation allows.
VectorXd LimitsOf(const VectorXd& told, const std::vector<ChannelUse>& uses,
                  const VectorXd& at, const VectorXd& deviations, double sign) {
  if (told.size() > 0) return told;
  VectorXd limits(at.size());
  for (Index c = 0; c < at.size(); ++c) {
    const ChannelUse& use = uses[static_cast<std::size_t>(c)];
    const double width = use.known ? use.high - use.low : 0.0;
    const double end = sign > 0.0 ? use.high : use.low;
    limits(c) = sign * kInfinity;
    // Nothing is known of how far an input may go that has stood still.
    if (!(width > 0.0)) continue;
    limits(c) = sign * std::max(sign * end + kBeyondRange * width,
                                sign * at(c) + kLeastRoom * deviations(c));
  }
  return limits;
}

void SetOperation(const Result& result, const Operation& operation,
                  PlanProblem& problem) {
  problem.output_deviations = Deviations(operation.outputs);
  problem.input_deviations = Deviations(operation.inputs);
  const int p = result.initial.num_outputs();
  problem.set_points.resize(p);
  for (int i = 0; i < p; ++i) {
    const ChannelUse& point = operation.set_points[i];
    problem.set_points(i) =
        point.known ? point.last : operation.outputs[i].last;
    // Never less than what the model leaves of the output.
    const NoiseEstimate& noise = problem.noise[i];
    problem.output_deviations(i) =
        std::max(problem.output_deviations(i),
                 std::sqrt(noise.variance + noise.ar_variance()));
  }
  problem.inputs.resize(result.initial.num_inputs());
  for (Index j = 0; j < problem.inputs.size(); ++j) {
    problem.inputs(j) = operation.inputs[static_cast<std::size_t>(j)].last;
  }
}

PlanOptions OptionsFor(const Result& result, const Operation& operation,
                       const PlanProblem& problem, double control_period,
                       NextMove& move) {
  const NextMoveOptions& given = result.request.next_move;
  const double settling = SettlingTime(result.initial);
  PlanOptions options;
  const auto outputs = [&](const VectorXd& told, double sign) {
    return LimitsOf(told, operation.outputs, problem.set_points,
                    problem.output_deviations, sign);
  };
  const auto inputs = [&](const VectorXd& told, double sign) {
    return LimitsOf(told, operation.inputs, problem.inputs,
                    problem.input_deviations, sign);
  };
  options.min_output = outputs(given.min_output, -1.0);
  options.max_output = outputs(given.max_output, 1.0);
  options.min_input = inputs(given.min_input, -1.0);
  options.max_input = inputs(given.max_input, 1.0);
  if (given.min_output.size() == 0 || given.max_output.size() == 0 ||
      given.min_input.size() == 0 || given.max_input.size() == 0) {
    move.assumptions.push_back(
        "Limits that are not told (--plan_max_output and others) are the "
        "width of a channel's range in usual operation beyond it.");
  }
  if (!given.set_points.empty()) {
    for (const OutputChannel& output : result.initial.outputs()) {
      options.movable.push_back(std::count(given.set_points.begin(),
                                           given.set_points.end(),
                                           output.name) > 0);
    }
  }
  options.longest = given.longest.value_or(kLongestInSettlingTimes * settling);
  options.shortest_hold = given.quiet;
  options.grid = control_period;
  options.threads = result.options.threads;
  move.priced =
      given.squared_price.size() > 0 || given.absolute_price.size() > 0;
  const double hours =
      SecondsPerUnit(result.initial.time_unit()).value_or(3600.0) / 3600.0;
  options.squared_price = hours * given.squared_price;
  options.absolute_price = hours * given.absolute_price;
  return options;
}

// The end of the records, or when the last change has settled.
void FindEarliest(const Result& result, NextMove& move) {
  if (result.data.records.empty()) return;
  const Record& record = result.data.records.back();
  const double end = record.time(record.samples() - 1);
  move.earliest = end;
  const std::vector<SetPointChange> changes = FindSetPointChanges(record);
  if (changes.empty()) return;
  const double settled =
      record.time(changes.back().sample) + SettlingTime(result.initial);
  if (settled <= end) return;
  move.at_once = false;
  move.earliest = settled;
  move.settling = result.initial.outputs()[changes.back().output].name;
}

// Why no plan can be made of these records; empty: one can.
std::string Obstacle(const Result& result) {
  if (!result.data.obstacles.empty()) {
    return absl::StrCat("Correct what forbids a correction first: ",
                        result.data.obstacles.front().text);
  }
  if (HasTransforms(result.initial)) {
    return "Moves are planned for linear models, and this one has a transform: "
           "make a linear one where the plan is to be (mle_convert --at).";
  }
  if (result.estimate.setting.noise.empty()) {
    return "Nothing was estimated from these records.";
  }
  return "";
}

}  // namespace

absl::StatusOr<NextMove> PlanNextMove(const Result& result) {
  NextMove move;
  FindEarliest(result, move);
  move.reason = Obstacle(result);
  if (!move.reason.empty()) return move;
  const Stage planning(result.options.progress, "planning the next move");
  MLE_RETURN_IF_ERROR(planning.status());
  PlanProblem problem;
  problem.plant = result.model;
  problem.sample_time = result.data.sample_time();
  problem.questions = QuestionsOf(result);
  problem.noise = result.estimate.setting.noise;
  move.reason = LeaveOutUnmeasured(result, problem.questions, move);
  if (!move.reason.empty()) return move;
  problem.windows = JoinAdjoining(result.data.Records()).records;
  const Operation operation = OperationIn(result);
  SetOperation(result, operation, problem);
  if (problem.questions.empty()) {
    move.plan = Plan();
    return move;
  }
  const absl::StatusOr<control::MpcOptions> tuning =
      TuningOf(result, problem.output_deviations, move);
  const absl::StatusOr<control::Mpc> mpc =
      tuning.ok() ? control::Mpc::Create(result.initial, *tuning)
                  : tuning.status();
  if (!mpc.ok()) {
    move.reason =
        absl::StrCat("No loop can be simulated: ", mpc.status().message(), ".");
    return move;
  }
  problem.loop = LoopOf(*mpc, problem.sample_time);
  move.options =
      OptionsFor(result, operation, problem, tuning->control_period, move);
  if (!((move.options.longest + 2.0 * SettlingTime(result.initial)) <=
        kMostPlanSamples * problem.sample_time)) {
    move.reason = "A plan of this length has too many samples.";
    return move;
  }
  absl::StatusOr<Plan> plan = FindPlan(problem, move.options);
  if (absl::IsInvalidArgument(plan.status())) {
    return NamePlanFlag(plan.status());
  }
  if (!plan.ok()) {
    move.reason =
        absl::StrCat("No plan was found: ", plan.status().message(), ".");
    return move;
  }
  move.usual = plan->cost / static_cast<double>(result.initial.num_outputs());
  move.plan = *std::move(plan);
  return move;
}

}  // namespace mle::correct
