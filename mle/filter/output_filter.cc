#include "mle/filter/output_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/data/record.h"
#include "mle/filter/bias_filter.h"
#include "mle/filter/residual_prediction.h"
#include "mle/nonlinear/colour_search.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kLongestHorizon = 1000;  // in control periods
// A noise has four parameters and an offset.
constexpr int kLeastSamples = 50;
constexpr int kLeastRun = 20;

int CountMeasured(const std::vector<VectorXd>& residuals) {
  Index count = 0;
  for (const VectorXd& residual : residuals) {
    count += residual.array().isFinite().count();
  }
  return static_cast<int>(count);
}

// The class is the one that predicts best: by Akaike's criterion, two for each
// parameter, where an explanation would ask for more (noise_search.h).
Profile LikeliestForPrediction(const ShapeLikelihood& likelihood) {
  constexpr double kPrice = 2.0;
  const Profile walk = FindBestShape(likelihood, NoiseShape(),
                                     /*estimate_drift=*/true,
                                     /*search_colour=*/false);
  Profile best = walk;
  double least = walk.value;
  for (const int order : {1, 2}) {
    const Profile coloured = FindBestColour(likelihood, order, walk);
    const double value = coloured.value + kPrice * (order + 1);
    if (!(value < least)) continue;
    least = value;
    best = coloured;
  }
  return best;
}

// Of a filter with given gains the mean squared error is linear in the
// variances, so that the gains best under what the records leave open are those
// of the mean variances. Of the walk that differs from the likeliest, which
// often is none, while a drift that is not followed costs without bound.
NoiseShape WithMeanRatio(const ShapeLikelihood& likelihood,
                         const NoiseShape& shape) {
  std::vector<double> values;
  const std::vector<PossibleRatio> ratios =
      PossibleRatios(likelihood.problem());
  NoiseShape at = shape;
  for (const PossibleRatio& possible : ratios) {
    at.ratio = possible.ratio;
    values.push_back(likelihood.At(at).value);
  }
  const double least = *std::min_element(values.begin(), values.end());
  double sum = 0.0;
  double mean = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double weight =
        ratios[i].prior * std::exp(-0.5 * (values[i] - least));
    sum += weight;
    mean += weight * ratios[i].ratio;
  }
  at.ratio = mean / sum;
  return at;
}

// The noise of one output.
NoiseEstimate NoiseOf(const std::vector<VectorXd>& residuals,
                      double sample_time) {
  std::vector<Record> records;
  Index longest = 1;
  for (const VectorXd& residual : residuals) {
    records.push_back({.sample_time = sample_time,
                       .outputs = residual.transpose(),
                       .inputs = MatrixXd(0, residual.size())});
    longest = std::max(longest, residual.size());
  }
  const OutputErrorProblem problem({}, records, /*output=*/0, /*skip=*/0,
                                   kLeastRun);
  if (problem.num_samples() < kLeastSamples) return {};
  const ShapeLikelihood likelihood(problem, OutputPoint(), {}, NoiseShape(),
                                   /*restricted=*/true);
  const Profile best = LikeliestForPrediction(likelihood);
  const Profile drifting = likelihood.At(WithMeanRatio(likelihood, best.shape));
  NoiseEstimate noise;
  noise.variance = drifting.variance();
  noise.ratio = drifting.shape.ratio;
  noise.colour_ratio = best.shape.colour_ratio;
  noise.colour_pole = best.shape.colour_pole;
  noise.colour_damping = best.shape.colour_damping;
  // Less drift cannot be seen in a record; with none, a constant disturbance
  // would never be followed.
  const auto length = static_cast<double>(longest);
  noise.ratio = std::max(noise.ratio, 1.0 / (length * length));
  return noise;
}

bool Varies(const std::vector<VectorXd>& residuals) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const VectorXd& residual : residuals) {
    for (const double value : residual) {
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  return most > least;
}

// The samples of a half, of all records joined.
std::vector<VectorXd> HalfOf(const std::vector<VectorXd>& residuals, int half) {
  Index total = 0;
  for (const VectorXd& residual : residuals) total += residual.size();
  std::vector<VectorXd> parts;
  Index before = 0;
  for (const VectorXd& residual : residuals) {
    const Index split =
        std::clamp<Index>(total / 2 - before, 0, residual.size());
    const Index count = half == 0 ? split : residual.size() - split;
    if (count > 0) {
      parts.emplace_back(half == 0 ? residual.head(count)
                                   : residual.tail(count));
    }
    before += residual.size();
  }
  return parts;
}

struct HalfErrors {
  SquaredErrors in_use;
  SquaredErrors bias;
  SquaredErrors kalman;
};

// Of a half that is predicted by the noise of the other.
HalfErrors ErrorsOf(const std::vector<VectorXd>& half,
                    const NoiseEstimate& noise, const PredictionGrid& grid,
                    double gain_in_use) {
  const DisturbanceSystem system = SystemOf(noise, 1);
  const StationaryFilter filter = SolveStationaryFilter(system);
  const double gain = BestBiasGain(SystemOf(noise, grid.samples), grid.horizon);
  HalfErrors errors;
  for (const VectorXd& residual : half) {
    // Filters have forgotten how they began.
    const Index first = std::min<Index>(Index{grid.horizon} * grid.samples,
                                        residual.size() / 4);
    const Index last = residual.size();
    errors.in_use.Add(BiasErrors(residual, gain_in_use, grid, first, last));
    errors.bias.Add(BiasErrors(residual, gain, grid, first, last));
    errors.kalman.Add(
        KalmanErrors(residual, system, filter, grid, first, last));
  }
  return errors;
}

FilterForm Compare(const std::array<HalfErrors, 2>& halves,
                   SquaredErrors HalfErrors::*form) {
  FilterForm result;
  result.better = true;
  SquaredErrors all;
  for (const HalfErrors& half : halves) {
    const SquaredErrors& errors = half.*form;
    all.Add(errors);
    if (!(errors.sum < half.in_use.sum)) result.better = false;
  }
  result.error = std::sqrt(all.mean());
  return result;
}

void FindFilter(const std::vector<VectorXd>& residuals, double sample_time,
                const PredictionGrid& grid, OutputFilter& filter) {
  const std::array<std::vector<VectorXd>, 2> halves = {HalfOf(residuals, 0),
                                                       HalfOf(residuals, 1)};
  std::array<NoiseEstimate, 2> noises;
  for (int half = 0; half < 2; ++half) {
    noises[half] = NoiseOf(halves[half], sample_time);
    if (!(noises[half].variance > 0.0)) {
      filter.reason =
          absl::StrCat("half of the records has fewer than ", kLeastSamples,
                       " measured samples that the model can be compared with");
      return;
    }
  }
  if (!Varies(halves[0]) || !Varies(halves[1])) {
    filter.reason = "nothing disturbs the output in half of the records";
    return;
  }
  filter.noise = NoiseOf(residuals, sample_time);
  filter.system = SystemOf(filter.noise, 1);
  filter.stationary = SolveStationaryFilter(filter.system);
  filter.bias_gain =
      BestBiasGain(SystemOf(filter.noise, grid.samples), grid.horizon);
  filter.bias_time_constant =
      filter.bias_gain < 1.0
          ? -grid.samples * sample_time / std::log1p(-filter.bias_gain)
          : 0.0;
  std::array<HalfErrors, 2> errors;
  SquaredErrors in_use;
  for (int half = 0; half < 2; ++half) {
    errors[half] =
        ErrorsOf(halves[half], noises[1 - half], grid, filter.gain_in_use);
    in_use.Add(errors[half].in_use);
  }
  if (!(in_use.count > 0.0)) {
    filter.reason = "the records are shorter than a control period";
    return;
  }
  filter.error_in_use = std::sqrt(in_use.mean());
  filter.kalman = Compare(errors, &HalfErrors::kalman);
  filter.bias = Compare(errors, &HalfErrors::bias);
}

}  // namespace

absl::Status FilterOptions::Validate() const {
  const auto not_negative = [](const char* field, double value) {
    return value >= 0.0 && std::isfinite(value)
               ? absl::OkStatus()
               : InvalidArgument(field, " = ", value,
                                 ": it must be finite and ≥ 0");
  };
  MLE_RETURN_IF_ERROR(not_negative("filter.control_period", control_period));
  MLE_RETURN_IF_ERROR(not_negative("filter.horizon", horizon));
  for (const double gain : gains_in_use) {
    if (gain > 0.0 && gain <= 1.0) continue;
    return InvalidArgument("filter.gains_in_use has ", gain,
                           ": each must be > 0 and ≤ 1");
  }
  return absl::OkStatus();
}

std::vector<OutputFilter> FindFilters(const std::vector<MatrixXd>& residuals,
                                      double sample_time,
                                      const std::vector<bool>& integrating,
                                      double settling_time,
                                      const FilterOptions& options,
                                      int threads) {
  PredictionGrid grid;
  grid.samples = static_cast<int>(
      std::clamp(std::round(options.control_period / sample_time), 1.0, 1e6));
  const double horizon =
      options.horizon > 0.0 ? options.horizon : settling_time;
  grid.horizon = static_cast<int>(
      std::clamp(std::round(horizon / (grid.samples * sample_time)), 1.0,
                 static_cast<double>(kLongestHorizon)));
  const auto p = static_cast<int>(integrating.size());
  std::vector<OutputFilter> filters(p);
  ParallelFor(p, threads, [&](int i) {
    OutputFilter& filter = filters[i];
    filter.samples_of_period = grid.samples;
    filter.horizon = grid.horizon;
    if (i < options.gains_in_use.size()) {
      filter.gain_in_use = options.gains_in_use(i);
    }
    if (integrating[i]) {
      filter.reason = "the output integrates";
      return;
    }
    std::vector<VectorXd> of_output;
    for (const MatrixXd& residual : residuals) {
      of_output.push_back(residual.row(i).transpose());
    }
    if (CountMeasured(of_output) == 0) {
      filter.reason = "the output is not measured";
      return;
    }
    FindFilter(of_output, sample_time, grid, filter);
  });
  return filters;
}

DisturbanceForm CombineFilters(const std::vector<OutputFilter>& filters) {
  Index n = 0;
  for (const OutputFilter& filter : filters) {
    if (filter.kalman.better) n += filter.system.order();
  }
  DisturbanceForm form;
  if (n == 0) return form;
  const auto p = static_cast<Index>(filters.size());
  form.A = MatrixXd::Zero(n, n);
  form.C = MatrixXd::Zero(p, n);
  form.K = MatrixXd::Zero(n, p);
  form.Q = MatrixXd::Zero(n, n);
  form.R = VectorXd::Zero(p);
  Index at = 0;
  for (Index i = 0; i < p; ++i) {
    const OutputFilter& filter = filters[i];
    if (!filter.kalman.better) continue;
    const Index order = filter.system.order();
    form.A.block(at, at, order, order) = filter.system.A;
    form.C.block(i, at, 1, order) = filter.system.C;
    form.K.block(at, i, order, 1) = filter.stationary.gain;
    form.Q.block(at, at, order, order) = filter.system.Q;
    form.R(i) = filter.system.noise_variance;
    at += order;
  }
  return form;
}

}  // namespace mle
