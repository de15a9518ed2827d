#include "mle/regression/lasso_path.h"

#include <cstddef>

#include "glog/logging.h"

namespace mle {
namespace {

constexpr std::size_t kBlock = 1 << 14;  // coefficients

}  // namespace

int LassoPath::FindSegment(double lambda) const {
  if (segments_.empty() || lambda > segments_.front().lambda_begin) return -1;
  const auto it = std::lower_bound(
      segments_.begin(), segments_.end(), lambda,
      [](const Segment& s, double value) { return s.lambda_end >= value; });
  return static_cast<int>(std::min(it, segments_.end() - 1) -
                          segments_.begin());
}

void LassoPath::Coefficients(double lambda,
                             Eigen::Ref<Eigen::VectorXd> beta) const {
  CHECK_EQ(beta.size(), size_);
  beta.setZero();
  VisitCoefficients(lambda, [&](int j, double value) { beta(j) = value; });
}

Eigen::VectorXd LassoPath::Coefficients(double lambda) const {
  Eigen::VectorXd beta(size_);
  Coefficients(lambda, beta);
  return beta;
}

void LassoPath::Append(double lambda_begin, double lambda_end,
                       const std::vector<int>& active,
                       const Eigen::Ref<const Eigen::VectorXd>& start,
                       const Eigen::Ref<const Eigen::VectorXd>& slope) {
  CHECK_LE(lambda_end, lambda_begin);
  const std::size_t count = active.size();
  if (blocks_.empty() ||
      blocks_.back().active.size() + count > blocks_.back().active.capacity()) {
    Block& block = blocks_.emplace_back();
    const std::size_t room = std::max(count, kBlock);
    block.active.reserve(room);
    block.start.reserve(room);
    block.slope.reserve(room);
  }
  Block& block = blocks_.back();
  segments_.push_back({.lambda_begin = lambda_begin,
                       .lambda_end = lambda_end,
                       .block = static_cast<int>(blocks_.size()) - 1,
                       .offset = std::ssize(block.active),
                       .active = static_cast<int>(count)});
  block.active.insert(block.active.end(), active.begin(), active.end());
  block.start.insert(block.start.end(), start.data(), start.data() + count);
  block.slope.insert(block.slope.end(), slope.data(), slope.data() + count);
  end_.resize(0);
}

void LassoPath::AppendJoin(double lambda_begin, const Eigen::VectorXd& begin,
                           double lambda_end, const Eigen::VectorXd& end) {
  if (lambda_end >= lambda_begin) return;
  std::vector<int> active;
  for (int j = 0; j < size_; ++j) {
    if (begin(j) != 0.0 || end(j) != 0.0) active.push_back(j);
  }
  const Eigen::VectorXd start = begin(active);
  Append(lambda_begin, lambda_end, active, start,
         (end(active) - start) / (lambda_begin - lambda_end));
  end_ = end;
}

}  // namespace mle
