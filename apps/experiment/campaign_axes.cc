#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/option_json.h"
#include "apps/common/shared_options.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/campaign_json.h"
#include "mle/base/status.h"
#include "sim/effects_json.h"

namespace mle::experiment {
namespace {

constexpr std::int64_t kMaxSeeds = 1'000'000;
// The largest whole number that every JSON reader keeps exactly.
constexpr std::int64_t kMaxSeed = 9'007'199'254'740'991;

// A process model that ResolveCampaign() read in.
absl::StatusOr<ProcessModel> ParseModel(const JsonNode& node) {
  return node.Check(ParseProcessModel(node.json().dump(), "process model"));
}

absl::StatusOr<Change> ParseChange(const JsonNode& node) {
  Change change;
  MLE_RETURN_IF_ERROR(ReadOptionsOnly(node, {}, OptionsOf(change)));
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
              ? InvalidArgument(
                    "is a plant of its own, but the plants of the model '",
                    spec.name, "' are drawn: give changes instead")
              : CheckSameChannels(spec.model,
                                  absl::StrCat("model '", spec.name, "'"),
                                  *mismatch.plant, "the plant");
      MLE_RETURN_IF_ERROR(node.Check(same));
    } else if (!spec.random.has_value()) {
      const absl::Status possible = CheckAgeing(spec.model, mismatch);
      if (!possible.ok()) {
        return node.Fault("model '", spec.name,
                          "': ", std::string(possible.message()));
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

}  // namespace

absl::Status CheckNewName(const JsonNode& node, const std::string& name,
                          std::set<std::string>& names) {
  if (names.insert(name).second) return absl::OkStatus();
  return node.Fault("the name '", name,
                    "' is duplicated; every entry needs its own");
}

absl::StatusOr<std::vector<double>> ParseNumberList(const JsonNode& node,
                                                    const NumberRange& range) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::vector<double> numbers;
  std::set<double> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const double number, element.Number(range));
    if (!seen.insert(number).second) {
      return element.Fault(absl::StrFormat("%g is duplicated", number));
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
    return node.Fault(
        "must be a list of seeds or {\"first\": …, \"count\": …}, is ",
        node.Found());
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements, node.Elements());
  std::set<std::int64_t> seen;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const std::int64_t seed, element.Integer(0, kMaxSeed));
    if (!seen.insert(seed).second) {
      return element.Fault("the seed ", seed, " is duplicated");
    }
    seeds.push_back(static_cast<std::uint64_t>(seed));
  }
  return seeds;
}

absl::Status ParseModelSpec(const JsonNode& node, ModelSpec& spec) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"file", "model", "random"}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (node.Has("model") == node.Has("random")) {
    return node.Fault(
        "needs one of file (or the model itself, as model) and random");
  }
  if (node.Has("random")) {
    return ReadOptionsOnly(node.At("random"), {},
                           OptionsOf(spec.random.emplace()));
  }
  MLE_ASSIGN_OR_RETURN(spec.model, ParseModel(node.At("model")));
  return node.Check(CheckNotIntegrating(
      spec.model, "campaigns are those of elements that settle"));
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

absl::StatusOr<std::vector<sim::Effects>> ParseEffectsOf(
    const JsonNode& node, const std::vector<ModelSpec>& models) {
  std::vector<sim::Effects> effects;
  for (const ModelSpec& model : models) {
    MLE_ASSIGN_OR_RETURN(effects.emplace_back(),
                         sim::ParseEffects(node, model.random.has_value()
                                                     ? ChannelsOf(*model.random)
                                                     : model.model));
  }
  return effects;
}

absl::Status ParseEffectsSpec(const JsonNode& node,
                              const std::vector<ModelSpec>& models,
                              EffectsSpec& spec) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name"}, {"file", "effects"}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (!node.Has("effects")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(spec.of_models,
                       ParseEffectsOf(node.At("effects"), models));
  return absl::OkStatus();
}

absl::Status ParseController(const JsonNode& node, ControllerSpec& spec) {
  MLE_RETURN_IF_ERROR(
      ReadOptionsOnly(node, {"name"}, mle::OptionsOf(spec.mpc)));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  return absl::OkStatus();
}

absl::Status ParseWindow(const JsonNode& node, WindowSpec& spec) {
  MLE_RETURN_IF_ERROR(ReadOptionsOnly(node, {"name"}, OptionsOf(spec)));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  if (spec.longest_outlier > 1 &&
      spec.longest_outlier < WindowSpec::kShortestBurst) {
    return node.At("longest_outlier")
        .Fault("must be 1, or at least ", WindowSpec::kShortestBurst,
               " for bursts");
  }
  if (spec.changes == 0) {
    if (!node.Has("spacing")) return absl::OkStatus();
    return node.At("spacing").Fault("needs changes, their number");
  }
  for (const char* key : {"duration", "step_time"}) {
    if (!node.Has(key)) continue;
    return node.At(key).Fault(
        "has no place beside changes, which come at window, window + spacing, "
        "…");
  }
  const double least = 2.0 * spec.window;
  if (!node.Has("spacing")) spec.spacing = least;
  return spec.spacing >= least
             ? absl::OkStatus()
             : node.At("spacing").Number(AtLeast(least)).status();
}

}  // namespace mle::experiment
