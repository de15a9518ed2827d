#include "apps/lifecycle/slow_disturbance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/random.h"

namespace mle::lifecycle {

SlowDisturbance::SlowDisturbance(std::uint64_t seed, Eigen::VectorXd deviation,
                                 double time, double sample_time)
    : seed_(seed),
      deviation_(std::move(deviation)),
      time_(time),
      sample_time_(sample_time),
      level_(deviation_.size()) {
  GaussianNoise source(seed_, kRunStream, kSlowDisturbance);
  for (Eigen::Index i = 0; i < level_.size(); ++i) {
    level_[i] = source.Draw(deviation_[i]);
  }
}

Eigen::MatrixXd SlowDisturbance::Draw(std::uint64_t stream, double start,
                                      int samples) const {
  GaussianNoise source(seed_, stream, kSlowDisturbance);
  Eigen::MatrixXd path(level_.size(), samples + 1);
  const auto step = [&](double time, const Eigen::VectorXd& from) {
    const double phi = std::exp(-time / time_);
    Eigen::VectorXd to = phi * from;
    for (Eigen::Index i = 0; i < to.size(); ++i) {
      to[i] += source.Draw(std::sqrt(1.0 - phi * phi) * deviation_[i]);
    }
    return to;
  };
  path.col(0) = step(std::max(start - level_time_, 0.0), level_);
  for (int k = 1; k <= samples; ++k) {
    path.col(k) = step(sample_time_, path.col(k - 1));
  }
  return path;
}

void SlowDisturbance::Keep(const Eigen::MatrixXd& path, double time) {
  level_ = path.rightCols<1>();
  level_time_ = time;
}

}  // namespace mle::lifecycle
