// A bent, slow, limited or dead sensor of an output. With x = φ(p) + d, p the
// plant's output, d its disturbances, linear between samples, and T the
// sensor's lag,
//
//   T ẏ = x − y;
//
// white measurement noise is added to y. φ has the slope 1 at 0, the operating
// point: p + a p² (quadratic), ln(1 + a p)/a (logarithm), tanh(a p)/a (tanh).
// It stands for outputs that are no linear function of the plant's state too:
// compositions, pH. From `dead_from` on the sensor repeats
// what it measured last; what it shows stays in [min, max].

#ifndef SIM_SENSOR_H_
#define SIM_SENSOR_H_

#include <limits>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle::sim {

enum class OutputCurve { kNone, kQuadratic, kLogarithm, kTanh };

struct SensorOptions {
  int output = 0;
  OutputCurve curve = OutputCurve::kNone;
  double curvature = 0.0;  // a, in 1/unit, finite; 0: straight
  double lag = 0.0;        // T ≥ 0
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();  // ≥ min
  double noise_variance = 0.0;  // of white noise, beside that of the run, ≥ 0
  double dead_from = std::numeric_limits<double>::infinity();

  absl::Status Validate(int num_outputs) const;
};

// The response of a first-order lag of time constant T ≥ 0 to signals that are
// linear between samples, from the steady state of the first.
class Lag {
 public:
  Lag(double time_constant, double sample_time);

  double Follow(double signal);

 private:
  double memory_;  // of the response before
  double past_;    // of the signal before
  double signal_ = 0.0;
  double response_ = 0.0;
  bool started_ = false;
};

// The sensors of one run. For valid options.
class Sensors {
 public:
  Sensors(const std::vector<SensorOptions>& options, double sample_time);

  // Bends and lags the plant's outputs (p) of the next sample, in place.
  void Follow(Eigen::Ref<Eigen::VectorXd> outputs);
  // Lags whole disturbances (p × N), in place; they do not count as samples of
  // Follow.
  void FollowAll(Eigen::Ref<Eigen::MatrixXd> signals) const;
  // Replaces the outputs by what the sensors show of them, with noise, at
  // `time`; to be called for one sample after the other.
  void Show(double time, Eigen::Ref<Eigen::VectorXd> outputs);

 private:
  std::vector<SensorOptions> options_;
  double sample_time_;
  std::vector<Lag> lags_;
  std::vector<double> shown_;
};

}  // namespace mle::sim

#endif  // SIM_SENSOR_H_
