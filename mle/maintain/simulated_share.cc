#include "mle/maintain/simulated_share.h"

#include <algorithm>
#include <cstddef>

namespace mle {
namespace {

constexpr Eigen::Index kMove = 20;  // samples

// The sum of squares about a straight line.
double AboutTrend(Eigen::VectorXd values) {
  const Eigen::Index n = values.size();
  if (n < 3) return 0.0;
  values.array() -= values.mean();
  const double half = static_cast<double>(n - 1) / 2.0;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(n, -half, half);
  values -= times * (times.dot(values) / times.squaredNorm());
  return values.squaredNorm();
}

Eigen::VectorXd Moves(const Eigen::VectorXd& values) {
  const Eigen::Index n = std::max<Eigen::Index>(values.size() - kMove, 0);
  return values.tail(n) - values.head(n);
}

}  // namespace

double SimulatedShare(const std::vector<Eigen::VectorXd>& outputs,
                      const std::vector<Eigen::VectorXd>& responses) {
  double left = 0.0;
  double all = 0.0;
  for (std::size_t w = 0; w < outputs.size(); ++w) {
    left += AboutTrend(outputs[w] - responses[w]);
    all += AboutTrend(outputs[w]);
  }
  return all > 0.0 ? 1.0 - left / all : 0.0;
}

double SimulatedShareOfIncrements(
    const std::vector<Eigen::VectorXd>& outputs,
    const std::vector<Eigen::VectorXd>& responses) {
  std::vector<Eigen::VectorXd> moves;
  std::vector<Eigen::VectorXd> expected;
  for (std::size_t w = 0; w < outputs.size(); ++w) {
    moves.push_back(Moves(outputs[w]));
    expected.push_back(Moves(responses[w]));
  }
  return SimulatedShare(moves, expected);
}

}  // namespace mle
