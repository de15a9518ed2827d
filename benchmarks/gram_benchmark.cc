// Gram matrices of lagged data: the block recursion against the dense rank-k
// update X Xᵀ (OpenBLAS' dsyrk, one thread), over order (n), rows (N) and
// channels. X is formed beforehand; the dense times do not hold it.
//
// Counters: n; GFLOPS, the products the method really makes per second;
// MiB, what it holds besides the record; error, the greatest of 500 entries'
// |G_ij − exact| / √(G_ii G_jj), exact from extended precision.

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "Eigen/Core"
#include "benchmark/benchmark.h"
#include "benchmarks/problems.h"

namespace mle::benchmarks {
namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;

Problem MakeProblem(const benchmark::State& state) {
  return WhiteSeries(
      static_cast<int>(state.range(0)), static_cast<int>(state.range(1)),
      static_cast<int>(state.range(3)), static_cast<int>(state.range(2)));
}

// Of the lower triangle of `gram`, at 500 entries.
double RelativeError(const Problem& problem, const Eigen::MatrixXd& gram) {
  std::mt19937_64 engine(1);
  std::uniform_int_distribution<Eigen::Index> draw(0, gram.rows() - 1);
  const LaggedSeries::View x =
      problem.series.front().Regressors(problem.rows.front().rows);
  double worst = 0.0;
  for (int trial = 0; trial < 500; ++trial) {
    Eigen::Index i = draw(engine);
    Eigen::Index j = draw(engine);
    if (i < j) std::swap(i, j);
    long double exact = 0.0L;
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      exact += static_cast<long double>(x(i, k)) * x(j, k);
    }
    const double error = std::abs(static_cast<double>(gram(i, j) - exact));
    worst = std::max(worst, error / std::sqrt(gram(i, i) * gram(j, j)));
  }
  return worst;
}

void Report(benchmark::State& state, double n, double products, double bytes,
            double error) {
  state.counters["n"] = n;
  state.counters["GFLOPS"] = benchmark::Counter(
      2e-9 * products, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["MiB"] = bytes / kMebibyte;
  state.counters["error"] = error;
}

// Everything a regression needs: G, the products with the responses, sums.
void BM_Lagged(benchmark::State& state) {
  const Problem problem = MakeProblem(state);
  LaggedMoments moments;
  for (auto iteration : state) {
    moments = LaggedMoments();
    moments = ComputeLaggedMoments(problem.rows);
    benchmark::DoNotOptimize(moments.gram.data());
  }
  const auto n = static_cast<double>(problem.num_regressors());
  const auto c = static_cast<double>(problem.series.front().num_channels());
  const auto q = static_cast<double>(moments.num_responses());
  Report(state, n,
         n * (c + q) * static_cast<double>(problem.num_rows()) + 2 * n * n,
         8.0 * n * (n + q), RelativeError(problem, moments.gram));
}

// One triangle of G alone.
void BM_Dense(benchmark::State& state) {
  const Problem problem = MakeProblem(state);
  const Eigen::MatrixXd x =
      problem.series.front().Regressors(problem.rows.front().rows);
  Eigen::MatrixXd gram;
  for (auto iteration : state) {
    gram = Eigen::MatrixXd();
    gram.setZero(x.rows(), x.rows());
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans,
                static_cast<int>(x.rows()), static_cast<int>(x.cols()), 1.0,
                x.data(), static_cast<int>(x.outerStride()), 0.0, gram.data(),
                static_cast<int>(gram.outerStride()));
    benchmark::DoNotOptimize(gram.data());
  }
  const auto n = static_cast<double>(x.rows());
  const auto rows = static_cast<double>(x.cols());
  Report(state, n, 0.5 * n * (n + 1) * rows, 8.0 * n * (n + rows),
         RelativeError(problem, gram));
}

// {outputs, inputs, order, rows}.
void Shapes(benchmark::internal::Benchmark* benchmark, bool dense) {
  benchmark->ArgNames({"outputs", "inputs", "order", "rows"})
      ->Unit(benchmark::kMillisecond);
  for (const int rows : {1000, 2000, 5000, 10000, 20000, 50000}) {
    benchmark->Args({2, 2, 150, rows});
  }
  for (const int order : {25, 50, 100, 200, 400}) {
    benchmark->Args({2, 2, order, 20000});
  }
  benchmark->Args({4, 6, 150, 20000});
  benchmark->Args({10, 20, 150, 20000});
  if (!dense) {
    benchmark->Args({20, 40, 150, 20000});
    benchmark->Args({30, 50, 150, 50000});
  }
}

BENCHMARK(BM_Lagged)->Apply([](auto* b) { Shapes(b, /*dense=*/false); });
BENCHMARK(BM_Dense)->Apply([](auto* b) { Shapes(b, /*dense=*/true); });

}  // namespace
}  // namespace mle::benchmarks

BENCHMARK_MAIN();
