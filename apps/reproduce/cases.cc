#include "apps/reproduce/cases.h"

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/common/built_in_models.h"
#include "apps/common/did_you_mean.h"
#include "apps/common/model_files.h"
#include "mle/base/status.h"

namespace mle::reproduce {
namespace {

using experiment::Mismatch;

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

absl::StatusOr<std::vector<Mismatch>> ReadPlants(const Request& request,
                                                 const ProcessModel& initial) {
  std::vector<Mismatch> cases;
  for (const std::string& part : ParseList(request.plants)) {
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) {
      return absl::InvalidArgumentError(
          absl::StrCat("--plants: '", part, "' is not of the form NAME:FILE"));
    }
    Mismatch& one = cases.emplace_back();
    one.name = part.substr(0, colon);
    MLE_RETURN_IF_ERROR(CheckName(one.name));
    MLE_ASSIGN_OR_RETURN(one.plant,
                         ReadModelLike(initial, request.model_path, "plants",
                                       part.substr(colon + 1)));
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--plants names no plant");
  }
  return cases;
}

absl::StatusOr<std::vector<Mismatch>> BuiltInCases(const Request& request) {
  std::vector<Mismatch> cases;
  for (const std::string& name : ParseList(request.cases)) {
    const BuiltInModel* found = nullptr;
    for (const BuiltInModel& model : kWoodBerryAged) {
      if (model.name == name) found = &model;
    }
    if (found == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--cases: there is no case '", name, "'; ",
          DidYouMean(name, {"gain", "delay"}),
          "known are gain and delay, others run with --model and --plants"));
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

absl::Status ReadCases(Request& request) {
  Reproduction& reproduction = request.reproduction;
  experiment::Campaign& campaign = reproduction.campaign;
  campaign.models.resize(1);
  campaign.models.front().name = "initial";
  ProcessModel& initial = campaign.models.front().model;
  const bool own = !request.model_path.empty() || !request.plants.empty();
  if (own && (request.model_path.empty() || request.plants.empty())) {
    return absl::InvalidArgumentError(
        "--model and --plants must be given together: the controller's model, "
        "and the plants");
  }
  if (own && request.cases != kPaperCases) {
    return absl::InvalidArgumentError(
        "--cases stands for plants of the Wood-Berry column; give either "
        "--cases or --model with --plants");
  }
  if (own) {
    MLE_ASSIGN_OR_RETURN(initial, ReadModel("model", request.model_path));
    const absl::Status integrating = CheckNotIntegrating(
        initial, "reproductions are those of elements that settle");
    if (!integrating.ok()) return AboutOption("model", integrating);
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, ReadPlants(request, initial));
  } else {
    MLE_ASSIGN_OR_RETURN(initial,
                         ParseProcessModel(kWoodBerry.json, kWoodBerry.source));
    MLE_ASSIGN_OR_RETURN(campaign.mismatches, BuiltInCases(request));
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
