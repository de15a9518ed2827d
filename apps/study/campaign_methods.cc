#include "apps/study/campaign_methods.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/study/campaign_scenarios.h"
#include "mle/base/status.h"
#include "mle/correction/correction.h"
#include "mle/nonlinear/smoothed_lasso.h"

namespace mle::study {
namespace {

using Rule = SelectionOptions::Rule;

constexpr Estimator kEstimators[] = {
    Estimator::kNone, Estimator::kArx, Estimator::kArxTested,
    Estimator::kStructured, Estimator::kCombined};

struct NamedRule {
  const char* name;
  Rule rule;
};
constexpr NamedRule kRules[] = {{"paper", Rule::kLeaveChangeOut},
                                {"leave_change_out", Rule::kLeaveChangeOut},
                                {"blocks", Rule::kBlocks},
                                {"aic", Rule::kAic},
                                {"bic", Rule::kBic},
                                {"gcv", Rule::kGcv}};

absl::StatusOr<SelectionOptions> ParseRule(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  std::vector<std::string> known;
  for (const NamedRule& one : kRules) {
    if (name == one.name) {
      SelectionOptions options;
      options.rule = one.rule;
      // As mle_reproduce's --selection=paper.
      if (name == "paper") {
        options.on_grid = true;
        options.horizon = 1;
      }
      return options;
    }
    known.emplace_back(one.name);
  }
  return node.Fault(absl::StrCat("must be one of ", absl::StrJoin(known, ", "),
                                 ", is ", node.Found()));
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
    if (!(campaign.lambdas(0) > 0.0)) {
      return node.Fault(
          "the elastic net needs λ above 0, but the first value of lambda_grid "
          "is 0: give min, max and count");
    }
    return spec;
  }
  MLE_ASSIGN_OR_RETURN(spec.name, node.Text());
  if (spec.name == "homotopy") return spec;
  spec.exact = false;
  if (spec.name == "coordinate_descent") {
    spec.options.solver = LassoSolver::kCoordinateDescent;
    return spec;
  }
  if (spec.name == "ceres") {
    spec.options = SmoothedLassoSolver({});
    return spec;
  }
  return node.Fault(absl::StrCat(
      "must be homotopy, coordinate_descent, ceres or {\"name\": …, "
      "\"elastic_net\": RATIO}, is ",
      node.Found()));
}

absl::StatusOr<Estimator> ParseEstimator(const JsonNode& node) {
  MLE_ASSIGN_OR_RETURN(const std::string name, node.Text());
  std::vector<std::string> known;
  for (const Estimator estimator : kEstimators) {
    if (name == NameOf(estimator)) return estimator;
    known.emplace_back(NameOf(estimator));
  }
  return node.Fault(absl::StrCat("must be one of ", absl::StrJoin(known, ", "),
                                 ", is ", node.Found()));
}

absl::Status ParseSelections(const JsonNode& node, Campaign& campaign) {
  if (!node.Has("selections")) {
    campaign.selections = {{"blocks", SelectionOptions()}};
    return absl::OkStatus();
  }
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
    campaign.solvers = {{"homotopy", LassoSolverOptions(), true}};
    return absl::OkStatus();
  }
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

void AddMethods(Estimator estimator, Campaign& campaign) {
  if (!UsesLambda(estimator)) {
    campaign.methods.push_back({estimator, -1, -1});
    return;
  }
  // Solver by solver: a path is solved once for all rules.
  for (int s = 0; s < static_cast<int>(campaign.solvers.size()); ++s) {
    for (int r = 0; r < static_cast<int>(campaign.selections.size()); ++r) {
      campaign.methods.push_back({estimator, r, s});
    }
  }
}

}  // namespace

const char* NameOf(Estimator estimator) {
  switch (estimator) {
    case Estimator::kNone:
      return "none";
    case Estimator::kArx:
      return "arx";
    case Estimator::kArxTested:
      return "arx_tested";
    case Estimator::kStructured:
      return "structured";
    case Estimator::kCombined:
      return "combined";
  }
  return "";
}

bool UsesLambda(Estimator estimator) {
  return estimator == Estimator::kArx || estimator == Estimator::kArxTested ||
         estimator == Estimator::kCombined;
}

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
  if (!node.Has("estimators")) {
    AddMethods(Estimator::kArx, campaign);
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> elements,
                       node.At("estimators").Elements());
  std::set<std::string> names;
  for (const JsonNode& element : elements) {
    MLE_ASSIGN_OR_RETURN(const Estimator estimator, ParseEstimator(element));
    MLE_RETURN_IF_ERROR(CheckNewName(element, NameOf(estimator), names));
    AddMethods(estimator, campaign);
  }
  return absl::OkStatus();
}

}  // namespace mle::study
