// The exact lasso path over n and the number of active coefficients.
//
// Counters: n; active, the most coefficients that were active at once;
// segments of the path; gap, the greatest relative duality gap at 100 values of
// λ from λ_max down to where the path ends. BM_GridOfLambdas: the paper's grid
// of λ solved and certified by the Gram matrix, and what the certificate of the
// rows adds to that (certified = 1).

#include <algorithm>
#include <cmath>

#include "benchmark/benchmark.h"
#include "benchmarks/problems.h"
#include "glog/logging.h"
#include "mle/correction/correction.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"
#include "mle/regression/row_certificate.h"

namespace mle::benchmarks {
namespace {

HomotopySummary Solve(const LassoObjective& objective,
                      const HomotopyOptions& options) {
  absl::StatusOr<HomotopySummary> summary = SolveHomotopy(objective, options);
  CHECK(summary.ok()) << summary.status();
  return *std::move(summary);
}

void Run(benchmark::State& state, const LassoProblem& problem,
         HomotopyOptions options) {
  const LassoObjective objective(problem, 0);
  for (auto iteration : state) {
    benchmark::DoNotOptimize(Solve(objective, options));
  }
  const double end =
      std::max(Solve(objective, options).path.lambda_end(), 1e-6);
  options.certify_at = Eigen::pow(10.0, Eigen::ArrayXd::LinSpaced(
                                            100, std::log10(end * (1.0 + 1e-9)),
                                            std::log10(objective.LambdaMax())))
                           .matrix();
  const HomotopySummary summary = Solve(objective, options);
  state.counters["n"] = problem.num_regressors();
  state.counters["active"] = summary.max_active;
  state.counters["segments"] =
      static_cast<double>(summary.path.segments().size());
  state.counters["gap"] = summary.MaxRelativeGap();
}

LassoProblem Standardise(const Problem& problem) {
  return MakeLassoProblem(ComputeLaggedMoments(problem.rows),
                          Scaling::kStandardise);
}

// {order}: the whole path, to λ = 0, of the correction of the aged column.
void BM_WoodBerry(benchmark::State& state) {
  const LassoProblem problem = Standardise(
      WoodBerryCorrection("gain", 1, static_cast<int>(state.range(0))));
  Run(state, problem, {});
}

// {order, active}: 10 outputs and 20 inputs, N = 20,000, the path from λ_max
// until `active` coefficients are active.
void BM_Synthetic(benchmark::State& state) {
  static int order = 0;
  static LassoProblem problem;
  if (order != state.range(0)) {
    order = static_cast<int>(state.range(0));
    problem = Standardise(SyntheticPlant(10, 20, 20000, order, 1));
  }
  HomotopyOptions options;
  options.max_active = static_cast<int>(state.range(1));
  Run(state, problem, options);
}

// {order, certified}
void BM_GridOfLambdas(benchmark::State& state) {
  const Problem rows =
      WoodBerryCorrection("gain", 1, static_cast<int>(state.range(0)));
  const LassoProblem problem = Standardise(rows);
  const LassoObjective objective(problem, 0);
  const absl::StatusOr<Eigen::VectorXd> grid = MakeLambdaGrid(1e-2, 1e-6);
  CHECK(grid.ok()) << grid.status();
  double gap = 0.0;
  for (auto iteration : state) {
    absl::StatusOr<LassoSolution> solution = SolveLasso(objective, *grid, {});
    CHECK(solution.ok()) << solution.status();
    if (state.range(1) == 1) {
      CertifyByRows(rows.rows, problem, 0, objective, *solution);
    }
    gap = solution->MaxRelativeGap();
  }
  state.counters["n"] = problem.num_regressors();
  state.counters["gap"] = gap;
}

BENCHMARK(BM_WoodBerry)
    ->ArgName("order")
    ->Unit(benchmark::kMillisecond)
    ->Arg(25)
    ->Arg(50)
    ->Arg(75)
    ->Arg(100)
    ->Arg(150)
    ->Arg(200);
BENCHMARK(BM_GridOfLambdas)
    ->ArgNames({"order", "certified"})
    ->Unit(benchmark::kMillisecond)
    ->ArgsProduct({{25, 75, 150}, {0, 1}});
BENCHMARK(BM_Synthetic)
    ->ArgNames({"order", "active"})
    ->Unit(benchmark::kMillisecond)
    ->Args({25, 250})
    ->Args({50, 250})
    ->Args({100, 250})
    ->Args({150, 30})
    ->Args({150, 60})
    ->Args({150, 125})
    ->Args({150, 250})
    ->Args({150, 500})
    ->Args({150, 1000});

}  // namespace
}  // namespace mle::benchmarks

BENCHMARK_MAIN();
