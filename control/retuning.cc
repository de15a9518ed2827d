#include "control/retuning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "control/mpc.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;

constexpr int kMostDoublings = 40;

// A pair of output and input whose element a rule rests on.
struct Pair {
  int output = 0;
  int input = 0;
};

std::string NameOf(const std::vector<std::string>& names, const char* kind,
                   int channel) {
  return channel < static_cast<int>(names.size())
             ? names[channel]
             : absl::StrCat(kind, " ", channel + 1);
}

std::string NameOf(Pair pair, const RetuningOptions& options) {
  return absl::StrCat(NameOf(options.output_names, "output", pair.output),
                      " ← ", NameOf(options.input_names, "input", pair.input));
}

// The elements between the outputs and the manipulated inputs that matter.
class Elements {
 public:
  Elements(const std::vector<FirstOrder>& elements,
           const std::vector<InputRole>& roles)
      : elements_(elements), num_inputs_(static_cast<int>(roles.size())) {
    for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
      const Pair pair{e / num_inputs_, e % num_inputs_};
      if (roles[pair.input] == InputRole::kManipulated &&
          at(pair).gain != 0.0) {
        pairs_.push_back(pair);
      }
    }
  }

  const FirstOrder& at(Pair pair) const {
    return elements_[static_cast<std::size_t>(pair.output) * num_inputs_ +
                     pair.input];
  }
  const std::vector<Pair>& pairs() const { return pairs_; }

  // The pair for which `value` is largest.
  template <typename Function>
  Pair Largest(const Function& value) const {
    return *std::max_element(pairs_.begin(), pairs_.end(),
                             [&](const Pair& a, const Pair& b) {
                               return value(at(a)) < value(at(b));
                             });
  }

 private:
  const std::vector<FirstOrder>& elements_;
  int num_inputs_;
  std::vector<Pair> pairs_;
};

std::string Time(double value, const RetuningOptions& options) {
  return options.time_unit.empty()
             ? absl::StrFormat("%.3g", value)
             : absl::StrFormat("%.3g %s", value, options.time_unit);
}

std::string Describe(const FirstOrder& element,
                     const RetuningOptions& options) {
  return absl::StrCat("time constant ", Time(element.time_constant, options),
                      ", dead time ", Time(element.delay, options));
}

double ChoosePeriod(const Elements& elements, double sample_time,
                    const MpcOptions& old_tuning,
                    const RetuningOptions& options,
                    std::vector<std::string>& reasons) {
  const auto own_period = [](const FirstOrder& element) {
    return std::max(0.1 * element.time_constant, 0.5 * element.delay);
  };
  const Pair pair = elements.Largest(
      [&](const FirstOrder& element) { return -own_period(element); });
  const double rule = own_period(elements.at(pair));
  double period = rule;
  if (sample_time > 0.0) {
    period = sample_time * std::max(1.0, std::floor(rule / sample_time + 1e-9));
  }
  if (!(period > 0.0)) period = old_tuning.control_period;
  const std::string basis = absl::StrCat(
      "the smallest over all pairs of the larger of 0.1 time constants and 0.5 "
      "dead times is ",
      Time(rule, options), ", at ", NameOf(pair, options), " (",
      Describe(elements.at(pair), options), "; Shridhar and Cooper, 1998)");
  if (options.keep_control_period) {
    reasons.push_back(absl::StrCat(
        "control period: ", Time(old_tuning.control_period, options),
        ", kept for the running loop; ", basis));
    return old_tuning.control_period;
  }
  reasons.push_back(
      absl::StrCat("control period: ", Time(old_tuning.control_period, options),
                   " → ", Time(period, options), ": ", basis));
  return period;
}

// k of the header.
double DeadPeriods(const FirstOrder& element, double period) {
  return element.delay / period + 2.0;
}

void ChooseHorizons(const Elements& elements, const RetuningOptions& options,
                    const MpcOptions& old_tuning, MpcOptions& tuning,
                    std::vector<std::string>& reasons) {
  const double period = tuning.control_period;
  const auto to_settle = [&](const FirstOrder& element) {
    const double dead = DeadPeriods(element, period);
    return element.integrating
               ? kLevelSettlingTimes * (element.time_constant + element.delay) /
                         period +
                     dead
               : 5.0 * element.time_constant / period + dead;
  };
  const auto to_move = [&](const FirstOrder& element) {
    return element.time_constant / period + DeadPeriods(element, period);
  };
  // A rounding above a whole number is no further period.
  const auto rounded_up = [](double value) {
    return static_cast<int>(std::min(std::ceil(value - 1e-9), 1e6));
  };
  const Pair slowest = elements.Largest(to_settle);
  tuning.prediction_horizon = rounded_up(to_settle(elements.at(slowest)));
  reasons.push_back(absl::StrCat(
      "prediction horizon: ", old_tuning.prediction_horizon, " → ",
      tuning.prediction_horizon, " periods, ",
      Time(tuning.prediction_horizon * period, options),
      ": until the slowest pair, ", NameOf(slowest, options), " (",
      Describe(elements.at(slowest), options), "), has settled: ",
      elements.at(slowest).integrating
          ? "10 times dead time and time constant together, what a loop on a "
            "level takes, and the dead time and 2 periods"
          : "5 time constants, the dead time and 2 periods (Shridhar and "
            "Cooper, 1998, and a period for the move to act)"));

  const Pair latest = elements.Largest(to_move);
  const int rule = rounded_up(to_move(elements.at(latest)));
  tuning.control_horizon = std::min(
      {rule, options.longest_control_horizon, tuning.prediction_horizon});
  tuning.block_lengths.clear();
  reasons.push_back(absl::StrCat(
      "control horizon: ", old_tuning.MoveInstants().size(), " → ",
      tuning.control_horizon, " moves: until ", NameOf(latest, options),
      elements.at(latest).integrating
          ? " is on its ramp, "
          : " has reached 63 % of its final value, ",
      rule, " periods (Shridhar and Cooper, 1998)",
      rule > tuning.control_horizon ? ", cut to the longest allowed" : ""));
}

// The mean diagonal entry of the control problem's Hessian that an element has
// for one of H_c moves, in squared output per squared input.
double MeanCurvature(const FirstOrder& element, double period, double H_p,
                     double H_c) {
  const double K = element.gain;
  const double lag = element.time_constant / period;
  if (!element.integrating) {
    const double periods = H_p - DeadPeriods(element, period) - 1.5 * lag +
                           2.0 - 0.5 * (H_c - 1.0);
    return K * K * std::max(periods, 0.0);
  }
  // Σ x² = N (N + 1)(2N + 1)/6 over the N periods of the ramp after each move,
  // and over the horizon that the slope at the end is weighted with.
  const auto squares = [](double N) {
    return N > 0.0 ? N * (N + 1.0) * (2.0 * N + 1.0) / 6.0 : 0.0;
  };
  double sum = squares(H_p);
  for (int move = 0; move < static_cast<int>(H_c); ++move) {
    sum += squares(H_p + 1.0 - move - DeadPeriods(element, period) - lag) / H_c;
  }
  return K * K * period * period * sum;
}

void ChooseMoveWeights(const Elements& elements,
                       const std::vector<InputRole>& roles,
                       const RetuningOptions& options, MpcOptions& tuning,
                       std::vector<std::string>& reasons) {
  const double period = tuning.control_period;
  const double H_p = tuning.prediction_horizon;
  const double H_c = tuning.control_horizon;
  const MatrixXd old_weight = tuning.move_weight;
  for (std::size_t j = 0; j < roles.size(); ++j) {
    if (roles[j] != InputRole::kManipulated) continue;
    double sum = 0.0;
    for (const Pair& pair : elements.pairs()) {
      if (pair.input != static_cast<int>(j)) continue;
      sum += tuning.output_weight(pair.output, pair.output) *
             MeanCurvature(elements.at(pair), period, H_p, H_c);
    }
    const double weight = H_c / options.condition_number * sum;
    if (!(weight > 0.0)) continue;
    tuning.move_weight.row(j).setZero();
    tuning.move_weight.col(j).setZero();
    tuning.move_weight(j, j) = weight;
    reasons.push_back(absl::StrFormat(
        "move weight of %s: %.3g → %.3g: gives the control problem a "
        "condition number of about %g (Shridhar and Cooper, 1998)",
        NameOf(options.input_names, "input", static_cast<int>(j)),
        old_weight(j, j), weight, options.condition_number));
  }
}

// The loop of a controller with this model and tuning.
absl::StatusOr<LoopAnalysis> Analyse(const PredictionModel& model,
                                     const MpcOptions& tuning,
                                     const PredictionModel& plant) {
  MLE_ASSIGN_OR_RETURN(const Mpc mpc, Mpc::Create(model, tuning));
  return AnalyseLoop(mpc, plant);
}

// Doubles the move weights until the loop is stable and not too sensitive.
absl::Status MakeRobust(const PredictionModel& model,
                        const RetuningOptions& options,
                        RetuningAdvice& advice) {
  const auto good = [&] {
    return advice.retuned.stable &&
           advice.retuned.sensitivity_peak <= options.largest_sensitivity_peak;
  };
  int doublings = 0;
  while (true) {
    MLE_ASSIGN_OR_RETURN(const Mpc mpc, Mpc::Create(model, advice.tuning));
    MLE_ASSIGN_OR_RETURN(advice.retuned,
                         AnalyseLoop(mpc, model, /*find_fastest=*/false));
    if (good() || doublings == kMostDoublings) break;
    advice.tuning.move_weight *= 2.0;
    ++doublings;
  }
  if (!advice.retuned.stable) {
    return absl::FailedPreconditionError(
        "no move weight makes the loop with the corrected model stable");
  }
  if (doublings > 0) {
    advice.reasons.push_back(absl::StrFormat(
        "move weights: all doubled %d times, for a sensitivity peak of %.2f "
        "where at most %g is allowed (Skogestad and Postlethwaite, 2005)%s",
        doublings, advice.retuned.sensitivity_peak,
        options.largest_sensitivity_peak, good() ? "" : "; it is not reached"));
  }
  return absl::OkStatus();
}

void JudgeOldTuning(RetuningAdvice& advice, double largest_peak) {
  const auto verdict = [&](const LoopAnalysis& loop) {
    if (!loop.stable) return "; it must not continue like this";
    return loop.sensitivity_peak > largest_peak
               ? "; it amplifies disturbances more than it should"
               : "; acceptable";
  };
  advice.reasons.push_back(absl::StrCat(
      "the running controller on the corrected model: ", advice.running.Brief(),
      verdict(advice.running)));
  advice.reasons.push_back(absl::StrCat(
      "the corrected model with the old tuning: ", advice.exchanged.Brief(),
      verdict(advice.exchanged)));
  advice.reasons.push_back(absl::StrCat(
      "the corrected model with the new tuning: ", advice.retuned.Brief(),
      verdict(advice.retuned)));
}

}  // namespace

absl::Status RetuningOptions::Validate() const {
  if (!(condition_number > 1.0) || !std::isfinite(condition_number)) {
    return InvalidArgument("condition_number = ", condition_number,
                           ", but it must be finite and > 1");
  }
  if (longest_control_horizon < 1) {
    return InvalidArgument("longest_control_horizon = ",
                           longest_control_horizon, ", but it must be ≥ 1");
  }
  if (!(largest_sensitivity_peak > 1.0)) {
    return InvalidArgument("largest_sensitivity_peak = ",
                           largest_sensitivity_peak, ", but it must be > 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<MpcOptions> TuneByRules(const std::vector<FirstOrder>& elements,
                                       const std::vector<InputRole>& roles,
                                       double sample_time,
                                       const MpcOptions& old_tuning,
                                       const RetuningOptions& options,
                                       std::vector<std::string>& reasons) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (roles.empty() || elements.size() % roles.size() != 0) {
    return InvalidArgument(elements.size(), " elements are not p × m for ",
                           roles.size(), " inputs");
  }
  MLE_RETURN_IF_ERROR(
      old_tuning.Validate(static_cast<int>(elements.size() / roles.size()),
                          static_cast<int>(roles.size())));
  const Elements relevant(elements, roles);
  if (relevant.pairs().empty()) {
    return absl::InvalidArgumentError(
        "no manipulated input reaches an output, so there is nothing to tune");
  }
  MpcOptions tuning = old_tuning;
  tuning.control_period =
      ChoosePeriod(relevant, sample_time, old_tuning, options, reasons);
  ChooseHorizons(relevant, options, old_tuning, tuning, reasons);
  ChooseMoveWeights(relevant, roles, options, tuning, reasons);
  return tuning;
}

absl::StatusOr<RetuningAdvice> AdviseRetuning(const PredictionModel& old_model,
                                              const MpcOptions& old_tuning,
                                              const StepResponse& corrected,
                                              const RetuningOptions& options) {
  MLE_RETURN_IF_ERROR(old_model.Validate());
  if (corrected.num_outputs != old_model.num_outputs ||
      corrected.num_inputs != old_model.num_inputs()) {
    return InvalidArgument("the corrected model has ", corrected.num_outputs,
                           " outputs and ", corrected.num_inputs,
                           " inputs, the old one ", old_model.num_outputs,
                           " and ", old_model.num_inputs());
  }
  const auto predict = [&](double control_period) {
    return PredictFromStepResponse(corrected, old_model.roles, control_period);
  };
  MLE_ASSIGN_OR_RETURN(const PredictionModel plant,
                       predict(old_tuning.control_period));
  RetuningAdvice advice;
  MLE_ASSIGN_OR_RETURN(advice.elements, DescribeAsFirstOrder(corrected));
  MLE_ASSIGN_OR_RETURN(
      advice.tuning,
      TuneByRules(advice.elements, old_model.roles, corrected.sample_time,
                  old_tuning, options, advice.reasons));
  MLE_ASSIGN_OR_RETURN(const PredictionModel model,
                       predict(advice.tuning.control_period));
  absl::StatusOr<LoopAnalysis> running;
  absl::StatusOr<LoopAnalysis> exchanged;
  absl::Status made_robust;
  ParallelFor(3, options.threads, [&](int loop) {
    if (loop == 0) made_robust = MakeRobust(model, options, advice);
    if (loop == 1) running = Analyse(old_model, old_tuning, plant);
    if (loop == 2) exchanged = Analyse(plant, old_tuning, plant);
  });
  MLE_ASSIGN_OR_RETURN(advice.running, std::move(running));
  MLE_ASSIGN_OR_RETURN(advice.exchanged, std::move(exchanged));
  MLE_RETURN_IF_ERROR(made_robust);
  JudgeOldTuning(advice, options.largest_sensitivity_peak);
  return advice;
}

}  // namespace mle::control
