// The likelihood of a noise shape (innovations_filter.h) at a point of one
// output's parameters, and the shape that maximises it. Internal to
// mle/nonlinear.
//
// Residuals and their derivatives are linearised once; at every shape the
// parameters that are free are eliminated to first order, the amplitudes
// exactly, and r by its maximum, from the products of the whitened columns
// (InnovationsFilter::WhitenedProducts). So that their accuracy suffices,
// amplitudes are first made orthonormal under white noise, and taken out of all
// else: that changes no likelihood. Restricted likelihood (Patterson and
// Thompson, Biometrika 58, 1971) counts what they take up:
//
//   −2 ln L = (n − k) ln r̂ + Σ ln F + ln det(JᵀV⁻¹J).
//
// A shape is white noise with a random walk unless a coloured component beside
// it lowers −2 ln L by more than the logarithm of the number of samples for
// each of its parameters, two of first and three of second order: Schwarz's
// criterion (Annals of Statistics 6, 1978).

#ifndef MLE_NONLINEAR_NOISE_SEARCH_H_
#define MLE_NONLINEAR_NOISE_SEARCH_H_

#include <cmath>
#include <limits>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

// 1/N², N the samples of a segment: less drift changes no estimate.
double LeastRatio(const OutputErrorProblem& problem);

// The range of ρ, as ln ρ. Below it drift is less than a sample's noise in
// 10⁵ samples, above it white noise is none. σ has the same.
inline const double kMinLogRatio = std::log(1e-10);
inline const double kMaxLogRatio = std::log(1e6);

// At one noise shape, maximised over r.
struct Profile {
  NoiseShape shape;
  double value = std::numeric_limits<double>::infinity();  // −2 ln likelihood
  double squares = 0.0;  // of the whitened residuals
  double degrees = 0.0;  // of freedom that they have
  int rank = 0;          // of what is fitted to first order
  double factor = 1.0;   // of OutputErrorProblem::variance_factor()

  double variance() const;  // r
};

// −2 ln L and Schwarz's price of the AR component that the shape has.
double PricedValue(const OutputErrorProblem& problem, const Profile& profile);

// CᵀC of columns C whitened by a shape, without what the amplitudes explain.
struct ShapedProducts {
  Eigen::MatrixXd products;      // of what is linearised, then the residuals
  double log_determinant = 0.0;  // Σ ln F
  double log_amplitudes = 0.0;   // ln det of the amplitudes' normal matrix
  int num_amplitudes = 0;        // its rank
};

// The likelihood (or restricted likelihood) of noise shapes.
class ShapeLikelihood {
 public:
  // One copy of all columns is kept.
  ShapeLikelihood(const OutputErrorProblem& problem, const OutputPoint& point,
                  const std::vector<bool>& free, const NoiseShape& start,
                  bool restricted);
  ShapeLikelihood(const OutputErrorProblem& problem,
                  const std::vector<SegmentColumns>& columns,
                  const std::vector<bool>& free, bool restricted);
  // With columns of each segment (rows × k; none at all: as it is), which are
  // fitted besides.
  ShapeLikelihood With(const std::vector<Eigen::MatrixXd>& more) const;

  Profile At(const NoiseShape& shape) const {
    return ProfileOf(shape, ProductsAt(shape));
  }
  ShapedProducts ProductsAt(const NoiseShape& shape) const;
  // From the products at that shape.
  Profile ProfileOf(const NoiseShape& shape,
                    const ShapedProducts& shaped) const;
  const OutputErrorProblem& problem() const { return problem_; }
  Eigen::Index width() const { return width_; }

 private:
  // Columns of a segment: amplitudes, what is linearised, residuals.
  struct Part {
    RowMajorMatrix columns;
    // For each column, the row from which on it is zero.
    std::vector<Eigen::Index> ends;
    Eigen::Index amplitudes = 0;
    // The logarithm of the factor by which the determinant of the products of
    // the amplitudes as they were is larger.
    double log_scale = 0.0;
  };
  static Part MakePart(const SegmentColumns& columns);
  static Part Extended(const Part& part, const Eigen::MatrixXd& more);

  const OutputErrorProblem& problem_;
  std::vector<Part> parts_;  // of each segment
  Eigen::Index width_ = 0;   // columns that are linearised or fitted besides
  bool restricted_;
};

// Values of ρ that stand for all: 0 and e-folds from 1/N² on (N samples of a
// segment), below which drift changes no estimate, with their probabilities
// beforehand, but for a factor. The prior is uniform in √ρ (Gelman, Bayesian
// Analysis 1, 2006); one uniform in ln ρ would concentrate on negligible drift.
struct PossibleRatio {
  double ratio = 0.0;
  double prior = 0.0;
};
std::vector<PossibleRatio> PossibleRatios(const OutputErrorProblem& problem);
// Ratios with less than this share of the largest probability are left out.
inline constexpr double kSmallWeight = 1e-3;

// −1/ln φ and back.
double MemoryOf(double pole);
double PoleOf(double memory);

// Shapes move in ln ρ, ln σ, ln(−1/ln φ) and ln ζ: whether `shape` has the
// parameter (0 to 3), and the shape with its logarithm moved by `by`.
inline constexpr int kShapeParameters = 4;
bool HasParameter(const NoiseShape& shape, int parameter);
NoiseShape Moved(const NoiseShape& shape, int parameter, double by);

// The noise of a profile, with the standard deviations of its logarithms by the
// curvature of the likelihood there.
NoiseEstimate NoiseOf(const ShapeLikelihood& likelihood,
                      const Profile& profile);

// With an offset, over all ρ (0 unless `estimate_drift`) and, where it pays,
// AR components: from those of `start` if it has them, and, if `search_ar`, of
// a grid of each order that `start` does not have. An AR component found before
// stays as it is where that is as good as the best to a hundredth of −2 ln L,
// and is given up only if `search_ar`.
Profile FindBestShape(const ShapeLikelihood& likelihood,
                      const NoiseShape& start, bool estimate_drift,
                      bool search_ar);

}  // namespace mle

#endif  // MLE_NONLINEAR_NOISE_SEARCH_H_
