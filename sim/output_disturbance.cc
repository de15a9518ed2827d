#include "sim/output_disturbance.h"

#include <cmath>
#include <numbers>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"
#include "sim/coloured_noise.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool IsOff(const VectorXd& sizes) {
  return sizes.size() == 0 || sizes.maxCoeff() == 0.0;
}

MatrixXd DrawDrift(GaussianNoise source, const VectorXd& variance,
                   int samples) {
  MatrixXd walk =
      source.DrawMatrix(static_cast<int>(variance.size()), samples, 1.0);
  walk.col(0).setZero();
  for (int k = 1; k < samples; ++k) walk.col(k) += walk.col(k - 1);
  return variance.cwiseSqrt().asDiagonal() * walk;
}

MatrixXd DrawSteps(std::mt19937_64 when, GaussianNoise how_large,
                   const VectorXd& deviation, double probability, int samples) {
  const int p = static_cast<int>(deviation.size());
  MatrixXd level = MatrixXd::Zero(p, samples);
  for (int k = 1; k < samples; ++k) {
    level.col(k) = level.col(k - 1);
    for (int i = 0; i < p; ++i) {
      // Both are drawn always, so that neither moves the other's sequence.
      const double size = how_large.Draw(1.0);
      if (DrawUniform(when) < probability) level(i, k) += size;
    }
  }
  return deviation.asDiagonal() * level;
}

void AddSines(std::mt19937_64 phases, const std::vector<SineDisturbance>& sines,
              double sample_time, MatrixXd& disturbance) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (const SineDisturbance& sine : sines) {
    const double drawn = kTurn * DrawUniform(phases);
    const double phase = sine.phase.value_or(drawn);
    for (Eigen::Index k = 0; k < disturbance.cols(); ++k) {
      disturbance(sine.output, k) +=
          sine.amplitude *
          std::sin(
              kTurn *
                  std::fmod(static_cast<double>(k) * sample_time, sine.period) /
                  sine.period +
              phase);
    }
  }
}

absl::Status CheckOutput(int output, int num_outputs) {
  if (output >= 0 && output < num_outputs) return absl::OkStatus();
  return InvalidArgument("disturbance: output = ", output,
                         ", but it must be one of 0 … ", num_outputs - 1);
}

absl::Status CheckSingleOnes(const OutputDisturbanceOptions& options,
                             int num_outputs) {
  for (const ArmaDisturbance& arma : options.arma) {
    MLE_RETURN_IF_ERROR(CheckOutput(arma.output, num_outputs));
    MLE_RETURN_IF_ERROR(arma.noise.Validate());
  }
  for (const SineDisturbance& sine : options.sines) {
    MLE_RETURN_IF_ERROR(CheckOutput(sine.output, num_outputs));
    MLE_RETURN_IF_ERROR(CheckNotNegative("amplitude", sine.amplitude));
    MLE_RETURN_IF_ERROR(CheckPositive("period", sine.period));
    if (!std::isfinite(sine.phase.value_or(0.0))) {
      return absl::InvalidArgumentError("the phase of a sine is not finite");
    }
  }
  for (const OutputStep& one : options.steps) {
    MLE_RETURN_IF_ERROR(CheckOutput(one.output, num_outputs));
    MLE_RETURN_IF_ERROR(one.step.Validate());
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status OutputDisturbanceOptions::Validate(int num_outputs) const {
  MLE_RETURN_IF_ERROR(CheckNoneOrNotNegative("coloured_variance",
                                             coloured_variance, num_outputs));
  MLE_RETURN_IF_ERROR(
      CheckPositive("coloured_time_constant", coloured_time_constant));
  MLE_RETURN_IF_ERROR(
      CheckNoneOrNotNegative("drift_variance", drift_variance, num_outputs));
  MLE_RETURN_IF_ERROR(
      CheckNoneOrNotNegative("step_deviation", step_deviation, num_outputs));
  MLE_RETURN_IF_ERROR(CheckNotNegative("step_rate", step_rate));
  return CheckSingleOnes(*this, num_outputs);
}

MatrixXd DrawOutputDisturbance(const OutputDisturbanceOptions& options,
                               int num_outputs, double sample_time, int samples,
                               std::uint64_t seed, std::uint64_t stream) {
  MatrixXd disturbance = MatrixXd::Zero(num_outputs, samples);
  if (!IsOff(options.coloured_variance)) {
    GaussianNoise source(seed, stream, kColouredDisturbance);
    disturbance +=
        DrawColouredNoise(source, options.coloured_variance.cwiseSqrt(),
                          options.coloured_time_constant, sample_time, samples);
  }
  if (!IsOff(options.drift_variance)) {
    disturbance += DrawDrift(GaussianNoise(seed, stream, kDriftDisturbance),
                             options.drift_variance, samples);
  }
  if (!IsOff(options.step_deviation) && options.step_rate > 0.0) {
    disturbance += DrawSteps(
        SeededEngine(seed, stream, kStepTimes),
        GaussianNoise(seed, stream, kStepSizes), options.step_deviation,
        -std::expm1(-options.step_rate * sample_time), samples);
  }
  for (const ArmaDisturbance& arma : options.arma) {
    GaussianNoise source(seed, stream, kArmaNoise + arma.output);
    disturbance.row(arma.output) += DrawArmaNoise(source, arma.noise, samples);
  }
  AddSines(SeededEngine(seed, stream, kSinePhases), options.sines, sample_time,
           disturbance);
  for (const OutputStep& one : options.steps) {
    AddStep(one.step, sample_time, disturbance.row(one.output));
  }
  return disturbance;
}

}  // namespace mle::sim
