#include "apps/lifecycle/request.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "apps/common/model_files.h"
#include "apps/common/shared_options.h"
#include "apps/experiment/campaign.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/data/civil_time.h"
#include "sim/ageing_json.h"

namespace mle::lifecycle {
namespace {

using Eigen::VectorXd;

// How far beyond what is needed inputs and outputs may go.
constexpr double kInputMargin = 4.0;
constexpr double kOutputMargin = 1.5;

// The options, beside prices, that do not change a life.
const std::set<std::string> kNotOfALife = {
    "model",          "plant",   "ageing",     "ageing_rates",
    "policies",       "seeds",   "first_seed", "out",
    "part",           "figures", "threads",    "hours_per_update",
    "hours_per_test", "currency"};

absl::Status WrongOption(const char* option, const std::string& message) {
  return AboutOption(option, absl::InvalidArgumentError(message));
}

// `given`, or `by_default` where that is 0.
double Or(double given, double by_default) {
  return given > 0.0 ? given : by_default;
}

absl::Status CheckModel(const ProcessModel& model, const std::string& path) {
  MLE_RETURN_IF_ERROR(CheckMoves(model, path, "nothing that can age"));
  return AboutOption(
      "model", CheckNotIntegrating(
                   model, "life cycles are those of elements that settle"));
}

// Reads the files that the paths name into `given`.
absl::Status ReadFiles(const Request& request, GivenModels& given) {
  if (request.model_path.empty() || request.ageing_path.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json and --ageing=FILE.json must be given (see --help)");
  }
  MLE_ASSIGN_OR_RETURN(given.model, ReadModel("model", request.model_path));
  if (!request.plant_path.empty()) {
    MLE_ASSIGN_OR_RETURN(given.plant,
                         ReadModelLike(given.model, request.model_path, "plant",
                                       request.plant_path));
  }
  MLE_ASSIGN_OR_RETURN(given.ageing,
                       AboutOption("ageing", ReadFile(request.ageing_path)));
  return absl::OkStatus();
}

absl::Status TakeModels(const GivenModels& given, const Request& request,
                        Campaign& campaign) {
  const bool in_memory = request.given.has_value();
  campaign.model = given.model;
  MLE_RETURN_IF_ERROR(
      CheckModel(campaign.model, in_memory ? "the model" : request.model_path));
  campaign.plant = given.plant.value_or(given.model);
  MLE_RETURN_IF_ERROR(
      CheckSameChannels(campaign.model, "model", campaign.plant, "plant"));
  if (HasTransforms(campaign.model) || HasTransforms(campaign.plant)) {
    return absl::InvalidArgumentError(
        "model or plant has transforms; lives have linear ones (mle_convert "
        "--at makes them)");
  }
  absl::StatusOr<sim::AgeingSchedule> ageing = sim::ParseAgeingSchedule(
      given.ageing, in_memory ? "ageing" : request.ageing_path, campaign.plant);
  if (!in_memory) ageing = AboutOption("ageing", std::move(ageing));
  MLE_ASSIGN_OR_RETURN(campaign.ageing, std::move(ageing));
  return absl::OkStatus();
}

absl::Status SetRates(const Request& request, Campaign& campaign) {
  if (request.rates.empty()) {
    return WrongOption("ageing_rates", "names no rate");
  }
  for (const double rate : request.rates) {
    if (std::count(campaign.rates.begin(), campaign.rates.end(), rate) > 0) {
      return WrongOption("ageing_rates",
                         absl::StrCat("'", rate, "' is duplicated"));
    }
    absl::StatusOr<sim::AgeingSchedule> scaled =
        sim::ScaleAgeing(campaign.ageing, rate);
    absl::Status status = scaled.status();
    if (status.ok()) status = scaled->Validate(campaign.plant);
    if (!status.ok()) {
      return WrongOption("ageing_rates",
                         absl::StrCat("at ", rate, ": ", status.message()));
    }
    campaign.rates.push_back(rate);
  }
  return absl::OkStatus();
}

absl::Status SetSetPoints(const Request& request, Campaign& campaign) {
  SetPointOptions& set_points = campaign.set_points;
  set_points.duration = request.years * kHoursPerYear / request.hours_per_unit;
  set_points.change_every = request.change_every_hours / request.hours_per_unit;
  set_points.grid = campaign.life.operation.controller.control_period;
  return AboutOption("change_every", set_points.Validate());
}

// The largest input that holds the outputs anywhere within ± range: for each
// manipulated input the sum over the outputs of |K⁺| range.
VectorXd NeededInputs(const ProcessModel& model, const VectorXd& range) {
  Eigen::MatrixXd gains = StaticGains(model);
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].role != InputRole::kManipulated) {
      gains.col(j).setZero();
    }
  }
  const Eigen::MatrixXd inverse =
      gains.completeOrthogonalDecomposition().pseudoInverse();
  return inverse.cwiseAbs() * range;
}

// Limits that are not given follow from the set points' range: inputs may go
// to four times what holds the outputs at any corner of it, outputs to one and
// a half times it.
absl::Status SetLimits(const Campaign& campaign, OperationOptions& operation) {
  const ProcessModel& model = campaign.model;
  const VectorXd& range = campaign.set_points.range;
  control::MpcLimits& limits = operation.controller.limits;
  const auto by_default = [](VectorXd& limit, const VectorXd& value) {
    if (limit.size() == 0) limit = value;
  };
  const VectorXd inputs = kInputMargin * NeededInputs(model, range);
  if (!inputs.allFinite()) {
    return WrongOption("model",
                       "the inputs that hold the outputs within "
                       "--setpoint_range are not finite: its gains are too "
                       "small, or too far from each other");
  }
  by_default(limits.min_input, -inputs);
  by_default(limits.max_input, inputs);
  by_default(limits.min_output, -kOutputMargin * range);
  by_default(limits.max_output, kOutputMargin * range);
  operation.limits = {limits.min_output, limits.max_output};
  return CheckController(operation.controller, model);
}

absl::Status SetOperation(const Request& request, Campaign& campaign) {
  OperationOptions& operation = campaign.life.operation;
  const double settling = SettlingTime(campaign.model);
  operation.disturbance_time =
      request.disturbance_hours / request.hours_per_unit;
  operation.before = Or(request.window, 1.5 * settling);
  operation.after = operation.before;
  operation.quiet_stretch = Or(request.quiet_stretch, 3.0 * settling);
  operation.warm_up = Or(request.warm_up, settling);
  MLE_RETURN_IF_ERROR(SetLimits(campaign, operation));
  const absl::Status status = operation.Validate(campaign.model);
  if (status.ok()) return status;
  // Fields are named as their options.
  return InvalidArgument("--", status.message());
}

double RoundUp(double value, double unit) {
  return std::ceil(value / unit - 1e-9) * unit;
}

// Checks the lengths of all that is kept in memory: what is simulated in one
// piece, and each step response.
absl::Status CheckLengths(const Request& request, const Campaign& campaign) {
  const OperationOptions& operation = campaign.life.operation;
  const double settling = SettlingTime(campaign.model);
  for (const auto& [name, length] :
       {std::pair{"control_period", operation.controller.control_period},
        std::pair{"window", operation.after},
        std::pair{"quiet_stretch", operation.quiet_stretch},
        std::pair{"warm_up", operation.warm_up},
        std::pair{"test_hold", Or(request.test_hold, settling)},
        std::pair{"response_horizon", Or(request.response_horizon, settling)},
        std::pair{"change_every", operation.every_sample
                                      ? campaign.set_points.change_every
                                      : 0.0}}) {
    MLE_RETURN_IF_ERROR(CheckSamples(name, length, operation.sample_time));
  }
  return absl::OkStatus();
}

void SetLife(const Request& request, Campaign& campaign) {
  LifeOptions& life = campaign.life;
  const double settling = SettlingTime(campaign.model);
  const double period = life.operation.controller.control_period;
  life.month = kHoursPerYear / 12.0 / request.hours_per_unit;
  life.window_age = request.window_age_hours / request.hours_per_unit;
  life.test.hold = RoundUp(Or(request.test_hold, settling), period);
  if (life.test.move.size() == 0) life.test.move = campaign.set_points.range;
  UpdateOptions& update = life.update;
  if (!request.calibrate_test) {
    update.correct.estimation.change_test = ChangeTest::kChiSquare;
  }
  update.control_period = period;
  update.response_samples =
      1 + static_cast<int>(std::ceil(Or(request.response_horizon, settling) /
                                         life.operation.sample_time -
                                     1e-9));
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
  return WrongOption(
      "change_every",
      absl::StrCat("changes follow each other after ", shortest, " ",
                   campaign.model.time_unit(),
                   " at the least, but what is simulated of one "
                   "(--quiet_stretch, --warm_up, --window, --quiet_stretch "
                   "again with a new model, a step test of ",
                   test, ") takes ", needed));
}

void AddSettings(const GivenModels& given, const OptionTable& table,
                 Campaign& campaign) {
  for (const auto& [name, value] : table.Values()) {
    if (kNotOfALife.count(name) > 0 || name.rfind("price_", 0) == 0) continue;
    campaign.settings[name] = value;
  }
  campaign.settings["file of ageing"] = given.ageing;
  campaign.settings["file of model"] = FormatProcessModel(campaign.model);
  campaign.settings["file of plant"] = FormatProcessModel(campaign.plant);
  campaign.settings["program_version"] = std::string(LibraryVersion());
}

}  // namespace

absl::Status Complete(Request& request, OptionTable& table) {
  Campaign& campaign = request.campaign;
  GivenModels given = request.given.value_or(GivenModels());
  if (!request.given.has_value()) {
    MLE_RETURN_IF_ERROR(ReadFiles(request, given));
  }
  MLE_RETURN_IF_ERROR(TakeModels(given, request, campaign));
  const std::string& unit = campaign.model.time_unit();
  const std::optional<double> seconds = SecondsPerUnit(unit);
  if (!seconds.has_value()) {
    return AboutOption(
        "model", InvalidArgument("the time unit '", unit,
                                 "' is not known; choose from s, min, h, d"));
  }
  request.hours_per_unit = *seconds / 3600.0;
  MLE_RETURN_IF_ERROR(table.FitTo(campaign.model));
  MLE_RETURN_IF_ERROR(SetRates(request, campaign));
  MLE_ASSIGN_OR_RETURN(campaign.seeds, experiment::ConsecutiveSeeds(
                                           request.first_seed, request.seeds));
  MLE_RETURN_IF_ERROR(experiment::CheckControlPeriod(
      campaign.life.operation.controller.control_period,
      campaign.life.operation.sample_time));
  MLE_RETURN_IF_ERROR(SetSetPoints(request, campaign));
  MLE_RETURN_IF_ERROR(SetOperation(request, campaign));
  MLE_RETURN_IF_ERROR(CheckLengths(request, campaign));
  SetLife(request, campaign);
  MLE_RETURN_IF_ERROR(CheckGaps(campaign));
  campaign.threads = request.threads;
  AddSettings(given, table, campaign);
  return absl::OkStatus();
}

}  // namespace mle::lifecycle
