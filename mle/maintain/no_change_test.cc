#include "mle/maintain/no_change_test.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/maintain/stage.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/ar_component.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

constexpr int kDegreesOfReplicates = 12;
constexpr int kFewestReplicates = 3;

// Sines of the lines' size with amplitudes and phases of their own.
Eigen::RowVectorXd DrawLines(const std::vector<PeriodicLine>& lines,
                             double sample_time, int samples,
                             GaussianNoise& random) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(samples);
  for (const PeriodicLine& line : lines) {
    const double cosine = random.Draw(line.amplitude / std::sqrt(2.0));
    const double sine = random.Draw(line.amplitude / std::sqrt(2.0));
    for (int k = 0; k < samples; ++k) {
      const double angle = 2.0 * M_PI * k * sample_time / line.period;
      sum(k) += cosine * std::cos(angle) + sine * std::sin(angle);
    }
  }
  return sum;
}

double StepsAt(const std::vector<LevelStep>& steps, std::size_t window, int k,
               const Record& record) {
  double sum = 0.0;
  for (const LevelStep& step : steps) {
    if (step.record != static_cast<int>(window)) continue;
    sum +=
        step.At(record.start_time + k * record.sample_time, record.sample_time);
  }
  return sum;
}

// `responses` of the initial model under noise of the plant's size, bad where
// `windows` are.
std::vector<Record> DrawRecords(const std::vector<Record>& windows,
                                const std::vector<Eigen::MatrixXd>& responses,
                                const std::vector<NoiseEstimate>& noise,
                                std::uint64_t seed, int replicate) {
  const std::uint64_t stream =
      kCalibrationStream + static_cast<std::uint64_t>(replicate);
  GaussianNoise white(seed, stream, kMeasurementNoise);
  GaussianNoise walk(seed, stream, kDriftDisturbance);
  GaussianNoise ar(seed, stream, kColouredDisturbance);
  std::vector<Record> drawn = windows;
  for (std::size_t w = 0; w < drawn.size(); ++w) {
    Record& record = drawn[w];
    for (int i = 0; i < record.num_outputs(); ++i) {
      const double deviation = std::sqrt(noise[i].variance);
      const double step = std::sqrt(noise[i].increment_variance());
      double level = 0.0;
      ArSignal coloured(ArComponent(noise[i].ar_pole, noise[i].ar_damping),
                        noise[i].ar_ratio * noise[i].variance, ar);
      const Eigen::RowVectorXd periodic =
          DrawLines(noise[i].lines, record.sample_time, record.samples(), ar);
      for (int k = 0; k < record.samples(); ++k) {
        const double value =
            responses[w](i, k) + level + coloured.value() + periodic(k) +
            StepsAt(noise[i].steps, w, k, record) + white.Draw(deviation);
        level += walk.Draw(step);
        coloured.Advance();
        if (std::isfinite(record.outputs(i, k))) record.outputs(i, k) = value;
      }
    }
  }
  return drawn;
}

int ReplicatesFor(const NullCalibrationOptions& calibration, int degrees) {
  const int enough =
      (calibration.replicates * kDegreesOfReplicates + degrees - 1) / degrees;
  return std::min(calibration.replicates, std::max(enough, kFewestReplicates));
}

}  // namespace

absl::Status NullCalibrationOptions::Validate() const {
  if (replicates < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "calibration.replicates = ", replicates, ": it must be at least 1"));
  }
  if (!(doubt >= 1.0) || !std::isfinite(doubt)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "calibration.doubt = ", doubt, ": it must be finite and at least 1"));
  }
  return absl::OkStatus();
}

absl::StatusOr<NullCalibration> CalibrateTest(
    const ProcessModel& initial, const std::vector<Record>& windows,
    const OutputErrorCorrection& test, const OutputErrorOptions& options,
    const NullCalibrationOptions& calibration,
    const ProgressCallback& progress) {
  NullCalibration result;
  result.p_value = test.p_value;
  const int degrees = test.degrees_of_freedom;
  if (!test.change_proposed || degrees == 0 ||
      ChiSquareTail(test.statistic / calibration.doubt, degrees) <
          options.false_alarm_probability) {
    return result;
  }
  const int replicates = ReplicatesFor(calibration, degrees);
  std::vector<Eigen::MatrixXd> responses;
  for (const Record& window : windows) {
    MLE_ASSIGN_OR_RETURN(
        Eigen::MatrixXd response,
        SimulateResponse(initial, window.sample_time, window.inputs));
    responses.push_back(std::move(response));
  }
  OutputErrorOptions one = options;
  one.threads = 1;
  one.false_alarm_probability = kNoFalseAlarm;  // the statistic alone is wanted
  Stage simulating(progress, "calibrating the test of no change", replicates);
  std::vector<absl::Status> status(replicates);
  std::vector<double> statistics(replicates);
  ParallelFor(replicates, options.threads, [&](int b) {
    if (simulating.cancelled()) return;
    const absl::StatusOr<OutputErrorCorrection> fit = CorrectByOutputError(
        initial,
        DrawRecords(windows, responses, test.full.noise, calibration.seed, b),
        one);
    status[b] = fit.status();
    if (fit.ok()) statistics[b] = fit->statistic;
    simulating.Done();
  });
  MLE_RETURN_IF_ERROR(simulating.status());
  double sum = 0.0;
  for (int b = 0; b < replicates; ++b) {
    MLE_RETURN_IF_ERROR(status[b]);
    sum += statistics[b];
  }
  result.replicates = replicates;
  result.factor = std::max(1.0, sum / replicates / degrees);
  result.p_value = ChiSquareTail(test.statistic / result.factor, degrees);
  return result;
}

}  // namespace mle
