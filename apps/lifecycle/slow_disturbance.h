// A slow disturbance of each output, one stationary path over all years:
//
//   d_{k+1} = φ d_k + √(1−φ²) s e_k,   φ = exp(−Δt/T),
//
// drawn stretch by stretch; the time between stretches is skipped in one
// step. It depends on the seed and the streams alone.

#ifndef APPS_LIFECYCLE_SLOW_DISTURBANCE_H_
#define APPS_LIFECYCLE_SLOW_DISTURBANCE_H_

#include <cstdint>

#include "Eigen/Core"

namespace mle::lifecycle {

class SlowDisturbance {
 public:
  // `deviation` s ≥ 0 (p), `time` T > 0, `sample_time` Δt > 0.
  SlowDisturbance(std::uint64_t seed, Eigen::VectorXd deviation, double time,
                  double sample_time);

  // The path from `start` on: p × (samples + 1). The last value that was kept
  // is where it comes from.
  Eigen::MatrixXd Draw(std::uint64_t stream, double start, int samples) const;

  // What `path` ends at was at `time`.
  void Keep(const Eigen::MatrixXd& path, double time);

 private:
  std::uint64_t seed_;
  Eigen::VectorXd deviation_;
  double time_;
  double sample_time_;
  Eigen::VectorXd level_;  // at level_time_
  double level_time_ = 0.0;
};

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SLOW_DISTURBANCE_H_
