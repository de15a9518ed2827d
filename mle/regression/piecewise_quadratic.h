// Piecewise quadratic functions of λ ≥ 0: what a quadratic loss becomes along a
// lasso path. Constant above its first knot and below its last one.

#ifndef MLE_REGRESSION_PIECEWISE_QUADRATIC_H_
#define MLE_REGRESSION_PIECEWISE_QUADRATIC_H_

#include <vector>

#include "Eigen/Core"
#include "absl/types/span.h"

namespace mle {

class PiecewiseQuadratic {
 public:
  // value + slope t + curvature t², t = lambda_begin − λ, λ_end ≤ λ ≤ λ_begin.
  struct Piece {
    double lambda_begin = 0.0;
    double lambda_end = 0.0;
    double value = 0.0;
    double slope = 0.0;
    double curvature = 0.0;

    double At(double lambda) const {
      const double t = lambda_begin - lambda;
      return value + t * (slope + t * curvature);
    }
  };

  PiecewiseQuadratic() = default;
  // `constant` holds above the first piece, and everywhere without pieces.
  explicit PiecewiseQuadratic(double constant) : constant_(constant) {}

  // Pieces are appended in falling λ, each beginning where the last one ends.
  void Append(const Piece& piece) { pieces_.push_back(piece); }
  void Scale(double factor);
  const std::vector<Piece>& pieces() const { return pieces_; }

  // The value at λ. Where two pieces meet it is that of the later one, as in
  // LassoPath: it is known better.
  double operator()(double lambda) const;
  // sums(i) += f(lambdas(i)); `lambdas` ascending. One sweep.
  void AddTo(const Eigen::VectorXd& lambdas, Eigen::VectorXd& sums) const;

 private:
  double constant_ = 0.0;
  std::vector<Piece> pieces_;
};

struct Minimum {
  double lambda = 0.0;
  double value = 0.0;
};

// The exact minimum over λ ≥ 0 of the functions' sum, the largest λ of several.
Minimum MinimizeSum(absl::Span<const PiecewiseQuadratic> functions);

}  // namespace mle

#endif  // MLE_REGRESSION_PIECEWISE_QUADRATIC_H_
