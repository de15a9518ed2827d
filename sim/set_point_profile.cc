#include "sim/set_point_profile.h"

#include <algorithm>
#include <cmath>

#include "mle/base/random.h"
#include "mle/base/status.h"

namespace mle::sim {

absl::Status SetPointProfile::Validate(int num_outputs) const {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const SetPointStep& step = steps[i];
    if (step.output < 0 || step.output >= num_outputs) {
      return InvalidArgument("set-point step ", i + 1,
                             ": output = ", step.output,
                             ", but it must be one of 0 … ", num_outputs - 1);
    }
    if (!std::isfinite(step.time) || !std::isfinite(step.value)) {
      return InvalidArgument("set-point step ", i + 1, ": time = ", step.time,
                             ", value = ", step.value,
                             ", but both must be finite");
    }
  }
  for (const SetPointMove& move : moves) {
    if (move.output < 0 || move.output >= num_outputs) {
      return InvalidArgument("set-point move: output = ", move.output,
                             ", but it must be one of 0 … ", num_outputs - 1);
    }
    MLE_RETURN_IF_ERROR(move.change.Validate());
  }
  return absl::OkStatus();
}

Eigen::MatrixXd SetPointProfile::Sample(int num_outputs, double sample_time,
                                        int samples) const {
  std::vector<SetPointStep> ordered = steps;
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const SetPointStep& a, const SetPointStep& b) {
                     return a.time < b.time;
                   });
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(num_outputs, samples);
  for (const SetPointStep& step : ordered) {
    const double first = std::ceil(step.time / sample_time - 1e-9);
    if (first >= samples) continue;
    const int k = static_cast<int>(std::max(0.0, first));
    values.row(step.output).tail(samples - k).setConstant(step.value);
  }
  for (const SetPointMove& move : moves) {
    AddStep(move.change, sample_time, values.row(move.output));
  }
  return values;
}

SetPointProfile ProfileOf(const Eigen::MatrixXd& set_points,
                          double sample_time) {
  SetPointProfile profile;
  for (Eigen::Index k = 0; k < set_points.cols(); ++k) {
    for (Eigen::Index i = 0; i < set_points.rows(); ++i) {
      const double before = k == 0 ? 0.0 : set_points(i, k - 1);
      if (set_points(i, k) == before) continue;
      profile.steps.push_back({static_cast<int>(i),
                               sample_time * static_cast<double>(k),
                               set_points(i, k)});
    }
  }
  return profile;
}

std::vector<SetPointMove> DrawOptimiserMoves(int output, double interval,
                                             double deviation, double duration,
                                             std::uint64_t seed,
                                             std::uint64_t stream) {
  GaussianNoise source(seed, stream, kOptimiserMoves + output);
  std::vector<SetPointMove> moves;
  double distance = 0.0;
  for (int i = 1; i * interval < duration; ++i) {
    const double next = source.Draw(deviation);
    moves.push_back({output, {.time = i * interval, .size = next - distance}});
    distance = next;
  }
  return moves;
}

}  // namespace mle::sim
