#include "apps/reproduce/case_flags.h"

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/common/built_in_models.h"
#include "apps/common/command_line.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"

DEFINE_string(cases, "gain,delay",
              "Cases to run, of the Wood-Berry column: gain (both reflux gains "
              "halved), delay (both steam dead times 4 min longer).");
DEFINE_string(model, "",
              "Process model (JSON) of the controller; with --plants instead "
              "of --cases.");
DEFINE_string(plants, "",
              "NAME:FILE,… process models (JSON) of aged plants, one for each "
              "case, with the inputs and outputs of --model.");

namespace mle::reproduce {
namespace {

using experiment::Mismatch;

// A failure of what a flag asks for, as bad input.
absl::Status Of(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, ": ", status.message()));
}

// Names go into names of files.
absl::Status CheckName(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 100 &&
                     name.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_-") == std::string::npos;
  if (plain) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "--plants: the name '", name,
      "' must be made of letters, digits, '_' and '-', at most 100"));
}

absl::StatusOr<std::vector<Mismatch>> ReadPlants(const ProcessModel& initial) {
  std::vector<Mismatch> cases;
  for (const std::string& part : ParseList(FLAGS_plants)) {
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) {
      return absl::InvalidArgumentError(
          absl::StrCat("--plants: '", part, "' is not of the form NAME:FILE"));
    }
    const std::string name = part.substr(0, colon);
    const std::string file = part.substr(colon + 1);
    MLE_RETURN_IF_ERROR(CheckName(name));
    absl::StatusOr<ProcessModel> plant = ReadProcessModel(file);
    if (!plant.ok()) return Of("plants", plant.status());
    if (const absl::Status same =
            CheckSameChannels(initial, FLAGS_model, *plant, file);
        !same.ok()) {
      return Of("plants", same);
    }
    Mismatch& one = cases.emplace_back();
    one.name = name;
    one.plant = *std::move(plant);
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--plants names no plant");
  }
  return cases;
}

absl::StatusOr<std::vector<Mismatch>> BuiltInCases() {
  std::vector<Mismatch> cases;
  for (const std::string& name : ParseList(FLAGS_cases)) {
    const BuiltInModel* found = nullptr;
    for (const BuiltInModel& model : kWoodBerryAged) {
      if (model.name == name) found = &model;
    }
    if (found == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--cases: there is no case '", name,
          "'; known are gain and delay, others run with --model and --plants"));
    }
    MLE_ASSIGN_OR_RETURN(ProcessModel plant,
                         ParseProcessModel(found->json, found->source));
    Mismatch& one = cases.emplace_back();
    one.name = name;
    one.plant = std::move(plant);
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--cases names no case");
  }
  return cases;
}

}  // namespace

absl::Status ReadCases(Reproduction& reproduction) {
  experiment::Campaign& campaign = reproduction.campaign;
  campaign.models.resize(1);
  campaign.models.front().name = "initial";
  ProcessModel& initial = campaign.models.front().model;
  const bool own = !FLAGS_model.empty() || !FLAGS_plants.empty();
  if (own && (FLAGS_model.empty() || FLAGS_plants.empty())) {
    return absl::InvalidArgumentError(
        "--model and --plants must be given together: the controller's model, "
        "and the plants");
  }
  if (own && !gflags::GetCommandLineFlagInfoOrDie("cases").is_default) {
    return absl::InvalidArgumentError(
        "--cases stands for plants of the Wood-Berry column; give either "
        "--cases or --model with --plants");
  }
  if (own) {
    absl::StatusOr<ProcessModel> model = ReadProcessModel(FLAGS_model);
    if (!model.ok()) return Of("model", model.status());
    initial = *std::move(model);
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, ReadPlants(initial));
  } else {
    MLE_ASSIGN_OR_RETURN(initial,
                         ParseProcessModel(kWoodBerry.json, kWoodBerry.source));
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, BuiltInCases());
    reproduction.from_paper = true;
  }
  std::set<std::string> names;
  for (const Mismatch& one : campaign.mismatches) {
    if (!names.insert(one.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat(own ? "--plants" : "--cases", ": '", one.name,
                       "' is named twice; every case needs its own name"));
    }
  }
  return absl::OkStatus();
}

}  // namespace mle::reproduce
