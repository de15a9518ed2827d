#include "apps/study/campaign_scenarios.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/experiment/plants.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::Change;
using experiment::CheckAgeing;
using experiment::ControllerSpec;
using experiment::Interval;
using experiment::Mismatch;
using experiment::ModelSpec;
using experiment::RandomPlants;
using experiment::WindowSpec;

constexpr std::int64_t kMaxSeeds = 1'000'000;
// The largest whole number that every JSON reader keeps exactly.
constexpr std::int64_t kMaxSeed = 9'007'199'254'740'991;
constexpr int kMaxChannels = 50;
constexpr int kMaxChanges = 1000;

absl::Status ReadInterval(const JsonNode& object, const std::string& key,
                          const NumberRange& range, bool one_number,
                          Interval& interval) {
  if (!object.Has(key)) return absl::OkStatus();
  const JsonNode node = object.At(key);
  if (one_number && node.json().is_number()) {
    MLE_ASSIGN_OR_RETURN(interval.from, node.Number(range));
    interval.to = interval.from;
    return absl::OkStatus();
  }
  if (!node.json().is_array() || node.json().size() != 2) {
    return node.Fault(
        absl::StrCat("must be ", one_number ? "a number or " : "",
                     "a list of two numbers, the smallest and the largest, is ",
                     node.Found()));
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> ends, node.Elements());
  MLE_ASSIGN_OR_RETURN(interval.from, ends[0].Number(range));
  MLE_ASSIGN_OR_RETURN(interval.to, ends[1].Number(range));
  if (interval.from > interval.to) {
    return node.Fault(
        absl::StrFormat("the smallest value comes first, but %g is above %g",
                        interval.from, interval.to));
  }
  return absl::OkStatus();
}

absl::StatusOr<RandomPlants> ParseRandomPlants(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({}, {"outputs", "inputs", "gain", "time_constant", "delay",
                          "max_condition_number", "max_sensitivity"}));
  RandomPlants plants;
  MLE_RETURN_IF_ERROR(
      ReadInteger(node, "outputs", 1, kMaxChannels, plants.outputs));
  MLE_RETURN_IF_ERROR(
      ReadInteger(node, "inputs", 1, kMaxChannels, plants.inputs));
  MLE_RETURN_IF_ERROR(
      ReadInterval(node, "gain", kPositive, false, plants.gain));
  MLE_RETURN_IF_ERROR(ReadInterval(node, "time_constant", kPositive, false,
                                   plants.time_constant));
  MLE_RETURN_IF_ERROR(
      ReadInterval(node, "delay", kNotNegative, false, plants.delay));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "max_condition_number", {.min = 1.0},
                                 plants.max_condition_number));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "max_sensitivity",
                                 {.min = 1.0, .open_min = true},
                                 plants.max_sensitivity));
  return plants;
}

// A process model that ResolveCampaign() read in.
absl::StatusOr<ProcessModel> ParseModel(const JsonNode& node) {
  absl::StatusOr<ProcessModel> model =
      ParseProcessModel(node.json().dump(), "process model");
  if (model.ok()) return model;
  return node.Fault(std::string(model.status().message()));
}

absl::StatusOr<Change> ParseChange(const JsonNode& node) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({}, {"output", "input", "elements", "gain_factor",
                          "time_constant_factor", "delay_shift"}));
  Change change;
  if (node.Has("output")) {
    MLE_ASSIGN_OR_RETURN(change.output, node.At("output").Text());
  }
  if (node.Has("input")) {
    MLE_ASSIGN_OR_RETURN(change.input, node.At("input").Text());
  }
  MLE_RETURN_IF_ERROR(ReadInteger(
      node, "elements", 1, kMaxChannels * kMaxChannels, change.elements));
  MLE_RETURN_IF_ERROR(
      ReadInterval(node, "gain_factor", kPositive, true, change.gain_factor));
  MLE_RETURN_IF_ERROR(ReadInterval(node, "time_constant_factor", kPositive,
                                   true, change.time_constant_factor));
  MLE_RETURN_IF_ERROR(
      ReadInterval(node, "delay_shift", kAnyNumber, true, change.delay_shift));
  if (!node.Has("gain_factor") && !node.Has("time_constant_factor") &&
      !node.Has("delay_shift")) {
    return node.Fault(
        "changes nothing: give gain_factor, time_constant_factor or "
        "delay_shift");
  }
  return change;
}

// That a plant file has the channels of every model, or that the changes of
// every model are possible.
absl::Status CheckMismatch(const JsonNode& node, const Mismatch& mismatch,
                           const std::vector<ModelSpec>& models) {
  for (const ModelSpec& spec : models) {
    if (mismatch.plant.has_value()) {
      const absl::Status same =
          spec.random.has_value()
              ? absl::InvalidArgumentError(absl::StrCat(
                    "is a plant of its own, but the plants of the model '",
                    spec.name, "' are drawn: give changes instead"))
              : CheckSameChannels(spec.model,
                                  absl::StrCat("model '", spec.name, "'"),
                                  *mismatch.plant, "the plant");
      if (!same.ok()) return node.Fault(std::string(same.message()));
    } else if (!spec.random.has_value()) {
      const absl::Status possible = CheckAgeing(spec.model, mismatch);
      if (!possible.ok()) {
        return node.Fault(absl::StrCat("model '", spec.name,
                                       "': ", std::string(possible.message())));
      }
    }
  }
  return absl::OkStatus();
}

// A mismatch for each of its sizes.
absl::StatusOr<std::vector<Mismatch>> ParseMismatch(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"plant", "changes", "sizes"}));
  Mismatch mismatch;
  MLE_ASSIGN_OR_RETURN(mismatch.name, node.At("name").Name());
  if (node.Has("plant") && node.Has("changes")) {
    return node.Fault("has a plant and changes; only one of them is possible");
  }
  if (node.Has("plant")) {
    MLE_ASSIGN_OR_RETURN(mismatch.plant, ParseModel(node.At("plant")));
  }
  if (node.Has("changes")) {
    MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> changes,
                         node.At("changes").Elements());
    for (const JsonNode& change : changes) {
      MLE_ASSIGN_OR_RETURN(Change parsed, ParseChange(change));
      mismatch.changes.push_back(std::move(parsed));
    }
  }
  std::vector<double> sizes = {1.0};
  if (node.Has("sizes")) {
    if (mismatch.changes.empty()) {
      return node.At("sizes").Fault("only changes have sizes");
    }
    MLE_ASSIGN_OR_RETURN(sizes, ParseNumberList(node.At("sizes"), kAnyNumber));
  }
  std::vector<Mismatch> mismatches;
  for (const double size : sizes) {
    mismatch.size = size;
    MLE_RETURN_IF_ERROR(CheckMismatch(node, mismatch, models));
    mismatches.push_back(mismatch);
  }
  return mismatches;
}

// Diagonal; of 1 × 1 for one number, that of every channel.
absl::Status ReadWeight(const JsonNode& object, const std::string& key,
                        Eigen::MatrixXd& weight) {
  if (!object.Has(key)) return absl::OkStatus();
  const JsonNode node = object.At(key);
  if (node.json().is_number()) {
    MLE_ASSIGN_OR_RETURN(const double every, node.Number(kNotNegative));
    weight = Eigen::MatrixXd::Constant(1, 1, every);
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  Eigen::VectorXd weights(static_cast<Eigen::Index>(elements.size()));
  for (std::size_t i = 0; i < elements.size(); ++i) {
    MLE_ASSIGN_OR_RETURN(weights(static_cast<Eigen::Index>(i)),
                         elements[i].Number(kNotNegative));
  }
  weight = weights.asDiagonal();
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckNewName(const JsonNode& node, const std::string& name,
                          std::set<std::string>& names) {
  if (names.insert(name).second) return absl::OkStatus();
  return node.Fault(absl::StrCat("the name '", name,
                                 "' stands twice; every entry needs its own"));
}

absl::StatusOr<std::vector<double>> ParseNumberList(const JsonNode& node,
                                                    const NumberRange& range) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<double> numbers;
  std::set<double> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const double number, element.Number(range));
    if (!seen.insert(number).second) {
      return element.Fault(absl::StrFormat("%g stands twice", number));
    }
    numbers.push_back(number);
  }
  return numbers;
}

absl::StatusOr<std::vector<std::uint64_t>> ParseSeeds(const JsonNode& node) {
  std::vector<std::uint64_t> seeds;
  if (node.json().is_object()) {
    MLE_RETURN_IF_ERROR(node.CheckKeys({"first", "count"}, {}));
    MLE_ASSIGN_OR_RETURN(const std::int64_t count,
                         node.At("count").Integer(1, kMaxSeeds));
    MLE_ASSIGN_OR_RETURN(const std::int64_t first,
                         node.At("first").Integer(0, kMaxSeed - count));
    for (std::int64_t i = 0; i < count; ++i) {
      seeds.push_back(static_cast<std::uint64_t>(first + i));
    }
    return seeds;
  }
  if (!node.json().is_array()) {
    return node.Fault(absl::StrCat(
        "must be a list of seeds or {\"first\": …, \"count\": …}, is ",
        node.Found()));
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::set<std::int64_t> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const std::int64_t seed, element.Integer(0, kMaxSeed));
    if (!seen.insert(seed).second) {
      return element.Fault(absl::StrCat("the seed ", seed, " stands twice"));
    }
    seeds.push_back(static_cast<std::uint64_t>(seed));
  }
  return seeds;
}

absl::StatusOr<std::vector<ModelSpec>> ParseModels(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<ModelSpec> models;
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_RETURN_IF_ERROR(
        element.CheckKeys({"name"}, {"file", "model", "random"}));
    ModelSpec spec;
    MLE_ASSIGN_OR_RETURN(spec.name, element.At("name").Name());
    MLE_RETURN_IF_ERROR(CheckNewName(element, spec.name, names));
    if (element.Has("model") == element.Has("random")) {
      return element.Fault(
          "needs one of file (or the model itself, as model) and random");
    }
    if (element.Has("model")) {
      MLE_ASSIGN_OR_RETURN(spec.model, ParseModel(element.At("model")));
    } else {
      MLE_ASSIGN_OR_RETURN(spec.random,
                           ParseRandomPlants(element.At("random")));
    }
    models.push_back(std::move(spec));
  }
  return models;
}

absl::StatusOr<std::vector<Mismatch>> ParseMismatches(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<Mismatch> mismatches;
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(std::vector<Mismatch> sizes,
                         ParseMismatch(element, models));
    MLE_RETURN_IF_ERROR(CheckNewName(element, sizes.front().name, names));
    for (Mismatch& mismatch : sizes) mismatches.push_back(std::move(mismatch));
  }
  return mismatches;
}

absl::StatusOr<std::vector<ControllerSpec>> ParseControllers(
    const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<ControllerSpec> controllers;
  std::set<std::string> names;
  constexpr int kMaxHorizon = 100'000;
  for (const JsonNode& element : elements) {
    MLE_RETURN_IF_ERROR(element.CheckKeys(
        {"name"},
        {"control_period", "prediction_horizon", "control_horizon",
         "output_weight", "move_weight", "disturbance_variance_ratio"}));
    ControllerSpec spec;
    MLE_ASSIGN_OR_RETURN(spec.name, element.At("name").Name());
    MLE_RETURN_IF_ERROR(CheckNewName(element, spec.name, names));
    MLE_RETURN_IF_ERROR(ReadNumber(element, "control_period", kPositive,
                                   spec.mpc.control_period));
    MLE_RETURN_IF_ERROR(ReadInteger(element, "prediction_horizon", 1,
                                    kMaxHorizon, spec.mpc.prediction_horizon));
    MLE_RETURN_IF_ERROR(ReadInteger(element, "control_horizon", 1, kMaxHorizon,
                                    spec.mpc.control_horizon));
    MLE_RETURN_IF_ERROR(ReadNumber(element, "disturbance_variance_ratio",
                                   kNotNegative,
                                   spec.mpc.disturbance_variance_ratio));
    MLE_RETURN_IF_ERROR(
        ReadWeight(element, "output_weight", spec.mpc.output_weight));
    MLE_RETURN_IF_ERROR(
        ReadWeight(element, "move_weight", spec.mpc.move_weight));
    controllers.push_back(std::move(spec));
  }
  return controllers;
}

absl::Status ReadOutliers(const JsonNode& node, WindowSpec& spec) {
  MLE_RETURN_IF_ERROR(ReadNumber(node, "outlier_share",
                                 {.min = 0.0, .max = 0.5}, spec.outlier_share));
  MLE_RETURN_IF_ERROR(
      ReadInteger(node, "longest_outlier", 1, 100, spec.longest_outlier));
  if (spec.longest_outlier > 1 &&
      spec.longest_outlier < WindowSpec::kShortestBurst) {
    return node.At("longest_outlier")
        .Fault(absl::StrCat("must be 1, or at least ",
                            WindowSpec::kShortestBurst, " for bursts"));
  }
  if (!node.Has("robust")) return absl::OkStatus();
  using Treatment = experiment::OutlierTreatment;
  constexpr std::pair<const char*, Treatment> kKnown[] = {
      {"none", Treatment::kNone},
      {"model", Treatment::kModel},
      {"huber", Treatment::kHuber},
      {"cauchy", Treatment::kCauchy}};
  MLE_ASSIGN_OR_RETURN(const std::string name, node.At("robust").Text());
  for (const auto& [known, treatment] : kKnown) {
    if (name != known) continue;
    spec.robust = treatment;
    return absl::OkStatus();
  }
  return node.At("robust").Fault(
      absl::StrCat("is ", node.At("robust").Found(),
                   "; known are none, model, huber and cauchy"));
}

absl::StatusOr<std::vector<WindowSpec>> ParseWindows(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<WindowSpec> windows;
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_RETURN_IF_ERROR(element.CheckKeys(
        {"name"},
        {"duration", "step_time", "setpoint_step", "window", "changes",
         "spacing", "outlier_share", "longest_outlier", "robust"}));
    WindowSpec spec;
    MLE_ASSIGN_OR_RETURN(spec.name, element.At("name").Name());
    MLE_RETURN_IF_ERROR(CheckNewName(element, spec.name, names));
    MLE_RETURN_IF_ERROR(
        ReadNumber(element, "duration", kPositive, spec.duration));
    MLE_RETURN_IF_ERROR(
        ReadNumber(element, "step_time", kNotNegative, spec.step_time));
    MLE_RETURN_IF_ERROR(
        ReadNumber(element, "setpoint_step", kAnyNumber, spec.setpoint_step));
    MLE_RETURN_IF_ERROR(ReadNumber(element, "window", kPositive, spec.window));
    MLE_RETURN_IF_ERROR(
        ReadInteger(element, "changes", 1, kMaxChanges, spec.changes));
    spec.spacing = 2.0 * spec.window;
    MLE_RETURN_IF_ERROR(ReadNumber(element, "spacing",
                                   {.min = 2.0 * spec.window}, spec.spacing));
    MLE_RETURN_IF_ERROR(ReadOutliers(element, spec));
    const bool sequence = spec.changes > 0;
    for (const char* key : {"duration", "step_time"}) {
      if (sequence && element.Has(key)) {
        return element.At(key).Fault(
            "has no place beside changes, which come at window, window + "
            "spacing, …");
      }
    }
    if (!sequence && element.Has("spacing")) {
      return element.At("spacing").Fault("needs changes, their number");
    }
    windows.push_back(std::move(spec));
  }
  return windows;
}

}  // namespace mle::study
