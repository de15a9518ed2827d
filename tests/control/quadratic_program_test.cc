#include "control/quadratic_program.h"

#include <cmath>
#include <random>

#include "Eigen/Cholesky"
#include "Eigen/LU"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  MatrixXd H, A;
  VectorXd cost, x0, lower, upper;
};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  VectorXd Vector(Eigen::Index size) {
    VectorXd v(size);
    for (double& value : v) value = Uniform(-1.0, 1.0);
    return v;
  }
  MatrixXd Matrix(Eigen::Index rows, Eigen::Index cols) {
    MatrixXd m(rows, cols);
    for (double& value : m.reshaped()) value = Uniform(-1.0, 1.0);
    return m;
  }

 private:
  std::mt19937 engine_;
};

// Limits around a point that meets them all, one-sided, two-sided and equal;
// some rows soft, some repeated.
Problem RandomProblem(int n, int r, unsigned seed) {
  Random random(seed);
  Problem problem;
  const MatrixXd root = random.Matrix(n, n);
  problem.H = root.transpose() * root + 0.05 * MatrixXd::Identity(n, n);
  problem.A = random.Matrix(r, n);
  if (r > 3) problem.A.row(3) = -2.0 * problem.A.row(0);
  problem.x0 = 3.0 * random.Vector(n);
  const VectorXd inside = random.Vector(n);
  problem.cost = VectorXd::Constant(r, kInfinity);
  problem.lower.resize(r);
  problem.upper.resize(r);
  for (int i = 0; i < r; ++i) {
    const double value = problem.A.row(i).dot(inside);
    const double kind = random.Uniform(0.0, 1.0);
    problem.lower[i] = kind < 0.3 ? -kInfinity : value - random.Uniform(0, 0.5);
    problem.upper[i] = kind > 0.7 ? kInfinity : value + random.Uniform(0, 0.5);
    if (kind > 0.4 && kind < 0.45) problem.lower[i] = problem.upper[i] = value;
    if (random.Uniform(0.0, 1.0) < 0.3) {
      problem.cost[i] = random.Uniform(0.1, 100.0);
    }
  }
  return problem;
}

QuadraticProgram Make(const Problem& problem) {
  absl::StatusOr<QuadraticProgram> program =
      QuadraticProgram::Create(problem.H, problem.A, problem.cost);
  EXPECT_TRUE(program.ok()) << program.status();
  return *std::move(program);
}

// The conditions of Karush, Kuhn and Tucker, which a strictly convex problem's
// minimiser alone meets.
void ExpectOptimal(const Problem& problem, const QuadraticProgram& program,
                   double tolerance) {
  const VectorXd& x = program.x();
  const VectorXd& lambda = program.multipliers();
  const VectorXd stationarity =
      problem.H * (x - problem.x0) + problem.A.transpose() * lambda;
  EXPECT_LE(stationarity.cwiseAbs().maxCoeff(), tolerance);
  const VectorXd values = problem.A * x;
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    const double slack = std::abs(lambda[i]) / problem.cost[i];
    EXPECT_GE(values[i], problem.lower[i] - slack - tolerance) << i;
    EXPECT_LE(values[i], problem.upper[i] + slack + tolerance) << i;
    if (lambda[i] > 0.0) {
      EXPECT_NEAR(values[i], problem.upper[i] + slack, tolerance) << i;
    } else if (lambda[i] < 0.0) {
      EXPECT_NEAR(values[i], problem.lower[i] - slack, tolerance) << i;
    }
  }
}

// Multipliers go up to about 1e3 and H to 1e2: 1e-9 leaves four digits for
// rounding.
TEST(QuadraticProgramTest, MeetsTheOptimalityConditions) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const int n = 1 + static_cast<int>(seed % 12);
    const int r = 1 + static_cast<int>((7 * seed) % 40);
    const Problem problem = RandomProblem(n, r, seed);
    QuadraticProgram program = Make(problem);
    const auto summary =
        program.Solve(problem.x0, problem.lower, problem.upper);
    ASSERT_TRUE(summary.converged) << seed;
    ExpectOptimal(problem, program, 1e-9);
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

// All choices of rows to hold as equations, at either limit: the best point
// among those that meet every limit.
double BruteForceObjective(const Problem& problem) {
  const int n = static_cast<int>(problem.x0.size());
  const int r = static_cast<int>(problem.lower.size());
  int choices = 1;
  for (int i = 0; i < r; ++i) choices *= 3;
  double best = kInfinity;
  for (int choice = 0; choice < choices; ++choice) {
    std::vector<int> rows;
    std::vector<double> bounds;
    int rest = choice;
    for (int i = 0; i < r; ++i, rest /= 3) {
      if (rest % 3 == 0) continue;
      rows.push_back(i);
      bounds.push_back(rest % 3 == 1 ? problem.lower[i] : problem.upper[i]);
    }
    const int k = static_cast<int>(rows.size());
    if (k > n) continue;
    MatrixXd kkt = MatrixXd::Zero(n + k, n + k);
    VectorXd right(n + k);
    kkt.topLeftCorner(n, n) = problem.H;
    right.head(n) = problem.H * problem.x0;
    bool finite = true;
    for (int a = 0; a < k; ++a) {
      kkt.row(n + a).head(n) = problem.A.row(rows[a]);
      kkt.col(n + a).head(n) = problem.A.row(rows[a]).transpose();
      right[n + a] = bounds[a];
      finite = finite && std::isfinite(bounds[a]);
    }
    if (!finite) continue;
    const Eigen::FullPivLU<MatrixXd> lu(kkt);
    if (!lu.isInvertible()) continue;
    const VectorXd x = lu.solve(right).head(n);
    const VectorXd values = problem.A * x;
    if (((values - problem.lower).array() < -1e-9).any() ||
        ((values - problem.upper).array() > 1e-9).any()) {
      continue;
    }
    best = std::min(best,
                    0.5 * (x - problem.x0).dot(problem.H * (x - problem.x0)));
  }
  return best;
}

TEST(QuadraticProgramTest, AgreesWithAllChoicesOfActiveRows) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Problem problem = RandomProblem(3, 6, seed);
    problem.cost.setConstant(kInfinity);
    QuadraticProgram program = Make(problem);
    ASSERT_TRUE(
        program.Solve(problem.x0, problem.lower, problem.upper).converged);
    const VectorXd step = program.x() - problem.x0;
    const double expected = BruteForceObjective(problem);
    EXPECT_NEAR(0.5 * step.dot(problem.H * step), expected,
                1e-8 * (1.0 + expected))
        << seed;
  }
}

TEST(QuadraticProgramTest, WithoutActiveLimitsReturnsTheStart) {
  Problem problem = RandomProblem(4, 6, 1);
  problem.lower.setConstant(-100.0);
  problem.upper.setConstant(100.0);
  QuadraticProgram program = Make(problem);
  const auto summary = program.Solve(problem.x0, problem.lower, problem.upper);
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(summary.active_rows, 0);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(program.x(), problem.x0);
}

TEST(QuadraticProgramTest, WarmStartGivesTheSameAnswerSooner) {
  const Problem first = RandomProblem(10, 40, 5);
  Problem second = first;
  second.x0 += 1e-3 * Random(9).Vector(10);
  QuadraticProgram warm = Make(first);
  ASSERT_TRUE(warm.Solve(first.x0, first.lower, first.upper).converged);
  const auto warm_summary = warm.Solve(second.x0, second.lower, second.upper);
  QuadraticProgram cold = Make(second);
  const auto cold_summary = cold.Solve(second.x0, second.lower, second.upper);
  ASSERT_GT(cold_summary.active_rows, 2);
  EXPECT_LT(warm_summary.iterations, cold_summary.iterations);
  EXPECT_LE((warm.x() - cold.x()).cwiseAbs().maxCoeff(), 1e-10);
}

// A box and H = I: the minimiser is x₀ cut to the box; with soft sides, halfway
// for c = 1.
TEST(QuadraticProgramTest, BoxesInClosedForm) {
  const MatrixXd I = MatrixXd::Identity(2, 2);
  const VectorXd x0 = (VectorXd(2) << 3.0, -0.5).finished();
  const VectorXd lower = VectorXd::Constant(2, -1.0);
  const VectorXd upper = VectorXd::Constant(2, 1.0);
  Problem problem{I, I, VectorXd::Constant(2, kInfinity), x0, lower, upper};
  QuadraticProgram hard = Make(problem);
  ASSERT_TRUE(hard.Solve(x0, lower, upper).converged);
  EXPECT_DOUBLE_EQ(hard.x()[0], 1.0);
  EXPECT_DOUBLE_EQ(hard.x()[1], -0.5);
  EXPECT_DOUBLE_EQ(hard.multipliers()[0], 2.0);
  problem.cost.setConstant(1.0);
  QuadraticProgram soft = Make(problem);
  ASSERT_TRUE(soft.Solve(x0, lower, upper).converged);
  EXPECT_DOUBLE_EQ(soft.x()[0], 2.0);
  EXPECT_DOUBLE_EQ(soft.multipliers()[0], 1.0);
}

TEST(QuadraticProgramTest, ReportsLimitsThatContradictEachOther) {
  const MatrixXd A = (MatrixXd(2, 1) << 1.0, -1.0).finished();
  QuadraticProgram program =
      Make({MatrixXd::Identity(1, 1), A, VectorXd::Constant(2, kInfinity),
            VectorXd::Zero(1), VectorXd::Zero(2), VectorXd::Zero(2)});
  // x ≥ 1 and −x ≥ 1.
  const VectorXd lower = VectorXd::Ones(2);
  const VectorXd upper = VectorXd::Constant(2, kInfinity);
  EXPECT_FALSE(program.Solve(VectorXd::Zero(1), lower, upper).converged);
  // It recovers.
  EXPECT_TRUE(
      program.Solve(VectorXd::Zero(1), -lower, VectorXd::Ones(2)).converged);
  EXPECT_EQ(program.x()[0], 0.0);
}

TEST(QuadraticProgramTest, RefusesWhatIsNoProblem) {
  const MatrixXd I = MatrixXd::Identity(2, 2);
  const VectorXd cost = VectorXd::Ones(2);
  EXPECT_FALSE(QuadraticProgram::Create(-I, I, cost).ok());
  EXPECT_FALSE(
      QuadraticProgram::Create(I, MatrixXd::Identity(3, 3), cost).ok());
  EXPECT_FALSE(QuadraticProgram::Create(I, I, -cost).ok());
}

}  // namespace
}  // namespace mle::control
