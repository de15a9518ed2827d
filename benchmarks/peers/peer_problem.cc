// One lasso problem for several solvers, and our part of the comparison.
//
//   peer_problem write DIR gain|delay|conversion SEED
//     gram.npy (n × n), correlation.npy (n × 1), response_square.npy (1 × 1),
//     x.npy (N × n), y.npy (N × 1), all centred and scaled, and lambdas.npy:
//     100 values of λ from 1e-2 down to 1e-6, where λ_max is not smaller
//   peer_problem solve DIR path|certified REPEATS
//     the whole path to λ = 0 by homotopy, and, if certified, the duality gap
//     at the paper's 10,001 values of λ; writes coefficients.npy at
//     lambdas.npy. Prints processor and wall seconds, a line for each
//     repetition
//   peer_problem gap DIR
//     what the n × L numbers of coefficients.npy are worth at the L first
//     values of lambdas.npy: the largest f(β)/min f − 1, the median and the
//     largest relative duality gap, and L

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/peers/npy.h"
#include "benchmarks/problems.h"
#include "glog/logging.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lasso_problem.h"

namespace mle::benchmarks {
namespace {

double Now(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

Eigen::MatrixXd Read(const std::string& path) {
  absl::StatusOr<Eigen::MatrixXd> matrix = ReadNpy(path);
  CHECK(matrix.ok()) << matrix.status();
  return *std::move(matrix);
}

void Write(const Eigen::MatrixXd& matrix, const std::string& path) {
  const absl::Status status = WriteNpy(matrix, path);
  CHECK(status.ok()) << status;
}

// X and y of the first response, centred and scaled as `lasso` is.
void WriteRows(const Problem& problem, const LassoProblem& lasso,
               const std::string& dir) {
  const auto n = lasso.num_regressors();
  Eigen::MatrixXd x(problem.num_rows(), n);
  Eigen::MatrixXd y(problem.num_rows(), 1);
  Eigen::Index row = 0;
  for (const RegressionRows& part : problem.rows) {
    const auto count = part.rows.rows();
    x.middleRows(row, count) = part.series->Regressors(part.rows).transpose();
    y.middleRows(row, count) = part.responses.row(0).transpose();
    row += count;
  }
  x.rowwise() -= lasso.regressor_mean.col(0).transpose();
  x.array().rowwise() /= lasso.scale.transpose().array();
  y.array() -= lasso.response_mean(0);
  Write(x, dir + "/x.npy");
  Write(y, dir + "/y.npy");
}

void WriteProblem(const std::string& dir, const std::string& name,
                  std::uint64_t seed) {
  const Problem problem = name == "conversion"
                              ? WoodBerryConversion(seed, 50000)
                              : WoodBerryCorrection(name, seed);
  const LassoProblem lasso = MakeLassoProblem(
      ComputeLaggedMoments(problem.rows), Scaling::kStandardise);
  CHECK(lasso.constant_regressors.empty());
  Write(lasso.gram, dir + "/gram.npy");
  Write(lasso.correlation.col(0), dir + "/correlation.npy");
  Write(lasso.response_square.head(1), dir + "/response_square.npy");
  const double first =
      std::min(1e-2, 0.999 * LassoObjective(lasso, 0).LambdaMax());
  Write(
      Eigen::pow(10.0, Eigen::ArrayXd::LinSpaced(100, std::log10(first), -6.0))
          .matrix(),
      dir + "/lambdas.npy");
  WriteRows(problem, lasso, dir);
}

struct StoredProblem {
  Eigen::MatrixXd gram;
  LassoObjective objective;

  explicit StoredProblem(const std::string& dir)
      : gram(Read(dir + "/gram.npy")) {
    objective.gram = &gram;
    objective.correlation = Read(dir + "/correlation.npy");
    objective.response_square = Read(dir + "/response_square.npy")(0);
    objective.weights.setOnes(gram.rows());
  }
};

HomotopySummary Solve(const LassoObjective& objective,
                      const HomotopyOptions& options) {
  absl::StatusOr<HomotopySummary> summary = SolveHomotopy(objective, options);
  CHECK(summary.ok()) << summary.status();
  return *std::move(summary);
}

// Of n numbers of each active column, and of the factor for a column that
// enters and for the slope, in each segment; without refinement.
double BytesRead(const LassoPath& path, int n) {
  double bytes = 0.0;
  for (const LassoPath::Segment& segment : path.segments()) {
    const auto k = static_cast<double>(segment.active);
    bytes += sizeof(double) * (n * k + k * k);
  }
  return bytes;
}

void SolveProblem(const std::string& dir, bool certified, int repeats) {
  const StoredProblem problem(dir);
  HomotopyOptions options;
  if (certified) {
    options.certify_at = 1e-6 * Eigen::VectorXd::LinSpaced(10001, 0.0, 10000.0);
  }
  HomotopySummary summary;
  for (int i = 0; i < repeats; ++i) {
    const double start = Now(CLOCK_THREAD_CPUTIME_ID);
    const double wall_start = Now(CLOCK_MONOTONIC);
    summary = Solve(problem.objective, options);
    std::printf("%.6f %.6f\n", Now(CLOCK_THREAD_CPUTIME_ID) - start,
                Now(CLOCK_MONOTONIC) - wall_start);
  }
  std::fprintf(stderr, "%s; %d refined, %d refactored, %.2f GB read\n",
               summary.BriefReport().c_str(), summary.refined,
               summary.refactored,
               1e-9 * BytesRead(summary.path, problem.objective.size()));
  const Eigen::MatrixXd lambdas = Read(dir + "/lambdas.npy");
  Eigen::MatrixXd beta(problem.objective.size(), lambdas.rows());
  for (Eigen::Index i = 0; i < lambdas.rows(); ++i) {
    beta.col(i) = summary.path.Coefficients(lambdas(i));
  }
  Write(beta, dir + "/coefficients.npy");
}

void PrintGap(const std::string& dir) {
  const StoredProblem problem(dir);
  const Eigen::MatrixXd lambdas = Read(dir + "/lambdas.npy");
  const Eigen::MatrixXd beta = Read(dir + "/coefficients.npy");
  CHECK_EQ(beta.rows(), problem.gram.rows());
  CHECK_GT(beta.cols(), 0);
  CHECK_LE(beta.cols(), lambdas.rows());
  const LassoPath exact = Solve(problem.objective, {}).path;
  double suboptimality = 0.0;
  std::vector<double> gaps;
  for (Eigen::Index i = 0; i < beta.cols(); ++i) {
    const double lambda = lambdas(i);
    const DualityGap peer =
        ComputeDualityGap(problem.objective, lambda, beta.col(i));
    const DualityGap own = ComputeDualityGap(problem.objective, lambda,
                                             exact.Coefficients(lambda));
    suboptimality = std::max(suboptimality, peer.primal / own.primal - 1.0);
    gaps.push_back(peer.Relative());
  }
  std::sort(gaps.begin(), gaps.end());
  std::printf("%.2g %.2g %.2g %zu\n", suboptimality, gaps[gaps.size() / 2],
              gaps.back(), gaps.size());
}

int Main(const std::vector<std::string>& words) {
  if (words.size() == 4 && words[0] == "write") {
    WriteProblem(words[1], words[2], std::stoull(words[3]));
  } else if (words.size() == 4 && words[0] == "solve") {
    SolveProblem(words[1], words[2] == "certified", std::stoi(words[3]));
  } else if (words.size() == 2 && words[0] == "gap") {
    PrintGap(words[1]);
  } else {
    std::fprintf(stderr,
                 "usage: peer_problem write DIR gain|delay|conversion SEED\n"
                 "       peer_problem solve DIR path|certified REPEATS\n"
                 "       peer_problem gap DIR\n");
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace mle::benchmarks

int main(int argc, char** argv) {
  return mle::benchmarks::Main({argv + 1, argv + argc});
}
