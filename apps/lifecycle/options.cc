// The table of mle_lifecycle's options.

#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "apps/common/shared_options.h"
#include "apps/lifecycle/request.h"
#include "mle/base/status.h"

namespace mle::lifecycle {
namespace {

constexpr NumberRange kRates = Between(0.0, 100.0);
constexpr NumberRange kSeeds = Between(1, 10000);
constexpr NumberRange kThousand = Between(1, 1000);

TextValue PoliciesOf(Campaign& campaign) {
  return {.text = "never,output_error:1,arx:1,test:12,on_demand:0.7,perfect",
          .read = [&campaign](const std::string& text, const NumberRange&) {
            MLE_ASSIGN_OR_RETURN(campaign.policies, ParsePolicies(text));
            return absl::OkStatus();
          }};
}

TextValue CurrencyOf(Request& request) {
  return {.read = [&request](const std::string& text, const NumberRange&) {
    request.currency = text;
    return CheckCurrency(text);
  }};
}

// A length of time; blank, the default, leaves the field as it is.
TextValue HoursOrNever(double* hours) {
  TextValue value = Hours(hours, "");
  value.read = [read = value.read](const std::string& given,
                                   const NumberRange& range) {
    return given.empty() ? absl::OkStatus() : read(given, range);
  };
  return value;
}

std::vector<Option> PlantOptions(Request& request) {
  return {
      {"model", &request.model_path,
       "Process model (JSON) as commissioned, the first model of every "
       "controller. Must be given."},
      {"plant", &request.plant_path,
       "Process model (JSON) of the plant at time 0. Empty: --model."},
      {"ageing", &request.ageing_path,
       "Ageing schedule (JSON) of the plant's elements. Must be given."},
      {"ageing_rates", Numbers(&request.rates),
       "Rates of ageing: at 2 the changes of gains, time constants and dead "
       "times of --ageing are twice as large at the same time, at 0 nothing "
       "ages.",
       "", kRates},
  };
}

std::vector<Option> LifeOptionsOf(Request& request) {
  Campaign& campaign = request.campaign;
  return {
      {"years",
       &request.years,
       "Years of operation.",
       "years",
       {.min = 0.0, .max = 1000.0, .open_min = true}},
      {"change_every", Hours(&request.change_every_hours, "30d"),
       "Mean time between set-point changes; the times are uniform from half "
       "to one and a half times the mean.",
       "s, min, h, d, w or y"},
      {"setpoint_range", ForEachOutput(&campaign.set_points.range, "1"),
       "Set points are drawn from ± this value: one value, or one for each "
       "output.",
       "", kPositive},
      {"policies", PoliciesOf(campaign),
       "Policies to compare: never; output_error:N, arx:N "
       "(corrected after every N-th set-point change); test:M (a step test "
       "every M months); on_demand:T (a step test when the performance index "
       "of a "
       "change falls below T); perfect."},
      {"seeds", &request.seeds, "Number of seeds.", "", kSeeds},
      {"first_seed", &request.first_seed, "First of the consecutive seeds."},
      {"out", &campaign.folder,
       "Folder for report.html, result.json, lifecycle.csv, the figures and "
       "journal.txt, from which an interrupted run resumes."},
      {"part", PartOfWork(&campaign.part),
       "Part of the lives, such as 3/16: the third of 16. Its journal is in "
       "parts/3-of-16 below --out. A run without --part takes over the lives "
       "that parts have made, makes those that are left, and writes the "
       "results. Empty: all."},
      {"figures", &request.figures,
       "Draws the figures (PNG and PDF need rsvg-convert)."},
      {"threads", &request.threads,
       "Threads; 0: one for each processor. The results do not depend on the "
       "number.",
       "", kNotNegative},
  };
}

std::vector<Option> PartOptionsOf(OperationOptions& operation,
                                  Request& request) {
  control::MpcLimits& limits = operation.controller.limits;
  return {
      {"sample_time", &operation.sample_time,
       "Sample time Δt of records and models.", "min", kPositive},
      {"noise_variance", &operation.noise_variance,
       "Variance σ² of the white measurement noise of every output.", "",
       kNotNegative},
      {"disturbance_deviation",
       ForEachOutput(&operation.disturbance_deviation, "0.1"),
       "Standard deviation of a slow disturbance of the outputs: one value, or "
       "one for each output.",
       "", kNotNegative},
      {"disturbance_time", Hours(&request.disturbance_hours, "1d"),
       "Correlation time of that disturbance.", "s, min, h, d, w or y"},
      {"min_input", OptionalForEachInput(&limits.min_input),
       "Lower limits of the inputs: one value, or one for each input. Empty: "
       "minus four times the inputs that hold the outputs at any set points "
       "within --setpoint_range."},
      {"max_input", OptionalForEachInput(&limits.max_input),
       "Upper limits of the inputs, as --min_input."},
      {"min_output", OptionalForEachOutput(&limits.min_output),
       "Lower limits of the outputs (soft limits of the controller): one "
       "value, or one for each output. Empty: -1.5 times --setpoint_range."},
      {"max_output", OptionalForEachOutput(&limits.max_output),
       "Upper limits of the outputs, as --min_output."},
  };
}

std::vector<Option> SimulatedOptions(Request& request) {
  OperationOptions& operation = request.campaign.life.operation;
  return {
      {"window", &request.window,
       "Length of the record kept before and after a set-point change; 0: one "
       "and a half times the model's settling time.",
       "min", kNotNegative},
      {"quiet_stretch", &request.quiet_stretch,
       "Simulated part of a quiet time, which represents all of it; 0: three "
       "times the model's settling time.",
       "min", kNotNegative},
      {"warm_up", &request.warm_up,
       "Simulated time before the quiet stretch, which does not count; 0: the "
       "model's settling time.",
       "min", kNotNegative},
      {"every_sample", &operation.every_sample,
       "Simulates every sample of all years, with an ageing plant, instead of "
       "a stretch of each quiet time. Slow."},
  };
}

std::vector<Option> PartOptionsOf(LifeOptions& life, Request& request) {
  return {
      {"windows", &life.windows,
       "A correction uses the records of this many last set-point changes.", "",
       kThousand},
      {"window_age", HoursOrNever(&request.window_age_hours),
       "Maximum age of the records of a correction. Empty: no maximum.",
       "s, min, h, d, w or y"},
      {"calibrate_test", &request.calibrate_test,
       "Calibrates the test of no change by simulation where it is in doubt, "
       "as mle_correct does: several times slower. If false, hold-out "
       "validation alone guards against false alarms."},
      {"watch_limit",
       ZeroForInfinity(&life.watch_limit),
       "A new model is watched for --quiet_stretch and reverted if the "
       "measured squared error of an output exceeds this many times its value "
       "before the last change; 0: never.",
       "",
       {.min = 1.0, .open_min = true}},
      {"response_horizon", &request.response_horizon,
       "Length of the step responses compared with the plant's; 0: the "
       "model's settling time.",
       "min", kNotNegative},
  };
}

std::vector<Option> PartOptionsOf(StepTestOptions& test, Request& request) {
  return {
      {"test_hold", &request.test_hold,
       "Duration of each step of a step test; 0: the model's settling time.",
       "min", kNotNegative},
      {"test_cycles", &test.cycles,
       "Number of steps up and back of each input in a step test.", "",
       kThousand},
      {"test_move", OptionalForEachOutput(&test.move),
       "Largest expected move of an output in a step test: one value, or one "
       "for each output. Empty: --setpoint_range.",
       "", kPositive},
  };
}

}  // namespace

void AddOptions(Request& request, OptionTable& table) {
  Campaign& campaign = request.campaign;
  campaign.folder = "lifecycle";
  LifeOptions& life = campaign.life;
  CorrectOptions& correct = life.update.correct;
  table.Add("Model and plant", PlantOptions(request));
  table.Add("Lives", LifeOptionsOf(request));
  table.Add("Operation", PartOptionsOf(life.operation, request));
  table.Add("Controller", mle::OptionsOf(life.operation.controller));
  table.Add("Controller", Only(mle::OptionsOf(life.operation.controller.limits),
                               {"output_limit_cost"}));
  table.Add("Simulation", SimulatedOptions(request));
  table.Add("Corrections", PartOptionsOf(life, request));
  table.Add("Corrections", Only(mle::OptionsOf(correct.estimation),
                                {"false_alarm_probability", "robust", "order",
                                 "conversion_samples", "solver"}));
  table.Add("Corrections",
            Only(mle::OptionsOf(correct.hold_out), {"validation_folds"}));
  table.Add("Corrections", mle::OptionsOf(correct.decision));
  table.Add("Step tests", PartOptionsOf(life.test, request));
  table.Add("Prices", mle::OptionsOf(request.prices));
  table.Add("Prices",
            {{"currency", CurrencyOf(request),
              "Name of the money that prices are in, shown with every amount: "
              "EUR. Empty: none. No life is simulated anew for it."}});
  table.PutFirst({"model", "ageing", "years", "change_every", "policies",
                  "seeds", "out", "price_squared_error"});
}

absl::StatusOr<double> ParseHours(const std::string& text) {
  constexpr std::pair<const char*, double> kUnits[] = {
      {"s", 1.0 / 3600.0}, {"min", 1.0 / 60.0}, {"h", 1.0},
      {"d", 24.0},         {"w", 168.0},        {"y", kHoursPerYear}};
  const std::size_t end = text.find_first_not_of("0123456789.eE+-");
  double number = 0.0;
  if (end != std::string::npos &&
      absl::SimpleAtod(text.substr(0, end), &number) && std::isfinite(number) &&
      number > 0.0) {
    for (const auto& [name, hours] : kUnits) {
      if (text.substr(end) == name) return number * hours;
    }
  }
  return InvalidArgument("'", text,
                         "' is not a duration; a number > 0 with one of the "
                         "units s, min, h, d, w, y is needed, as in 30d");
}

TextValue Hours(double* hours, std::string text) {
  return {.text = std::move(text),
          .read = [hours](const std::string& given, const NumberRange&) {
            MLE_ASSIGN_OR_RETURN(*hours, ParseHours(given));
            return absl::OkStatus();
          }};
}

}  // namespace mle::lifecycle
