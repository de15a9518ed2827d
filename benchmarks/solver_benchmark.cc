// solver_benchmark CASE SEED [SMALLEST]: the lasso solvers on the paper's
// correction (n = 600), λ from 1e-2 to 1e-5, both outputs, on one core: time,
// relative duality gap and distance from the exact solution, of smoothed L1 by
// Ceres from zero and, for λ ≥ SMALLEST (1e-3), of coordinate descent with a
// tolerance of 1e-6. Last, the whole grid 0, 1e-4, …, 1e-2 by Ceres, each λ
// from its neighbour.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "benchmarks/problems.h"
#include "glog/logging.h"
#include "mle/correction/correction.h"
#include "mle/nonlinear/smoothed_lasso.h"
#include "mle/regression/coordinate_descent.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_solver.h"

namespace mle {
namespace {

// A coefficient of the exact solution beyond this is one to be found.
constexpr double kClear = 1e-4;

// Seconds of processor time of this thread.
double Now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

double Distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

void Compare(const LassoObjective& objective, const LassoPath& path,
             double lambda, bool descend) {
  const Eigen::VectorXd exact = path.Coefficients(lambda);
  double start = Now();
  const auto smoothed = SolveSmoothedLasso(objective, lambda, {}, {});
  const double seconds = Now() - start;
  CHECK(smoothed.ok()) << smoothed.status();
  int missed = 0;
  int wrong = 0;
  for (Eigen::Index j = 0; j < exact.size(); ++j) {
    missed += std::abs(exact(j)) > kClear && smoothed->beta(j) == 0.0 ? 1 : 0;
    wrong += exact(j) == 0.0 && std::abs(smoothed->beta(j)) > kClear ? 1 : 0;
  }
  std::printf("| %.0e | %d | %.2f | %.1e | %.1e | %d, %d | %d, %d |", lambda,
              static_cast<int>((exact.array() != 0.0).count()), seconds,
              smoothed->gap.Relative(), Distance(smoothed->beta, exact), missed,
              wrong, smoothed->max_unknowns, smoothed->iterations);
  if (!descend) {
    std::printf(" | | |\n");
    return;
  }
  start = Now();
  const auto descent =
      SolveCoordinateDescent(objective, lambda, {}, {.tolerance = 1e-6});
  CHECK(descent.ok()) << descent.status();
  std::printf(" %.2f | %.1e | %.1e |\n", Now() - start, descent->gap.Relative(),
              Distance(descent->beta, exact));
}

void SolveGrid(const LassoObjective& objective, const LassoPath& path) {
  const auto grid = MakeLambdaGrid(1e-2, 1e-4);
  CHECK(grid.ok()) << grid.status();
  const double start = Now();
  const auto solution = SolveLasso(objective, *grid, SmoothedLassoSolver({}));
  const double seconds = Now() - start;
  CHECK(solution.ok()) << solution.status();
  double distance = 0.0;
  for (const double lambda : *grid) {
    distance = std::max(distance, Distance(solution->path.Coefficients(lambda),
                                           path.Coefficients(lambda)));
  }
  std::printf("\ngrid of %d λ by Ceres: %.1f s, distance %.1e; %s\n",
              static_cast<int>(grid->size()), seconds, distance,
              solution->report.c_str());
}

int Main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s gain|delay SEED [SMALLEST]\n", argv[0]);
    return 2;
  }
  const double smallest = argc > 3 ? std::atof(argv[3]) : 1e-3;
  const benchmarks::Problem rows = benchmarks::WoodBerryCorrection(
      argv[1], std::strtoull(argv[2], nullptr, 10));
  const LassoProblem problem =
      MakeLassoProblem(ComputeLaggedMoments(rows.rows), Scaling::kStandardise);
  for (int output = 0; output < problem.num_responses(); ++output) {
    const LassoObjective objective(problem, output);
    const double start = Now();
    const auto exact = SolveHomotopy(objective, {});
    CHECK(exact.ok()) << exact.status();
    std::printf("\n%s, seed %s, output %d; exact path in %.2f s: %s\n\n",
                argv[1], argv[2], output + 1, Now() - start,
                exact->BriefReport().c_str());
    std::printf(
        "| λ | not zero | Ceres, s | gap | distance | missed, wrong | "
        "unknowns, "
        "iterations | descent, s | gap | distance |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const double lambda : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5}) {
      Compare(objective, exact->path, lambda, lambda >= smallest);
      std::fflush(stdout);
    }
    SolveGrid(objective, exact->path);
  }
  return 0;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
