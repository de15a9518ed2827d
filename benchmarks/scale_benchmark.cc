// scale_benchmark P M N D SEED A1,A2,…: one large synthetic plant, start to
// end: Gram matrix, scaling, and for two of its outputs the path until A1, A2,
// … coefficients are active, each from the start. Meant to be run under
// `/usr/bin/time -v`, which tells the memory.

#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <utility>

#include "benchmarks/problems.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_problem.h"

namespace {

// Seconds of processor time of this thread.
double Now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

double PeakMebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) {
    std::fprintf(stderr, "usage: %s OUTPUTS INPUTS ROWS ORDER SEED ACTIVE…\n",
                 argv[0]);
    return 2;
  }
  const int num_outputs = std::atoi(argv[1]);
  mle::benchmarks::Problem problem = mle::benchmarks::SyntheticPlant(
      num_outputs, std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4]),
      std::strtoull(argv[5], nullptr, 10));
  std::printf("n = %d, N = %lld, peak memory %.0f MiB\n",
              problem.num_regressors(),
              static_cast<long long>(problem.num_rows()), PeakMebibytes());

  double start = Now();
  mle::LaggedMoments moments = mle::ComputeLaggedMoments(problem.rows);
  std::printf("Gram matrix        %8.3f s\n", Now() - start);
  problem = {};
  start = Now();
  const mle::LassoProblem lasso =
      mle::MakeLassoProblem(std::move(moments), mle::Scaling::kStandardise);
  std::printf("centring, scaling  %8.3f s\n", Now() - start);

  for (int output = 0; output < std::min(num_outputs, 2); ++output) {
    const mle::LassoObjective objective(lasso, output);
    for (int i = 6; i < argc; ++i) {
      mle::HomotopyOptions options;
      options.max_active = std::atoi(argv[i]);
      options.certify_at = Eigen::VectorXd::LinSpaced(1000, 1.0, 1000.0) *
                           (1e-3 * objective.LambdaMax());
      start = Now();
      const auto path = mle::SolveHomotopy(objective, options);
      const double seconds = Now() - start;
      if (!path.ok()) {
        std::fprintf(stderr, "%s\n", path.status().ToString().c_str());
        return 1;
      }
      double worst = 0.0;
      for (const double gap : path->relative_gap) {
        if (gap < 1e300) worst = std::max(worst, gap);
      }
      std::printf(
          "output %d, %5s active %8.3f s  %s; %d refined, certified gap ≤ "
          "%.2g\n",
          output + 1, argv[i], seconds, path->BriefReport().c_str(),
          path->refined, worst);
    }
  }
  std::printf("peak memory        %8.0f MiB\n", PeakMebibytes());
  return 0;
}
