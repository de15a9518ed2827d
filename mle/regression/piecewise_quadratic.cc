#include "mle/regression/piecewise_quadratic.h"

#include <algorithm>
#include <functional>

#include "glog/logging.h"

namespace mle {

double PiecewiseQuadratic::operator()(double lambda) const {
  if (pieces_.empty() || lambda >= pieces_.front().lambda_begin) {
    return constant_;
  }
  const auto it = std::lower_bound(
      pieces_.begin(), pieces_.end(), lambda,
      [](const Piece& piece, double l) { return piece.lambda_end >= l; });
  const Piece& piece = it == pieces_.end() ? pieces_.back() : *it;
  return piece.At(std::max(lambda, piece.lambda_end));
}

void PiecewiseQuadratic::Scale(double factor) {
  constant_ *= factor;
  for (Piece& piece : pieces_) {
    piece.value *= factor;
    piece.slope *= factor;
    piece.curvature *= factor;
  }
}

void PiecewiseQuadratic::AddTo(const Eigen::VectorXd& lambdas,
                               Eigen::VectorXd& sums) const {
  CHECK_EQ(lambdas.size(), sums.size());
  auto piece = pieces_.begin();
  for (Eigen::Index i = lambdas.size() - 1; i >= 0; --i) {
    const double lambda = lambdas(i);
    if (pieces_.empty() || lambda >= pieces_.front().lambda_begin) {
      sums(i) += constant_;
      continue;
    }
    while (piece + 1 != pieces_.end() && lambda <= piece->lambda_end) ++piece;
    sums(i) += piece->At(std::max(lambda, piece->lambda_end));
  }
}

Minimum MinimizeSum(absl::Span<const PiecewiseQuadratic> functions) {
  const auto sum_at = [&](double lambda) {
    double sum = 0.0;
    for (const PiecewiseQuadratic& f : functions) sum += f(lambda);
    return sum;
  };
  std::vector<double> knots = {0.0};
  for (const PiecewiseQuadratic& f : functions) {
    for (const PiecewiseQuadratic::Piece& piece : f.pieces()) {
      knots.push_back(piece.lambda_begin);
      knots.push_back(piece.lambda_end);
    }
  }
  std::sort(knots.begin(), knots.end(), std::greater<>());
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());

  Minimum best{knots.front(), sum_at(knots.front())};
  const auto consider = [&](double lambda) {
    const double value = sum_at(lambda);
    if (value < best.value) best = {lambda, value};
  };
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double high = knots[i];
    const double low = knots[i + 1];
    // The sum is one quadratic here: its vertex from three values.
    const double middle = 0.5 * (high + low);
    const double f_high = sum_at(high);
    const double f_middle = sum_at(middle);
    const double f_low = sum_at(low);
    const double curvature = f_high - 2.0 * f_middle + f_low;
    if (curvature > 0.0) {
      const double vertex =
          middle + 0.25 * (high - low) * (f_low - f_high) / curvature;
      if (vertex > low && vertex < high) consider(vertex);
    }
    consider(low);
  }
  return best;
}

}  // namespace mle
