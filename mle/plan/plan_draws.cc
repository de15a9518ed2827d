// Plants drawn from what the records leave open, and their answers to a plan.

#include <algorithm>
#include <utility>

#include "Eigen/Cholesky"
#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/plan/plan_problem.h"
#include "mle/plan/plan_row.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// θ ~ N(0, (I₀ + 1/a² 1)⁻¹) = L⁻ᵀ z.
VectorXd DrawChange(const Eigen::LLT<MatrixXd>& information,
                    GaussianNoise& noise) {
  VectorXd normal(information.rows());
  for (double& value : normal) value = noise.Draw(1.0);
  return information.matrixU().solve(normal);
}

}  // namespace

bool ComesToRest(const Record& record) {
  if (!record.set_points.rightCols(1).isZero(0.0)) return true;
  constexpr double kLeft = 0.02;
  const VectorXd end = record.outputs.rightCols(1).cwiseAbs();
  const VectorXd most = record.outputs.cwiseAbs().rowwise().maxCoeff();
  return (end.array() <= kLeft * most.array()).all();
}

absl::StatusOr<std::vector<ProcessModel>> DrawPlants(
    const PlanProblem& problem, const PlanOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<PlanRow> rows,
                       RowsOf(problem.plant, problem.sample_time));
  MLE_ASSIGN_OR_RETURN(
      const std::vector<MatrixXd> informations,
      InformationOfWindows(problem, problem.windows, rows, options.threads));
  const double prior = 1.0 / (options.ageing * options.ageing);
  std::vector<Eigen::LLT<MatrixXd>> roots;
  for (const MatrixXd& information : informations) {
    const Index n = information.rows();
    roots.emplace_back(information + prior * MatrixXd::Identity(n, n));
  }
  GaussianNoise noise(options.seed, kPlantStream, kPlanPlants);
  std::vector<ProcessModel> plants(static_cast<std::size_t>(options.draws),
                                   problem.plant);
  for (ProcessModel& plant : plants) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].Change(DrawChange(roots[i], noise), plant);
    }
  }
  return plants;
}

absl::StatusOr<PlanBand> BandOf(const PlanProblem& problem,
                                const std::vector<ProcessModel>& plants,
                                const MatrixXd& set_points, int threads) {
  const auto count = static_cast<int>(plants.size());
  std::vector<absl::StatusOr<Record>> records(plants.size());
  ParallelFor(count, threads,
              [&](int d) { records[d] = problem.loop(plants[d], set_points); });
  const Index p = problem.plant.num_outputs();
  const Index m = problem.plant.num_inputs();
  PlanBand band;
  band.low = MatrixXd::Constant(p + m, set_points.cols(), kInfinity);
  band.high = -band.low;
  band.lowest.assign(static_cast<std::size_t>(p + m), 0);
  band.highest = band.lowest;
  VectorXd least = VectorXd::Constant(p + m, kInfinity);
  VectorXd most = -least;
  for (int d = 0; d < count; ++d) {
    const absl::StatusOr<Record>& record = records[d];
    if (!record.ok()) {
      if (!absl::IsFailedPrecondition(record.status())) return record.status();
      ++band.left_out;
      continue;
    }
    MatrixXd rows(p + m, set_points.cols());
    rows << record->outputs, record->inputs;
    band.low = band.low.cwiseMin(rows).eval();
    band.high = band.high.cwiseMax(rows).eval();
    for (Index c = 0; c < p + m; ++c) {
      const double low = rows.row(c).minCoeff();
      const double high = rows.row(c).maxCoeff();
      if (low < least(c)) band.lowest[c] = d;
      if (high > most(c)) band.highest[c] = d;
      least(c) = std::min(least(c), low);
      most(c) = std::max(most(c), high);
    }
  }
  if (band.left_out == count) {
    return absl::FailedPreconditionError(
        absl::StrCat("plan: the loop holds none of ", count,
                     " plants drawn: ", records.front().status().message()));
  }
  return band;
}

}  // namespace mle
