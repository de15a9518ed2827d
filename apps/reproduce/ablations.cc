#include "apps/reproduce/ablations.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"
#include "apps/reproduce/summary.h"
#include "mle/base/status.h"
#include "nlohmann/json.hpp"

namespace mle::reproduce {
namespace {

using report::FormatScientific;
using report::FormatSignificant;

void ConvertWithoutNoise(ExperimentOptions& options) {
  options.conversion_noise_variance = 0.0;
}

void LeaveUnscaled(ExperimentOptions& options) {
  options.conversion.scaling = Scaling::kRaw;
  options.correction.scaling = Scaling::kRaw;
}

// MATLAB's default tolerance. Solving λ by λ takes its time: a coarse grid.
void StopAsMatlab(ExperimentOptions& options) {
  constexpr int kCandidates = 21;
  constexpr double kDecades = 4.0;
  LassoSolverOptions& solver = options.correction.solver;
  solver.solver = LassoSolver::kCoordinateDescent;
  solver.coordinate_descent.stop =
      CoordinateDescentOptions::Stop::kRelativeChange;
  solver.coordinate_descent.tolerance = 1e-4;
  const double largest = options.correction.lambdas.maxCoeff();
  Eigen::VectorXd lambdas(kCandidates + 1);
  lambdas(0) = 0.0;
  for (int i = 1; i <= kCandidates; ++i) {
    lambdas(i) = largest * std::pow(10.0, kDecades * (i - kCandidates) /
                                              (kCandidates - 1));
  }
  options.correction.lambdas = lambdas;
}

void ChoosePerOutput(ExperimentOptions& options) {
  options.correction.selection.per_output = true;
}

void TakeOneStandardError(ExperimentOptions& options) {
  options.correction.selection.one_standard_error = true;
}

void HalveWindows(ExperimentOptions& options) {
  // Half as much is kept, but in whole samples.
  const double samples = std::round(0.5 * options.window / options.sample_time);
  options.window = samples * options.sample_time;
}

constexpr Ablation kAblations[] = {
    {"noise_free_conversion", "initial model converted without noise",
     ConvertWithoutNoise},
    {"raw_scaling", "regressors not scaled", LeaveUnscaled},
    {"matlab_stop", "coordinate descent, stopped as MATLAB's lasso",
     StopAsMatlab},
    {"lambda_per_output", "a λ for each output", ChoosePerOutput},
    {"one_standard_error", "largest λ within a standard error",
     TakeOneStandardError},
    {"half_windows", "windows half as long", HalveWindows},
};

absl::StatusOr<AblationRun> Run(const ProcessModel& initial,
                                const ProcessModel& plant, std::uint64_t seed,
                                const ExperimentOptions& options) {
  MLE_ASSIGN_OR_RETURN(const ConversionSummary conversion,
                       ConvertInitialModel(initial, seed, options));
  MLE_ASSIGN_OR_RETURN(const RunResult run,
                       RunExperiment(initial, plant, conversion, seed,
                                     /*in_full=*/false, options));
  AblationRun result;
  result.lambda_star = run.lambda_star;
  result.E = run.E_star;
  result.max_relative_gap = run.max_relative_gap;
  return result;
}

}  // namespace

absl::Span<const Ablation> Ablations() { return kAblations; }

const Ablation* FindAblation(const std::string& name) {
  for (const Ablation& ablation : kAblations) {
    if (ablation.name == name) return &ablation;
  }
  return nullptr;
}

AblationRun RunAblation(const Ablation& ablation, const ProcessModel& initial,
                        const ProcessModel& plant, std::uint64_t seed,
                        const ExperimentOptions& experiment) {
  ExperimentOptions options = experiment;
  options.estimators.clear();
  ablation.apply(options);
  absl::StatusOr<AblationRun> run = Run(initial, plant, seed, options);
  if (run.ok()) return *std::move(run);
  return {.status = run.status()};
}

report::Table AblationTable(const std::string& case_name,
                            const std::vector<double>& E_method,
                            const std::vector<AblationResult>& results) {
  report::Table table;
  table.caption =
      absl::StrCat("Case ", case_name, ": one decision taken differently, ",
                   E_method.size(), E_method.size() == 1 ? " seed" : " seeds");
  table.columns = {{"what differs", report::Align::kLeft},
                   {"E mean"},
                   {"E worst"},
                   {"λ*"},
                   {"largest duality gap"}};
  const Statistics method = Summarise(E_method);
  table.AddRow({"nothing", FormatSignificant(method.mean),
                FormatSignificant(method.worst)});
  for (const AblationResult& result : results) {
    std::vector<double> E;
    std::vector<double> lambda;
    double gap = 0.0;
    std::string failure;
    for (const AblationRun& run : result.runs) {
      if (!run.status.ok()) {
        failure = std::string(run.status.message());
        continue;
      }
      E.push_back(run.E);
      lambda.push_back(run.lambda_star);
      gap = std::max(gap, run.max_relative_gap);
    }
    std::vector<std::string> row = {result.ablation->what};
    if (E.empty()) {
      row.push_back(absl::StrCat("failed: ", failure));
    } else {
      const Statistics error = Summarise(E);
      const Statistics chosen = Summarise(lambda);
      row.push_back(FormatSignificant(error.mean));
      row.push_back(FormatSignificant(error.worst));
      row.push_back(chosen.best == chosen.worst
                        ? FormatScientific(chosen.best, 2)
                        : absl::StrCat(FormatScientific(chosen.best, 2), " … ",
                                       FormatScientific(chosen.worst, 2)));
      row.push_back(FormatScientific(gap, 1));
    }
    table.AddRow(std::move(row));
  }
  return table;
}

nlohmann::ordered_json AblationsJson(
    const std::vector<AblationResult>& results) {
  using Json = nlohmann::ordered_json;
  Json json = Json::object();
  for (const AblationResult& result : results) {
    Json runs = Json::array();
    for (const AblationRun& run : result.runs) {
      if (!run.status.ok()) {
        runs.push_back({{"failure", std::string(run.status.message())}});
        continue;
      }
      runs.push_back({{"lambda_star", run.lambda_star},
                      {"E", run.E},
                      {"max_relative_duality_gap", run.max_relative_gap}});
    }
    json[result.ablation->name] = std::move(runs);
  }
  return json;
}

}  // namespace mle::reproduce
