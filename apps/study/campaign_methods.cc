#include "apps/study/campaign_methods.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "apps/study/campaign_scenarios.h"
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

absl::StatusOr<SelectionOptions> ParseRule(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  absl::StatusOr<SelectionOptions> rule = experiment::NamedSelection(name);
  if (rule.ok()) return rule;
  return Unknown(node, rule.status().message());
}

absl::StatusOr<SelectionSpec> ParseSelection(const JsonNode& node) {
  SelectionSpec spec;
  if (node.json().is_string()) {
    MLE_ASSIGN_OR_RETURN(spec.options, ParseRule(node));
    spec.name = node.json().get<std::string>();
    return spec;
  }
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"name", "rule"}, {"folds", "block", "phases", "horizon", "per_output",
                         "one_standard_error", "on_grid"}));
  MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
  MLE_ASSIGN_OR_RETURN(spec.options, ParseRule(node.At("rule")));
  constexpr int kMany = 1'000'000;
  SelectionOptions& options = spec.options;
  MLE_RETURN_IF_ERROR(ReadInteger(node, "folds", 2, kMany, options.folds));
  MLE_RETURN_IF_ERROR(
      ReadInteger(node, "block", 1, kMany, options.block_length));
  MLE_RETURN_IF_ERROR(ReadInteger(node, "phases", 1, kMany, options.phases));
  MLE_RETURN_IF_ERROR(ReadInteger(node, "horizon", -1, kMany, options.horizon));
  MLE_RETURN_IF_ERROR(ReadBoolean(node, "per_output", options.per_output));
  MLE_RETURN_IF_ERROR(
      ReadBoolean(node, "one_standard_error", options.one_standard_error));
  MLE_RETURN_IF_ERROR(ReadBoolean(node, "on_grid", options.on_grid));
  return spec;
}

absl::StatusOr<SolverSpec> ParseSolver(const JsonNode& node,
                                       const Campaign& campaign) {
  SolverSpec spec;
  if (node.json().is_object()) {
    MLE_RETURN_IF_ERROR(node.CheckKeys({"name", "elastic_net"}, {}));
    MLE_ASSIGN_OR_RETURN(spec.name, node.At("name").Name());
    MLE_ASSIGN_OR_RETURN(
        spec.options.elastic_net_ratio,
        node.At("elastic_net")
            .Number({.min = 0.0, .max = 1.0, .open_min = true}));
    spec.options.solver = LassoSolver::kElasticNet;
    if (!(campaign.settings.correction.lambdas(0) > 0.0)) {
      return node.Fault(
          "the elastic net needs λ above 0, but the first value of lambda_grid "
          "is 0: give min, max and count");
    }
    return spec;
  }
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  absl::StatusOr<SolverSpec> named = experiment::NamedSolver(name);
  if (named.ok()) return named;
  return Unknown(node,
                 absl::StrCat(named.status().message(),
                              ", and {\"name\": …, \"elastic_net\": RATIO}"));
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
    MLE_ASSIGN_OR_RETURN(SelectionSpec spec, ParseSelection(element));
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
    MLE_ASSIGN_OR_RETURN(SolverSpec spec, ParseSolver(element, campaign));
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
