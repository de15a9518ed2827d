#include "apps/experiment/ablations.h"

#include <cmath>

namespace mle::experiment {
namespace {

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
  const double samples =
      std::round(0.5 * options.windows.window / options.sample_time);
  options.windows.window = samples * options.sample_time;
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

}  // namespace

absl::Span<const Ablation> Ablations() { return kAblations; }

const Ablation* FindAblation(const std::string& name) {
  for (const Ablation& ablation : kAblations) {
    if (ablation.name == name) return &ablation;
  }
  return nullptr;
}

}  // namespace mle::experiment
