// The regression engine on small problems of any degeneracy: every solver ends,
// nothing is NaN, and a certificate is what an independent computation of the
// duality gap says.

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "mle/data/lagged_series.h"
#include "mle/regression/coordinate_descent.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/elastic_net.h"
#include "mle/regression/homotopy.h"
#include "mle/regression/lagged_moments.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"
#include "tests/fuzz/fuzz.h"
#include "tests/mle/regression/gap_tolerance.h"

namespace mle {
namespace {

struct Problem {
  Eigen::MatrixXd gram;
  LassoObjective objective;
};

Eigen::VectorXd WeightsFrom(fuzz::Bytes& bytes, int size) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(size);
  if (bytes.Flag()) return weights;
  for (double& weight : weights) {
    const int kind = bytes.Between(0, 7);
    if (kind == 0) weight = 0.0;
    if (kind == 1) weight = std::numeric_limits<double>::infinity();
    if (kind == 2) weight = 1e-3;
    if (kind == 3) weight = 30.0;
  }
  if (std::isinf(weights.minCoeff())) weights(0) = 1.0;
  return weights;
}

// Any matrix of regressors.
void FillExplicit(fuzz::Bytes& bytes, Problem& problem) {
  const int size = bytes.Between(1, 12);
  const int rows = bytes.Between(1, 24);
  Eigen::MatrixXd X(size, rows);
  for (double& value : X.reshaped()) value = bytes.Number();
  Eigen::VectorXd response(rows);
  for (double& value : response) value = bytes.Number();
  problem.gram = X * X.transpose() / rows;
  problem.gram = Eigen::MatrixXd(problem.gram.selfadjointView<Eigen::Lower>());
  problem.objective.correlation = X * response / rows;
  problem.objective.response_square = response.squaredNorm() / rows;
}

// Lags of a record of one output and one input, bad samples included. False
// where no row is left.
bool FillLagged(fuzz::Bytes& bytes, Problem& problem) {
  const int order = bytes.Between(1, 6);
  const int samples = bytes.Between(1, 50);
  const Scaling scaling = bytes.Flag() ? Scaling::kRaw : Scaling::kStandardise;
  const bool with_bad_samples = bytes.Flag();
  Record record;
  record.sample_time = 1.0;
  record.outputs.resize(1, samples);
  record.inputs.resize(1, samples);
  for (int k = 0; k < samples; ++k) {
    record.outputs(0, k) = bytes.Number();
    record.inputs(0, k) = bytes.Number();
    if (with_bad_samples && bytes.Between(0, 15) == 0) {
      record.outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const LaggedSeries series(record, order);
  std::vector<RegressionRows> rows;
  for (const RowRange& range : series.UsableRows()) {
    rows.push_back({&series, range, series.Outputs(range), 0});
  }
  if (rows.empty()) return false;
  LassoProblem lasso = MakeLassoProblem(ComputeLaggedMoments(rows), scaling);
  FUZZ_EXPECT(lasso.gram.allFinite() && lasso.correlation.allFinite());
  problem.gram = std::move(lasso.gram);
  problem.objective.correlation = lasso.correlation.col(0);
  problem.objective.response_square = lasso.response_square(0);
  return true;
}

// Ascending.
Eigen::VectorXd Lambdas(double lambda_max, double smallest_part) {
  Eigen::VectorXd lambdas(8);
  for (int i = 0; i < 8; ++i) {
    lambdas(i) = lambda_max * std::pow(smallest_part, 1.0 - (i + 1) / 8.0);
  }
  return lambdas;
}

// What is certified at λ is so, up to what rounding of β may change.
void CheckCertificate(const char* solver, const LassoObjective& objective,
                      double lambda, const Eigen::VectorXd& beta,
                      double certified) {
  FUZZ_EXPECT(!std::isnan(certified) && certified >= 0.0, solver);
  if (std::isinf(certified)) return;  // the path did not reach: it says so
  FUZZ_EXPECT(beta.allFinite(), solver);
  // The certificate is relative to the least that the primal value may be; held
  // against the most.
  DualityGap gap = ComputeDualityGap(objective, lambda, beta);
  gap.primal_rounding *= -1.0;
  const double actual = gap.Relative();
  FUZZ_EXPECT(
      actual <= 2.0 * certified + 10.0 * GapTolerance(objective, lambda, beta),
      std::string(solver) + ": certified " + std::to_string(certified) +
          ", is " + std::to_string(actual) +
          " at λ/λ_max = " + std::to_string(lambda / objective.LambdaMax()));
}

void CheckHomotopy(const LassoObjective& objective,
                   const Eigen::VectorXd& lambdas) {
  HomotopyOptions options;
  options.certify_at = lambdas;
  const auto summary = SolveHomotopy(objective, options);
  FUZZ_EXPECT(summary.ok(), summary.status().ToString());
  FUZZ_EXPECT(!summary->BriefReport().empty());
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    CheckCertificate("homotopy", objective, lambdas(i),
                     summary->path.Coefficients(lambdas(i)),
                     summary->relative_gap(i));
  }
}

void CheckSolver(const LassoObjective& objective,
                 const Eigen::VectorXd& lambdas, LassoSolver solver) {
  LassoSolverOptions options;
  options.solver = solver;
  options.coordinate_descent.max_sweeps = 200;
  const auto solution = SolveLasso(objective, lambdas, options);
  FUZZ_EXPECT(solution.ok(), solution.status().ToString());
  FUZZ_EXPECT(!solution->report.empty());
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    CheckCertificate("SolveLasso", objective, lambdas(i),
                     solution->path.Coefficients(lambdas(i)),
                     solution->relative_gap(i));
  }
}

void CheckElasticNet(const LassoObjective& objective,
                     const Eigen::VectorXd& lambdas, double ratio) {
  ElasticNetOptions options;
  options.ratio = ratio;
  options.max_steps = 500;
  const auto solution = SolveElasticNet(objective, lambdas, options);
  if (!solution.ok()) {
    FUZZ_EXPECT(!solution.status().message().empty());
    return;
  }
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    FUZZ_EXPECT(!std::isnan(solution->relative_gap(i)));
    FUZZ_EXPECT(solution->path.Coefficients(lambdas(i)).allFinite());
  }
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  if (size > 2048) return 0;
  mle::fuzz::Bytes bytes(data, size);
  mle::Problem problem;
  const int mode = bytes.Next();
  const double ratio = bytes.Between(1, 10) / 10.0;
  if (mode % 2 == 0) {
    mle::FillExplicit(bytes, problem);
  } else if (!mle::FillLagged(bytes, problem)) {
    return 0;
  }
  mle::LassoObjective& objective = problem.objective;
  objective.gram = &problem.gram;
  objective.weights =
      mle::WeightsFrom(bytes, static_cast<int>(problem.gram.rows()));
  FUZZ_EXPECT(objective.Validate().ok(), objective.Validate().ToString());
  const double lambda_max = objective.LambdaMax();
  FUZZ_EXPECT(std::isfinite(lambda_max));
  if (!(lambda_max > 0.0)) return 0;
  const Eigen::VectorXd lambdas = mle::Lambdas(lambda_max, 1e-6);
  mle::CheckHomotopy(objective, lambdas);
  mle::CheckSolver(objective, lambdas, mle::LassoSolver::kHomotopy);
  if (mode % 3 == 0) {
    mle::CheckSolver(objective, lambdas, mle::LassoSolver::kCoordinateDescent);
    mle::CheckElasticNet(objective, lambdas, ratio);
  }
  return 0;
}
