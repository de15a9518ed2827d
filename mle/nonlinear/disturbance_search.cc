#include "mle/nonlinear/disturbance_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "mle/nonlinear/extended_fit.h"
#include "mle/nonlinear/line_search.h"
#include "mle/nonlinear/step_search.h"

namespace mle {
namespace {

constexpr int kMostLines = 3;
constexpr int kMostSteps = 3;  // of a segment

double LogSamples(const OutputErrorProblem& problem) {
  return std::log(problem.num_innovations(NoiseShape()));
}

// A line or a step.
struct Disturbance {
  std::optional<double> period;
  std::optional<SegmentStep> step;
};

// The disturbance that the residuals of `fit` show, a sinusoid or a step,
// whichever gains more. Bursts of outliers look like steps: with a robust loss
// none is sought.
std::optional<Disturbance> Find(const OutputErrorProblem& problem,
                                const OutputFit& fit,
                                const OutputErrorOptions& options) {
  const ExtendedFit extended(problem, fit, options.estimate_drift);
  std::optional<FoundPeriod> line;
  if (static_cast<int>(problem.lines().size()) < kMostLines) {
    line = FindPeriod(extended);
  }
  std::optional<FoundStep> step;
  if (options.robust_loss == RobustLoss::kNone) {
    step = FindStep(extended);
  }
  if (step.has_value() &&
      std::count_if(problem.steps().begin(), problem.steps().end(),
                    [&](const SegmentStep& other) {
                      return other.segment == step->step.segment;
                    }) >= kMostSteps) {
    step.reset();
  }
  if (line.has_value() && (!step.has_value() || line->gain >= step->gain)) {
    return Disturbance{.period = line->period, .step = std::nullopt};
  }
  if (step.has_value()) {
    return Disturbance{.period = std::nullopt, .step = step->step};
  }
  return std::nullopt;
}

void Add(const Disturbance& found, OutputErrorProblem& problem) {
  if (found.period.has_value()) {
    std::vector<double> periods = problem.lines();
    periods.push_back(*found.period);
    problem.SetLines(periods);
  } else {
    std::vector<SegmentStep> steps = problem.steps();
    steps.push_back(*found.step);
    problem.SetSteps(std::move(steps));
  }
}

// A model may be bent until it explains a sine or a step that the inputs
// answer. So the initial values are asked too, and the fit with what they show
// is taken if it beats the one without. False if nothing was found.
bool FitThoseOfStart(const OutputPoint& start, const OutputFitBounds& bounds,
                     const OutputErrorOptions& options,
                     OutputErrorProblem& problem, OutputFit& fit) {
  OutputFit at_start = fit;
  at_start.point = start;
  at_start.noise = EstimateNoise(problem, start, fit.free, NoiseEstimate(),
                                 options.estimate_drift, /*search_ar=*/false);
  const std::optional<Disturbance> found = Find(problem, at_start, options);
  if (!found.has_value()) return false;
  const std::vector<double> lines = problem.lines();
  const std::vector<SegmentStep> steps = problem.steps();
  Add(*found, problem);
  OutputFit with = FitOutput(problem, start, fit.free, bounds, options);
  const double price =
      found->period.has_value() ? LinePrice(problem) : StepPrice(problem);
  if (!(with.deviance + price < fit.deviance)) {
    problem.SetLines(lines);
    problem.SetSteps(steps);
    return false;
  }
  fit = std::move(with);
  return true;
}

}  // namespace

double LinePrice(const OutputErrorProblem& problem) {
  return (2.0 * problem.num_segments() + 1.0) * LogSamples(problem);
}

double StepPrice(const OutputErrorProblem& problem) {
  return 3.0 * LogSamples(problem) +
         2.0 * std::log(1.0 + problem.num_elements_present());
}

void FitDisturbances(const OutputPoint& start, const OutputFitBounds& bounds,
                     const OutputErrorOptions& options,
                     OutputErrorProblem& problem, OutputFit& fit) {
  if (!options.estimate_drift || problem.num_segments() == 0) return;
  const int most = kMostLines + kMostSteps * problem.num_segments();
  for (int count = 0; count < most; ++count) {
    const std::optional<Disturbance> found = Find(problem, fit, options);
    if (!found.has_value()) {
      if (FitThoseOfStart(start, bounds, options, problem, fit)) continue;
      return;
    }
    Add(*found, problem);
    // The noise that the disturbance was taken for is sought anew.
    OutputFit again = fit;
    again.noise = EstimateNoise(problem, fit.point, fit.free, NoiseEstimate(),
                                options.estimate_drift,
                                options.robust_loss == RobustLoss::kNone);
    fit = Refit(problem, again, bounds, options);
  }
}

}  // namespace mle
