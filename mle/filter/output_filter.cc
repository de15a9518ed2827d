#include "mle/filter/output_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/filter/bias_filter.h"
#include "mle/filter/prediction_noise.h"
#include "mle/filter/residual_prediction.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kLongestHorizon = 1000;  // in control periods
// A filter is better where smaller errors are as likely by chance as this.
constexpr double kByChance = 0.05;

int CountMeasured(const std::vector<VectorXd>& residuals) {
  Index count = 0;
  for (const VectorXd& residual : residuals) {
    count += residual.array().isFinite().count();
  }
  return static_cast<int>(count);
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

// Blocks of what was held out.
struct HeldOutErrors {
  std::vector<SquaredErrors> in_use;
  std::vector<SquaredErrors> bias;
  std::vector<SquaredErrors> kalman;
};

// Adds those of a half that is predicted by the noise of the other.
void AddErrors(const std::vector<VectorXd>& half, const PredictionNoise& noise,
               const PredictionGrid& grid, double gain_in_use,
               HeldOutErrors& errors) {
  const DisturbanceSystem system = noise.Every(1);
  const StationaryFilter filter = SolveStationaryFilter(system);
  const double gain = BestBiasGain(noise.Every(grid.samples), grid.horizon);
  const auto append = [](const std::vector<SquaredErrors>& blocks,
                         std::vector<SquaredErrors>& all) {
    all.insert(all.end(), blocks.begin(), blocks.end());
  };
  for (const VectorXd& residual : half) {
    // Filters have forgotten how they began.
    const Index first = std::min<Index>(Index{grid.horizon} * grid.samples,
                                        residual.size() / 4);
    const Index last = residual.size();
    append(BiasErrors(residual, gain_in_use, grid, first, last), errors.in_use);
    append(BiasErrors(residual, gain, grid, first, last), errors.bias);
    append(KalmanErrors(residual, system, filter, grid, first, last),
           errors.kalman);
  }
}

// Student's test of differences of blocks, d̄ / √(s²/B) with B − 1 degrees of
// freedom, one-sided.
FilterForm Compare(const std::vector<SquaredErrors>& form,
                   const std::vector<SquaredErrors>& in_use) {
  FilterForm result{.error = std::sqrt(Together(form).mean())};
  VectorXd gains(static_cast<Index>(form.size()));
  Index blocks = 0;
  for (std::size_t b = 0; b < form.size(); ++b) {
    if (in_use[b].count > 0.0) {
      gains(blocks++) = in_use[b].mean() - form[b].mean();
    }
  }
  if (blocks < 2) return result;
  const auto count = static_cast<double>(blocks);
  const double mean = gains.head(blocks).mean();
  const double squares = (gains.head(blocks).array() - mean).square().sum();
  if (!(mean > 0.0)) return result;
  const double t = mean / std::sqrt(squares / (count * (count - 1.0)));
  result.better = StudentTail(t, count - 1.0) < kByChance;
  return result;
}

void FindFilter(const std::vector<VectorXd>& residuals, double sample_time,
                const PredictionGrid& grid, OutputFilter& filter) {
  const std::array<std::vector<VectorXd>, 2> halves = {HalfOf(residuals, 0),
                                                       HalfOf(residuals, 1)};
  std::array<PredictionNoise, 2> noises;
  for (int half = 0; half < 2; ++half) {
    noises[half] = EstimatePredictionNoise(halves[half], sample_time);
    if (!(noises[half].noise.variance > 0.0)) {
      filter.reason = absl::StrCat(
          "half of the records has fewer than ", kLeastNoiseSamples,
          " measured samples that the model can be compared with");
      return;
    }
  }
  if (!Varies(halves[0]) || !Varies(halves[1])) {
    filter.reason = "nothing disturbs the output in half of the records";
    return;
  }
  const PredictionNoise noise = EstimatePredictionNoise(residuals, sample_time);
  filter.noise = noise.noise;
  filter.walk_lag = noise.walk_lag;
  filter.stationary = SolveStationaryFilter(filter.Every(1));
  filter.bias_gain = BestBiasGain(filter.Every(grid.samples), grid.horizon);
  filter.bias_time_constant =
      filter.bias_gain < 1.0
          ? -grid.samples * sample_time / std::log1p(-filter.bias_gain)
          : 0.0;
  HeldOutErrors errors;
  for (int half = 0; half < 2; ++half) {
    AddErrors(halves[half], noises[1 - half], grid, filter.gain_in_use, errors);
  }
  const SquaredErrors in_use = Together(errors.in_use);
  if (!(in_use.count > 0.0)) {
    filter.reason = "the records are shorter than a control period";
    return;
  }
  filter.error_in_use = std::sqrt(in_use.mean());
  filter.kalman = Compare(errors.kalman, errors.in_use);
  filter.bias = Compare(errors.bias, errors.in_use);
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

namespace {

struct RunningFilter {
  DisturbanceSystem system;
  StateVector gain;
};

// A walk and noise, g² F and (1 − g) F, under which the gain in use is best;
// F is the variance of innovations.
RunningFilter InUse(const OutputFilter& filter, int samples) {
  const double kept =
      std::pow(1.0 - filter.gain_in_use,
               static_cast<double>(samples) / filter.samples_of_period);
  const double gain = 1.0 - kept;
  const double F = filter.stationary.innovation_variance;
  return {.system = {.A = StateMatrix::Ones(1, 1),
                     .C = StateRow::Ones(1),
                     .Q = StateMatrix::Constant(1, 1, gain * gain * F),
                     .noise_variance = kept * F},
          .gain = StateVector::Constant(1, gain)};
}

RunningFilter Running(const OutputFilter& filter, int samples) {
  if (!filter.kalman.better) return InUse(filter, samples);
  RunningFilter running = {.system = filter.Every(samples)};
  running.gain = SolveStationaryFilter(running.system).gain;
  return running;
}

}  // namespace

DisturbanceForm CombineFilters(const std::vector<OutputFilter>& filters,
                               int samples) {
  if (std::none_of(filters.begin(), filters.end(),
                   [](const auto& filter) { return filter.kalman.better; })) {
    return {};
  }
  const auto p = static_cast<Index>(filters.size());
  std::vector<RunningFilter> running(p);
  Index n = 0;
  for (Index i = 0; i < p; ++i) {
    if (!filters[i].estimated()) continue;
    running[i] = Running(filters[i], samples);
    n += running[i].gain.size();
  }
  DisturbanceForm form = {.A = MatrixXd::Zero(n, n),
                          .C = MatrixXd::Zero(p, n),
                          .K = MatrixXd::Zero(n, p),
                          .Q = MatrixXd::Zero(n, n),
                          .R = VectorXd::Zero(p)};
  Index at = 0;
  for (Index i = 0; i < p; ++i) {
    if (!filters[i].estimated()) continue;
    const auto& [system, gain] = running[i];
    const Index order = system.order();
    form.A.block(at, at, order, order) = system.A;
    form.C.block(i, at, 1, order) = system.C;
    form.K.block(at, i, order, 1) = gain;
    form.Q.block(at, at, order, order) = system.Q;
    form.R(i) = system.noise_variance;
    at += order;
  }
  return form;
}

}  // namespace mle
