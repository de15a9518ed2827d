// The solutions of one lasso problem for all λ from λ_max down to where the
// path ends: piecewise linear, kept as the segments between its knots,
//
//   β_A(λ) = β_A(λ_begin) + (λ_begin − λ) q,   λ_end ≤ λ ≤ λ_begin,
//
// all other coefficients zero.

#ifndef MLE_REGRESSION_LASSO_PATH_H_
#define MLE_REGRESSION_LASSO_PATH_H_

#include <algorithm>
#include <vector>

#include "Eigen/Core"

namespace mle {

class LassoPath {
 public:
  struct Segment {
    double lambda_begin = 0.0;
    double lambda_end = 0.0;
    int block = 0;            // that has its coefficients
    Eigen::Index offset = 0;  // of them there
    int active = 0;           // |A|
  };

  LassoPath() = default;
  explicit LassoPath(int size) : size_(size) {}

  int size() const { return size_; }
  const std::vector<Segment>& segments() const { return segments_; }
  // 0 for a path without segments: β = 0 for every λ.
  double lambda_begin() const {
    return segments_.empty() ? 0.0 : segments_.front().lambda_begin;
  }
  double lambda_end() const {
    return segments_.empty() ? 0.0 : segments_.back().lambda_end;
  }

  // A, β_A(λ_begin) and q of a segment.
  Eigen::Map<const Eigen::VectorXi> Active(const Segment& segment) const {
    return {blocks_[segment.block].active.data() + segment.offset,
            segment.active};
  }
  Eigen::Map<const Eigen::VectorXd> Start(const Segment& segment) const {
    return {blocks_[segment.block].start.data() + segment.offset,
            segment.active};
  }
  Eigen::Map<const Eigen::VectorXd> Slope(const Segment& segment) const {
    return {blocks_[segment.block].slope.data() + segment.offset,
            segment.active};
  }

  // Number of the segment that holds λ, the later one where two meet; −1 above
  // λ_begin, the last one below λ_end.
  int FindSegment(double lambda) const;

  // β(λ) into `beta` (n): zero above λ_begin, the end of the path below it.
  void Coefficients(double lambda, Eigen::Ref<Eigen::VectorXd> beta) const;
  Eigen::VectorXd Coefficients(double lambda) const;

  // visit(j, β_j(λ)) for each coefficient that may differ from zero.
  template <typename Function>
  void VisitCoefficients(double lambda, Function visit) const;

  // Segments are appended in falling λ.
  void Append(double lambda_begin, double lambda_end,
              const std::vector<int>& active,
              const Eigen::Ref<const Eigen::VectorXd>& start,
              const Eigen::Ref<const Eigen::VectorXd>& slope);

  // A straight segment between two solutions (n each), which the path then
  // returns without rounding; nothing where lambda_end is not below
  // lambda_begin.
  void AppendJoin(double lambda_begin, const Eigen::VectorXd& begin,
                  double lambda_end, const Eigen::VectorXd& end);

 private:
  int size_ = 0;
  std::vector<Segment> segments_;
  // Coefficients of segments, one after the other. No block grows beyond what
  // it had room for at first: to move what is there would cost more than to
  // write it.
  struct Block {
    std::vector<int> active;
    std::vector<double> start;
    std::vector<double> slope;
  };
  std::vector<Block> blocks_;
  Eigen::VectorXd end_;  // β(λ_end) where it is known without rounding
};

template <typename Function>
void LassoPath::VisitCoefficients(double lambda, Function visit) const {
  const int number = FindSegment(lambda);
  if (number < 0) return;
  if (end_.size() > 0 && lambda <= lambda_end()) {
    for (int j = 0; j < size_; ++j) {
      if (end_(j) != 0.0) visit(j, end_(j));
    }
    return;
  }
  const Segment& segment = segments_[number];
  const double step =
      segment.lambda_begin - std::max(lambda, segment.lambda_end);
  const auto active = Active(segment);
  const auto start = Start(segment);
  const auto slope = Slope(segment);
  for (int i = 0; i < segment.active; ++i) {
    visit(active(i), start(i) + step * slope(i));
  }
}

}  // namespace mle

#endif  // MLE_REGRESSION_LASSO_PATH_H_
