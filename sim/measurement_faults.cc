#include "sim/measurement_faults.h"

#include <cmath>
#include <limits>

#include "mle/base/random.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSmallestOutlier = 0.2;  // of the largest

MatrixXd DrawOutliers(const VectorXd& size, double probability, int samples,
                      std::mt19937_64 engine) {
  const int p = static_cast<int>(size.size());
  MatrixXd outliers = MatrixXd::Zero(p, samples);
  for (int k = 0; k < samples; ++k) {
    for (int i = 0; i < p; ++i) {
      const bool happens = DrawUniform(engine) < probability;
      const double part =
          kSmallestOutlier + (1.0 - kSmallestOutlier) * DrawUniform(engine);
      const double sign = DrawUniform(engine) < 0.5 ? -1.0 : 1.0;
      if (happens) outliers(i, k) = sign * part * size[i];
    }
  }
  return outliers;
}

}  // namespace

absl::Status MeasurementFaultOptions::Validate(int num_outputs) const {
  MLE_RETURN_IF_ERROR(
      CheckProbability("outlier_probability", outlier_probability));
  MLE_RETURN_IF_ERROR(
      CheckNoneOrNotNegative("outlier_size", outlier_size, num_outputs));
  MLE_RETURN_IF_ERROR(CheckNoneOrNotNegative("quantum", quantum, num_outputs));
  MLE_RETURN_IF_ERROR(CheckNotNegative("freeze_rate", freeze_rate));
  MLE_RETURN_IF_ERROR(CheckPositive("freeze_duration", freeze_duration));
  MLE_RETURN_IF_ERROR(CheckProbability("lost_probability", lost_probability));
  return CheckProbability("lost_input_probability", lost_input_probability);
}

MeasurementFaults::MeasurementFaults(const MeasurementFaultOptions& options,
                                     int num_outputs, int num_inputs,
                                     double sample_time, int samples,
                                     std::uint64_t seed, std::uint64_t stream)
    : quantum_(options.quantum), last_(VectorXd::Zero(num_outputs)) {
  if (options.outlier_probability > 0.0 && options.outlier_size.size() != 0) {
    outliers_ = DrawOutliers(options.outlier_size, options.outlier_probability,
                             samples, SeededEngine(seed, stream, kOutliers));
  }
  if (options.freeze_rate > 0.0) {
    frozen_ =
        DrawFrozen(options, num_outputs, sample_time, samples, seed, stream);
  }
  lost_outputs_ = DrawLost(num_outputs, samples, options.lost_probability, seed,
                           stream, kLostOutputs);
  lost_inputs_ = DrawLost(num_inputs, samples, options.lost_input_probability,
                          seed, stream, kLostInputs);
}

MeasurementFaults::Mask MeasurementFaults::DrawLost(int rows, int samples,
                                                    double probability,
                                                    std::uint64_t seed,
                                                    std::uint64_t stream,
                                                    std::uint32_t substream) {
  if (probability == 0.0) return {};
  std::mt19937_64 engine = SeededEngine(seed, stream, substream);
  Mask lost(rows, samples);
  for (int k = 0; k < samples; ++k) {
    for (int i = 0; i < rows; ++i)
      lost(i, k) = DrawUniform(engine) < probability;
  }
  return lost;
}

MeasurementFaults::Mask MeasurementFaults::DrawFrozen(
    const MeasurementFaultOptions& options, int num_outputs, double sample_time,
    int samples, std::uint64_t seed, std::uint64_t stream) {
  std::mt19937_64 engine = SeededEngine(seed, stream, kFrozenChannels);
  const double probability = -std::expm1(-options.freeze_rate * sample_time);
  Mask frozen = Mask::Constant(num_outputs, samples, false);
  VectorXd left = VectorXd::Zero(num_outputs);  // time until it thaws
  for (int k = 0; k < samples; ++k) {
    for (int i = 0; i < num_outputs; ++i) {
      const bool starts = DrawUniform(engine) < probability;
      const double duration =
          -options.freeze_duration * std::log1p(-DrawUniform(engine));
      left[i] -= sample_time;
      // There is nothing to repeat at the first sample.
      if (starts && k > 0) left[i] = std::max(left[i], duration);
      frozen(i, k) = left[i] > 0.0;
    }
  }
  return frozen;
}

void MeasurementFaults::SpoilOutputs(int k,
                                     Eigen::Ref<Eigen::VectorXd> outputs) {
  for (Eigen::Index i = 0; i < outputs.size(); ++i) {
    double& value = outputs[i];
    if (frozen_.size() != 0 && frozen_(i, k)) {
      value = last_[i];
    } else {
      if (outliers_.size() != 0) value += outliers_(i, k);
      if (quantum_.size() != 0 && quantum_[i] > 0.0) {
        value = quantum_[i] * std::round(value / quantum_[i]);
      }
    }
    last_[i] = value;
    if (lost_outputs_.size() != 0 && lost_outputs_(i, k)) {
      value = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

void MeasurementFaults::SpoilInputs(int k,
                                    Eigen::Ref<Eigen::VectorXd> inputs) const {
  if (lost_inputs_.size() == 0) return;
  for (Eigen::Index j = 0; j < inputs.size(); ++j) {
    if (lost_inputs_(j, k))
      inputs[j] = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace mle::sim
