#include "apps/lifecycle/flags.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/flag_parser.h"
#include "apps/correct/solver_flags.h"
#include "apps/lifecycle/durations.h"
#include "apps/lifecycle/loop_flags.h"
#include "apps/lifecycle/price_flags.h"
#include "gflags/gflags.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"
#include "sim/ageing_json.h"

DEFINE_string(model, "",
              "Process model (JSON) as commissioned, the first model of every "
              "controller. Must be given.");
DEFINE_string(plant, "",
              "Process model (JSON) of the plant at time 0. Empty: --model.");
DEFINE_string(ageing, "",
              "Ageing schedule (JSON) of the plant's elements. Must be given.");
DEFINE_string(ageing_rates, "1",
              "Rates of ageing, ≥ 0: at 2 the changes of gains, time constants "
              "and dead times of --ageing are twice as large at the same time, "
              "at 0 nothing ages.");
DEFINE_double(years, 5.0, "Years of operation, > 0.");
DEFINE_string(change_every, "30d",
              "Mean time between set-point changes (s, min, h, d, w, y); the "
              "times are uniform from half to one and a half times the mean.");
DEFINE_string(setpoint_range, "1",
              "Set points are drawn from ± this value, > 0: one value, or one "
              "for each output.");
DEFINE_string(policies,
              "never,structured:1,combined:1,arx:1,test:12,on_demand:0.7,"
              "perfect",
              "Policies to compare: never; structured:N, combined:N, arx:N "
              "(corrected after every N-th set-point change); test:M (a step "
              "test every M months); on_demand:T (a step test when the "
              "performance index of a change falls below T); perfect.");
DEFINE_int32(seeds, 5, "Number of seeds, 1 … 10000.");
DEFINE_uint64(first_seed, 1, "First of the consecutive seeds.");
DEFINE_string(out, "lifecycle",
              "Folder for report.html, result.json, lifecycle.csv, the figures "
              "and runs/, from which an interrupted run resumes.");
DEFINE_bool(figures, true, "Draw the figures (PNG and PDF need rsvg-convert).");
DEFINE_int32(threads, 0,
             "Threads; 0: one for each processor. The results do not depend on "
             "the number.");

DEFINE_int32(
    windows, 4,
    "A correction uses the records of this many last set-point changes, ≥ 1.");
DEFINE_string(window_age, "",
              "Maximum age of the records of a correction (s, min, h, d, w, "
              "y). Empty: no maximum.");
DEFINE_double(forgetting, 1.0,
              "Weight w of the record before the last, w² of that before, …, "
              "in (0, 1]; estimator structured only.");
DEFINE_double(
    false_alarm_probability, 0.01,
    "Probability, in (0, 1), of a false alarm of the test of no change.");
DEFINE_bool(calibrate_test, false,
            "Calibrates the test of no change by simulation where it is in "
            "doubt, as mle_correct does: several times slower. If false, "
            "hold-out validation alone guards against false alarms.");
DEFINE_int32(
    validation_folds, 4,
    "Maximum number of folds of the hold-out validation over windows, ≥ 2.");
DEFINE_double(least_gain, 0.0,
              "A correction is refused unless it raises the held-out "
              "log-likelihood by more than this value, ≥ 0.");
DEFINE_double(watch_limit, 3.0,
              "A new model is watched for --quiet_stretch and reverted if the "
              "measured squared error of an output exceeds this many times its "
              "value before the last change, > 1; 0: never.");
DEFINE_int32(order, 0,
             "Order d of the ARX model, in samples; 0: 1.25 times the largest "
             "sum of dead time and time constant of an element.");
DEFINE_int32(
    conversion_samples, 50000,
    "Number of samples of the excitation for the conversion to an ARX model.");
DEFINE_double(response_horizon, 0.0,
              "Length of the step responses compared with the plant's, in the "
              "model's time unit (min); 0: the model's settling time.");
DEFINE_double(test_hold, 0.0,
              "Duration of each step of a step test (min); 0: the model's "
              "settling time.");
DEFINE_int32(test_cycles, 1,
             "Number of steps up and back of each input in a step test, ≥ 1.");
DEFINE_string(test_move, "",
              "Largest expected move of an output in a step test, > 0: one "
              "value, or one for each output. Empty: --setpoint_range.");

namespace mle::lifecycle {
namespace {

constexpr int kMaxSeeds = 10000;
constexpr double kMaxRate = 100.0;

// What does not change a life.
const std::set<std::string> kNotOfALife = {
    "model",    "plant",   "ageing",           "ageing_rates",
    "policies", "seeds",   "first_seed",       "out",
    "figures",  "threads", "hours_per_update", "hours_per_test"};

absl::Status Of(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, ": ", status.message()));
}

template <typename Value>
absl::Status Refuse(const char* flag, Value value, const char* wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, "=", value, ": ", wanted));
}

absl::Status CheckNumbers() {
  if (FLAGS_seeds < 1 || FLAGS_seeds > kMaxSeeds) {
    return Refuse("seeds", FLAGS_seeds, "from 1 to 10000 are possible");
  }
  if (FLAGS_first_seed > std::numeric_limits<std::uint64_t>::max() -
                             static_cast<std::uint64_t>(FLAGS_seeds)) {
    return Refuse("first_seed", FLAGS_first_seed,
                  "--seeds of them go beyond the largest");
  }
  const std::pair<const char*, int> not_negative[] = {
      {"threads", FLAGS_threads}, {"order", FLAGS_order}};
  for (const auto& [flag, value] : not_negative) {
    if (value < 0) return Refuse(flag, value, "it must not be negative");
  }
  if (FLAGS_windows < 1 || FLAGS_windows > 1000) {
    return Refuse("windows", FLAGS_windows, "from 1 to 1000 are possible");
  }
  if (FLAGS_test_cycles < 1 || FLAGS_test_cycles > 1000) {
    return Refuse("test_cycles", FLAGS_test_cycles,
                  "from 1 to 1000 are possible");
  }
  if (FLAGS_validation_folds < 2) {
    return Refuse("validation_folds", FLAGS_validation_folds,
                  "at least 2 are needed");
  }
  if (FLAGS_conversion_samples < 100 || FLAGS_conversion_samples > 10'000'000) {
    return Refuse("conversion_samples", FLAGS_conversion_samples,
                  "from 100 to 10,000,000 are possible");
  }
  if (!(FLAGS_years > 0.0) || !(FLAGS_years <= 1000.0)) {
    return Refuse("years", FLAGS_years, "it must be > 0 and at most 1000");
  }
  if (FLAGS_watch_limit != 0.0 && !(FLAGS_watch_limit > 1.0)) {
    return Refuse("watch_limit", FLAGS_watch_limit,
                  "it must be larger than 1, or 0 for none");
  }
  if (!(FLAGS_forgetting > 0.0 && FLAGS_forgetting <= 1.0)) {
    return Refuse("forgetting", FLAGS_forgetting, "it must be in (0, 1]");
  }
  if (!(FLAGS_false_alarm_probability > 0.0 &&
        FLAGS_false_alarm_probability < 1.0)) {
    return Refuse("false_alarm_probability", FLAGS_false_alarm_probability,
                  "it must lie between 0 and 1");
  }
  const std::pair<const char*, double> finite[] = {
      {"least_gain", FLAGS_least_gain},
      {"response_horizon", FLAGS_response_horizon},
      {"test_hold", FLAGS_test_hold}};
  for (const auto& [flag, value] : finite) {
    if (!std::isfinite(value) || value < 0.0) {
      return Refuse(flag, value, "it must be finite and not negative");
    }
  }
  return absl::OkStatus();
}

absl::Status ReadModels(Campaign& campaign) {
  if (FLAGS_model.empty() || FLAGS_ageing.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json and --ageing=FILE.json must be given (see --help)");
  }
  absl::StatusOr<ProcessModel> model = ReadProcessModel(FLAGS_model);
  if (!model.ok()) return Of("model", model.status());
  campaign.model = *model;
  campaign.plant = *model;
  if (!(SettlingTime(campaign.model) > 0.0)) {
    return Of("model", absl::InvalidArgumentError(
                           absl::StrCat(FLAGS_model,
                                        " has no element with a time constant "
                                        "or a dead time: nothing can age")));
  }
  if (!FLAGS_plant.empty()) {
    absl::StatusOr<ProcessModel> plant = ReadProcessModel(FLAGS_plant);
    if (!plant.ok()) return Of("plant", plant.status());
    if (const absl::Status same =
            CheckSameChannels(*model, FLAGS_model, *plant, FLAGS_plant);
        !same.ok()) {
      return Of("plant", same);
    }
    campaign.plant = *std::move(plant);
  }
  absl::StatusOr<sim::AgeingSchedule> ageing =
      sim::ReadAgeingSchedule(FLAGS_ageing, campaign.plant);
  if (!ageing.ok()) return Of("ageing", ageing.status());
  campaign.ageing = *std::move(ageing);
  return absl::OkStatus();
}

absl::Status ReadRates(Campaign& campaign) {
  for (const std::string& part : ParseList(FLAGS_ageing_rates)) {
    double rate = 0.0;
    if (!absl::SimpleAtod(part, &rate) || !(rate >= 0.0) || rate > kMaxRate) {
      return Of("ageing_rates",
                absl::InvalidArgumentError(absl::StrCat(
                    "'", part, "' is not a rate from 0 to ", kMaxRate)));
    }
    if (std::count(campaign.rates.begin(), campaign.rates.end(), rate) > 0) {
      return Of("ageing_rates", absl::InvalidArgumentError(
                                    absl::StrCat("'", part, "' stands twice")));
    }
    absl::StatusOr<sim::AgeingSchedule> scaled =
        sim::ScaleAgeing(campaign.ageing, rate);
    absl::Status status = scaled.status();
    if (status.ok()) status = scaled->Validate(campaign.plant);
    if (!status.ok()) {
      return Of("ageing_rates", absl::InvalidArgumentError(absl::StrCat(
                                    "at ", part, ": ", status.message())));
    }
    campaign.rates.push_back(rate);
  }
  if (campaign.rates.empty()) {
    return Of("ageing_rates", absl::InvalidArgumentError("names no rate"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Eigen::VectorXd> PositiveNumbers(const char* flag,
                                                const std::string& value,
                                                int count) {
  MLE_ASSIGN_OR_RETURN(Eigen::VectorXd numbers,
                       ParseNumbers(flag, value, count));
  if ((numbers.array() > 0.0).all()) return numbers;
  return Refuse(flag, value, "every value must be > 0");
}

double RoundUp(double value, double unit) {
  return std::ceil(value / unit - 1e-9) * unit;
}

absl::Status SetLife(Request& request) {
  Campaign& campaign = request.campaign;
  LifeOptions& life = campaign.life;
  const double settling = SettlingTime(campaign.model);
  const double period = life.operation.controller.control_period;
  life.windows = FLAGS_windows;
  life.watch_limit = FLAGS_watch_limit > 0.0
                         ? FLAGS_watch_limit
                         : std::numeric_limits<double>::infinity();
  life.forgetting = FLAGS_forgetting;
  life.month = kHoursPerYear / 12.0 / request.hours_per_unit;
  if (!FLAGS_window_age.empty()) {
    const absl::StatusOr<double> hours = ParseHours(FLAGS_window_age);
    if (!hours.ok()) return Of("window_age", hours.status());
    life.window_age = *hours / request.hours_per_unit;
  }
  life.test.hold =
      RoundUp(FLAGS_test_hold > 0.0 ? FLAGS_test_hold : settling, period);
  life.test.cycles = FLAGS_test_cycles;
  life.test.move = campaign.set_points.range;
  if (!FLAGS_test_move.empty()) {
    MLE_ASSIGN_OR_RETURN(life.test.move,
                         PositiveNumbers("test_move", FLAGS_test_move,
                                         campaign.model.num_outputs()));
  }
  UpdateOptions& update = life.update;
  CorrectOptions& correct = update.correct;
  correct.estimation.structured.false_alarm_probability =
      FLAGS_false_alarm_probability;
  if (!FLAGS_calibrate_test) {
    correct.estimation.change_test = ChangeTest::kChiSquare;
  }
  correct.estimation.conversion.order = FLAGS_order;
  correct.estimation.conversion.samples = FLAGS_conversion_samples;
  MLE_RETURN_IF_ERROR(correct::SetSolver(correct.estimation));
  correct.hold_out.max_folds = FLAGS_validation_folds;
  correct.decision.least_gain = FLAGS_least_gain;
  update.control_period = period;
  const double horizon =
      FLAGS_response_horizon > 0.0 ? FLAGS_response_horizon : settling;
  update.response_samples =
      1 +
      static_cast<int>(std::ceil(horizon / life.operation.sample_time - 1e-9));
  return absl::OkStatus();
}

absl::Status SetSetPoints(Request& request) {
  Campaign& campaign = request.campaign;
  const absl::StatusOr<double> every = ParseHours(FLAGS_change_every);
  if (!every.ok()) return Of("change_every", every.status());
  MLE_ASSIGN_OR_RETURN(campaign.set_points.range,
                       PositiveNumbers("setpoint_range", FLAGS_setpoint_range,
                                       campaign.model.num_outputs()));
  campaign.set_points.duration =
      FLAGS_years * kHoursPerYear / request.hours_per_unit;
  campaign.set_points.change_every = *every / request.hours_per_unit;
  campaign.set_points.grid = campaign.life.operation.controller.control_period;
  if (const absl::Status status = campaign.set_points.Validate();
      !status.ok()) {
    return Of("change_every", status);
  }
  return absl::OkStatus();
}

// Whether all that is done about a change fits in before the next.
absl::Status CheckGaps(const Campaign& campaign) {
  const OperationOptions& operation = campaign.life.operation;
  const double test =
      PlanStepTest(campaign.model, campaign.life.test).duration();
  const double watch = operation.quiet_stretch;
  const double needed = operation.Lead() + operation.after + test + watch;
  const double shortest = campaign.set_points.ShortestGap();
  if (needed <= shortest) return absl::OkStatus();
  return Of("change_every",
            absl::InvalidArgumentError(absl::StrCat(
                FLAGS_change_every, ": changes follow each other after ",
                shortest, " ", campaign.model.time_unit(),
                " at the least, but what is simulated of one (--quiet_stretch, "
                "--warm_up, --window, --quiet_stretch again with a new "
                "model, a step test of ",
                test, ") takes ", needed)));
}

absl::Status AddSettings(Campaign& campaign) {
  for (const FlagText& flag : CommandFlags()) {
    if (kNotOfALife.count(flag.name) > 0) continue;
    if (flag.name.rfind("price_", 0) == 0) continue;
    campaign.settings[flag.name] = flag.value;
  }
  MLE_ASSIGN_OR_RETURN(campaign.settings["file of ageing"],
                       ReadFile(FLAGS_ageing));
  campaign.settings["file of model"] = FormatProcessModel(campaign.model);
  campaign.settings["file of plant"] = FormatProcessModel(campaign.plant);
  campaign.settings["program_version"] = std::string(Version());
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Request> RequestFromFlags() {
  MLE_RETURN_IF_ERROR(CheckNumbers());
  Request request;
  Campaign& campaign = request.campaign;
  MLE_RETURN_IF_ERROR(ReadModels(campaign));
  const absl::StatusOr<double> hours = HoursPerUnit(campaign.model.time_unit());
  if (!hours.ok()) return Of("model", hours.status());
  request.hours_per_unit = *hours;
  request.years = FLAGS_years;
  request.figures = FLAGS_figures;
  MLE_RETURN_IF_ERROR(ReadRates(campaign));
  absl::StatusOr<std::vector<Policy>> policies = ParsePolicies(FLAGS_policies);
  if (!policies.ok()) return Of("policies", policies.status());
  campaign.policies = *std::move(policies);
  for (int s = 0; s < FLAGS_seeds; ++s) {
    campaign.seeds.push_back(FLAGS_first_seed + static_cast<std::uint64_t>(s));
  }
  MLE_RETURN_IF_ERROR(SetPeriods(campaign.life.operation));
  MLE_RETURN_IF_ERROR(SetSetPoints(request));
  MLE_RETURN_IF_ERROR(SetOperation(campaign.model, campaign.set_points.range,
                                   request.hours_per_unit,
                                   campaign.life.operation));
  MLE_RETURN_IF_ERROR(SetLife(request));
  MLE_RETURN_IF_ERROR(CheckGaps(campaign));
  MLE_ASSIGN_OR_RETURN(request.prices, PricesFromFlags(campaign.model));
  campaign.folder = FLAGS_out;
  campaign.threads = static_cast<int>(
      std::min(static_cast<unsigned>(FLAGS_threads),
               std::max(std::thread::hardware_concurrency(), 1u)));
  MLE_RETURN_IF_ERROR(AddSettings(campaign));
  return request;
}

}  // namespace mle::lifecycle
