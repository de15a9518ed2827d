#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "apps/common/option_json.h"
#include "apps/experiment/experiment_options.h"
#include "apps/study/campaign_json.h"
#include "mle/base/status.h"
#include "mle/correction/correction.h"

namespace mle::study {
namespace {

using experiment::Ablation;
using experiment::AddMethods;
using experiment::Campaign;
using experiment::Method;
using experiment::SelectionSpec;
using experiment::SolverSpec;

absl::Status Unknown(const JsonNode& node, absl::string_view known) {
  return node.Fault(absl::StrCat("is ", node.Found(), "; ", known));
}

// A name from a table, into the field that `value` binds.
absl::Status Choose(const JsonNode& node, const TextValue& value,
                    absl::string_view others = "") {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  const absl::Status status = value.read(name, kAnyNumber);
  if (status.ok()) return status;
  return Unknown(node, absl::StrCat(status.message(), others));
}

absl::Status ParseSelection(const JsonNode& node, SelectionSpec& spec) {
  if (node.json().is_string()) return Choose(node, RuleOf(&spec));
  std::vector<Option> options = OptionsOf(spec);
  options.push_back({"name", &spec.name, ""});
  MLE_RETURN_IF_ERROR(
      ReadOptionsOnly(node, {"name", "rule"}, std::move(options)));
  return node.At("name").Name().status();
}

absl::Status ParseSolver(const JsonNode& node, const Campaign& campaign,
                         SolverSpec& spec) {
  if (!node.json().is_object()) {
    return Choose(node, SolverOf(&spec),
                  ", and {\"name\": …, \"elastic_net\": RATIO}");
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys({"name", "elastic_net"}, {}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  MLE_ASSIGN_OR_RETURN(spec.options.elastic_net_ratio,
                       node.At("elastic_net")
                           .Number({.min = 0.0, .max = 1.0, .open_min = true}));
  spec.options.solver = LassoSolver::kElasticNet;
  if (campaign.settings.correction.lambdas(0) > 0.0) return absl::OkStatus();
  return node.Fault(
      "the elastic net needs λ above 0, but the first value of lambda_grid "
      "is 0: give min, max and count");
}

absl::StatusOr<Method> ParseEstimator(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  absl::StatusOr<Method> method = experiment::ParseMethod(name);
  if (method.ok()) return method;
  return Unknown(node, method.status().message());
}

absl::Status ParseSelections(const JsonNode& node, Campaign& campaign) {
  if (!node.Has("selections")) {
    return absl::OkStatus();
  }
  campaign.selections.clear();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("selections").Elements());
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    SelectionSpec spec;
    MLE_RETURN_IF_ERROR(ParseSelection(element, spec));
    MLE_RETURN_IF_ERROR(CheckNewName(element, spec.name, names));
    campaign.selections.push_back(std::move(spec));
  }
  return absl::OkStatus();
}

absl::Status ParseSolvers(const JsonNode& node, Campaign& campaign) {
  if (!node.Has("solvers")) {
    return absl::OkStatus();
  }
  campaign.solvers.clear();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("solvers").Elements());
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    SolverSpec spec;
    MLE_RETURN_IF_ERROR(ParseSolver(element, campaign, spec));
    MLE_RETURN_IF_ERROR(CheckNewName(element, spec.name, names));
    campaign.solvers.push_back(std::move(spec));
  }
  return absl::OkStatus();
}

absl::Status ParseAblations(const JsonNode& node, Campaign& campaign) {
  if (!node.Has("ablations")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("ablations").Elements());
  campaign.ablations.clear();
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const std::string name, element.Text());
    MLE_RETURN_IF_ERROR(CheckNewName(element, name, names));
    const Ablation* const ablation = experiment::FindAblation(name);
    if (ablation == nullptr && name != "none") {
      std::string known = "none";
      for (const Ablation& one : experiment::Ablations()) {
        absl::StrAppend(&known, ", ", one.name);
      }
      return Unknown(element, absl::StrCat("known are ", known));
    }
    campaign.ablations.push_back(ablation);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Eigen::VectorXd> ParseLambdaGrid(const JsonNode& node) {
  if (node.json().is_object() && node.Has("step")) {
    MLE_RETURN_IF_ERROR(node.CheckKeys({"max", "step"}, {}));
    MLE_ASSIGN_OR_RETURN(const double max, node.At("max").Number(kPositive));
    MLE_ASSIGN_OR_RETURN(const double step, node.At("step").Number(kPositive));
    absl::StatusOr<Eigen::VectorXd> grid = MakeLambdaGrid(max, step);
    if (grid.ok()) return grid;
    return node.Fault(std::string(grid.status().message()));
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys({"min", "max", "count"}, {}));
  MLE_ASSIGN_OR_RETURN(const double min, node.At("min").Number(kPositive));
  MLE_ASSIGN_OR_RETURN(const double max,
                       node.At("max").Number({.min = min, .open_min = true}));
  MLE_ASSIGN_OR_RETURN(const std::int64_t count,
                       node.At("count").Integer(2, 1'000'000));
  Eigen::VectorXd grid(count);
  for (std::int64_t i = 0; i < count; ++i) {
    grid(i) = min * std::pow(max / min, static_cast<double>(i) /
                                            static_cast<double>(count - 1));
  }
  grid(count - 1) = max;
  return grid;
}

absl::Status ParseMethods(const JsonNode& node, Campaign& campaign) {
  MLE_RETURN_IF_ERROR(ParseSelections(node, campaign));
  MLE_RETURN_IF_ERROR(ParseSolvers(node, campaign));
  MLE_RETURN_IF_ERROR(ParseAblations(node, campaign));
  if (!node.Has("estimators")) {
    AddMethods(experiment::PaperMethod(), campaign);
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("estimators").Elements());
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const Method method, ParseEstimator(element));
    MLE_RETURN_IF_ERROR(CheckNewName(element, method.name(), names));
    AddMethods(method, campaign);
  }
  return absl::OkStatus();
}

}  // namespace mle::study
