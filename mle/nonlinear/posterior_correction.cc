#include "mle/nonlinear/posterior_correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "mle/nonlinear/rational_fit.h"
#include "mle/nonlinear/shape_posterior.h"

namespace mle {
namespace {

// Share of the squares of an output that its noise must have.
constexpr double kLeastNoise = 1e-14;
// h lasts for dead time + this many time scales.
constexpr double kResponseTimeScales = 8.0;
// No lag is longer than this share of the shortest record.
constexpr double kMaxResponseLagShare = 0.5;
// The model's elements are fitted to step responses this many times as long.
constexpr int kHorizon = 2;
// h begins at this share of the dead time.
constexpr double kStartShare = 0.5;
// Ranges of lags an octave, in models of few and of many inputs.
constexpr int kFineRanges = 6;
constexpr int kCoarseRanges = 4;
constexpr int kFewInputs = 4;

double Deviation(const std::vector<Record>& records, int input) {
  double squares = 0.0;
  double samples = 0.0;
  for (const Record& record : records) {
    const auto row = record.inputs.row(input);
    double sum = 0.0;
    double count = 0.0;
    for (const double u : row) {
      if (!std::isfinite(u)) continue;
      sum += u;
      count += 1.0;
    }
    const double mean = sum / std::max(count, 1.0);
    for (const double u : row) {
      if (std::isfinite(u)) squares += (u - mean) * (u - mean);
    }
    samples += count;
  }
  return std::sqrt(squares / std::max(samples, 1.0));
}

// The priors of a row; an absent pair is measured by what its input would have
// to do to match the output's largest element.
std::vector<ElementPrior> PriorsOf(const OutputSetup& setup,
                                   const OutputPoint& fitted,
                                   const std::vector<double>& deviations,
                                   double sample_time) {
  const std::size_t m = setup.start.values.size();
  std::vector<ElementPrior> priors(m);
  double effect = 0.0;
  double time_scale = 0.0;
  for (std::size_t j = 0; j < m; ++j) {
    ElementPrior& prior = priors[j];
    prior.present = setup.problem->elements()[j].has_value();
    if (!prior.present) continue;
    prior.informed = setup.informed[j];
    prior.values = setup.start.values[j];
    prior.gain_scale = std::abs(prior.values.gain);
    prior.time_scale = prior.values.time_scale;
    prior.shape_scale =
        prior.gain_scale * (setup.problem->elements()[j]->is_integrating()
                                ? prior.time_scale
                                : 1.0);
    const double delay = std::min(prior.values.delay, fitted.values[j].delay);
    prior.first_lag = 1 + static_cast<int>(kStartShare * delay / sample_time);
    effect = std::max(effect, prior.shape_scale * deviations[j]);
    time_scale = std::max(time_scale, prior.time_scale);
  }
  for (std::size_t j = 0; j < m; ++j) {
    if (priors[j].present) continue;
    priors[j].informed = deviations[j] > 0.0 && effect > 0.0 &&
                         setup.problem->IsExcited(static_cast<int>(j));
    if (!priors[j].informed) continue;
    priors[j].shape_scale = effect / deviations[j];
    priors[j].time_scale = time_scale;
  }
  return priors;
}

OutputFit StartOf(const OutputSetup& setup, const OutputErrorFit& fit, int i) {
  const int m = fit.model.num_inputs();
  OutputFit start;
  start.point = setup.start;
  start.noise = fit.noise[i];
  start.free.assign(m, false);
  for (int j = 0; j < m; ++j) {
    const ElementEstimate& element = fit.element(i, j);
    if (element.state != ElementState::kFitted) continue;
    start.free[j] = true;
    ElementValues& values = start.point.values[j];
    values.gain = element.gain.value;
    values.delay = element.delay.value;
    if (setup.problem->elements()[j]->has_time_scale()) {
      values.time_scale = element.time_scale.value;
    }
  }
  start.point.SetCells(setup.problem->sample_time());
  return start;
}

// Quantities that the priors of all outputs share: ranges of lags of h, and the
// standard deviations of the inputs.
struct PriorFrame {
  std::vector<int> first_lags;
  std::vector<double> deviations;
};

PriorFrame FrameOf(const std::vector<OutputSetup>& setups,
                   const std::vector<Record>& windows) {
  const auto m = static_cast<int>(setups[0].start.values.size());
  PriorFrame frame;
  frame.first_lags = LagRanges(
      LongestLag(setups, windows, kResponseTimeScales, kMaxResponseLagShare),
      m <= kFewInputs ? kFineRanges : kCoarseRanges);
  for (int j = 0; j < m; ++j) frame.deviations.push_back(Deviation(windows, j));
  return frame;
}

// Exact data leave rounding, whose likelihood says nothing.
bool IsNoisy(const OutputSetup& setup, const NoiseEstimate& noise) {
  return setup.problem->num_samples() * noise.variance >
         kLeastNoise * setup.problem->total_squares();
}

double Probability(double evidence) {
  return 1.0 / (1.0 + std::exp(-0.5 * evidence));
}

OutputShapes ShapesOf(const OutputPosterior& found,
                      const std::vector<ElementPrior>& priors) {
  OutputShapes shapes;
  shapes.needed = found.HasShape();
  if (!shapes.needed) return shapes;
  shapes.noise = found.noise;
  shapes.decay = found.decay;
  shapes.first_lags = found.first_lags;
  const auto m = static_cast<Eigen::Index>(priors.size());
  const auto ranges = static_cast<Eigen::Index>(found.first_lags.size()) - 1;
  for (Eigen::Index j = 0; j < m; ++j) {
    std::vector<int> own;
    for (int i = 0; i < 3; ++i) own.push_back(static_cast<int>(3 * j) + i);
    for (Eigen::Index b = 0; b < ranges; ++b) {
      own.push_back(static_cast<int>(3 * m + j * ranges + b));
    }
    ElementPosterior element;
    element.reshaped = found.choices[j].shape > 0.0;
    element.changed = element.reshaped || found.choices[j].parameters;
    element.change_probability =
        element.changed ? Probability(found.change_evidence[j]) : 0.0;
    element.shape_probability =
        element.reshaped ? Probability(found.shape_evidence[j]) : 0.0;
    element.values = found.point.values[j];
    if (priors[j].present) element.initial = priors[j].values;
    element.time_unit = priors[j].time_scale;
    element.shape_scale = found.choices[j].shape;
    element.means = found.means(own);
    element.covariance = found.covariance(own, own);
    shapes.elements.push_back(std::move(element));
    shapes.starts.push_back(priors[j].first_lag);
  }
  return shapes;
}

}  // namespace

bool PosteriorCorrection::any() const {
  return std::any_of(outputs.begin(), outputs.end(),
                     [](const OutputShapes& o) { return o.needed; });
}

absl::StatusOr<PosteriorCorrection> CompleteByPosterior(
    const ProcessModel& initial, const std::vector<Record>& windows,
    const OutputErrorFit& output_error, const OutputErrorOptions& options,
    const std::vector<bool>& outputs) {
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(initial, windows, options));
  const int p = initial.num_outputs();
  const int m = initial.num_inputs();
  PosteriorCorrection posterior;
  posterior.model = output_error.model;
  posterior.sample_time = windows[0].sample_time;
  posterior.outputs.resize(p);
  const PriorFrame frame = FrameOf(setups, windows);
  ParallelFor(p, options.threads, [&](int i) {
    if (!outputs.empty() && !outputs[i]) return;
    if (!IsNoisy(setups[i], output_error.noise[i])) return;
    AdoptDisturbances(output_error.noise[i], *setups[i].problem);
    const OutputFit start = StartOf(setups[i], output_error, i);
    const std::vector<ElementPrior> priors = PriorsOf(
        setups[i], start.point, frame.deviations, posterior.sample_time);
    posterior.outputs[i] =
        ShapesOf(FindPosterior(*setups[i].problem, priors, frame.first_lags,
                               setups[i].bounds, start, options.estimate_drift),
                 priors);
  });
  const std::vector<int>& first_lags = frame.first_lags;
  // To where the parametric part has settled, too.
  const int samples = kHorizon * first_lags.back() + 1;
  for (int i = 0; i < p; ++i) {
    OutputShapes& shapes = posterior.outputs[i];
    for (int j = 0; shapes.needed && j < m; ++j) {
      ElementPosterior& element = shapes.elements[j];
      TransferFunction& own = posterior.model.element(i, j);
      own = initial.element(i, j);
      if (!element.changed) continue;
      if (!element.reshaped) {
        MLE_ASSIGN_OR_RETURN(const ElementResponse response,
                             ElementResponse::Create(own));
        own = response.ToTransferFunction(
            {element.MeanGain(),
             element.values.time_scale * std::exp(element.means(1)),
             std::max(element.values.delay + element.means(2), 0.0)});
        continue;
      }
      RationalOptions rational;
      if (initial.element(i, j).IsIntegrating()) {
        rational.slope = element.MeanGain();
      }
      rational.min_delay = (shapes.starts[j] - 1) * posterior.sample_time;
      rational.max_delay = std::max(rational.min_delay, element.values.delay);
      MLE_ASSIGN_OR_RETURN(
          RationalFit fit,
          FitRational(posterior.MeanStep(initial, i, j, samples),
                      posterior.sample_time, rational));
      own = std::move(fit.element);
      element.reduction_error = fit.relative_error;
    }
  }
  return posterior;
}

}  // namespace mle
