#include "mle/data/line.h"

namespace mle {

Eigen::VectorXd WithoutLine(const Eigen::VectorXd& values) {
  const Eigen::Index n = values.size();
  const Eigen::Array<bool, Eigen::Dynamic, 1> known = values.array().isFinite();
  const auto count = static_cast<double>(known.count());
  if (count == 0.0) return values;
  const Eigen::ArrayXd times =
      Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1));
  const double mean_time = known.select(times, 0.0).sum() / count;
  const double mean = known.select(values.array(), 0.0).sum() / count;
  const Eigen::ArrayXd centred = known.select(times - mean_time, 0.0);
  const double squares = centred.square().sum();
  const double products =
      (centred * known.select(values.array() - mean, 0.0)).sum();
  const double slope = squares > 0.0 ? products / squares : 0.0;
  return values.array() - mean - slope * (times - mean_time);
}

}  // namespace mle
