#include "mle/nonlinear/noise_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/brent_search.h"
#include "mle/nonlinear/colour_search.h"
#include "mle/nonlinear/elimination.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRatioGridStep = 1.0;  // of possible ratios
constexpr double kSearchStep = 2.0;     // of the search for the best
constexpr int kSearchBits = 10;         // of ln ρ: 4e-3 at most

// Beforehand every √ρ is as likely as any other: what of it is nearest to a
// value of the grid, as a share of √ρ there; and below the smallest, of that.
const double kShareOfValue =
    std::exp(0.25 * kRatioGridStep) - std::exp(-0.25 * kRatioGridStep);
const double kShareBelow = std::exp(-0.25 * kRatioGridStep);

}  // namespace

double Profile::variance() const {
  return factor * squares / std::max(degrees, 1.0);
}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const OutputPoint& point,
                                 const std::vector<bool>& free,
                                 const NoiseShape& start, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : ShapeLikelihood(problem, problem.Linearise(point, start, free), free,
                      restricted, more) {}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const std::vector<SegmentColumns>& columns,
                                 const std::vector<bool>& free, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : problem_(problem), restricted_(restricted) {
  const auto num_kept =
      static_cast<Eigen::Index>(3 * std::count(free.begin(), free.end(), true));
  width_ = num_kept + (more.empty() ? 0 : more.front().cols());
  for (std::size_t s = 0; s < columns.size(); ++s) {
    parts_.push_back(MakePart(columns[s], more.empty() ? nullptr : &more[s]));
  }
}

// Under white noise with an offset: about the means.
ShapeLikelihood::Part ShapeLikelihood::MakePart(const SegmentColumns& columns,
                                                const MatrixXd* more) {
  Part part;
  const MatrixXd& amplitudes = columns.amplitudes;
  MatrixXd basis(amplitudes.rows(), 0);
  MatrixXd orthonormal;
  if (amplitudes.cols() > 0) {
    const MatrixXd centred = amplitudes.rowwise() - amplitudes.colwise().mean();
    const VectorXd inverse_norms =
        centred.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    Eigen::ColPivHouseholderQR<MatrixXd> qr;
    qr.setThreshold(kAmplitudeTolerance);
    qr.compute(centred * inverse_norms.asDiagonal());
    const Eigen::Index rank = qr.rank();
    const auto kept = qr.colsPermutation().indices().head(rank);
    const auto triangle =
        qr.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
    basis = amplitudes(Eigen::all, kept) * inverse_norms(kept).asDiagonal();
    triangle.solveInPlace<Eigen::OnTheRight>(basis);
    orthonormal = basis.rowwise() - basis.colwise().mean();
    for (Eigen::Index i = 0; i < rank; ++i) {
      part.log_scale += 2.0 * std::log(std::abs(qr.matrixQR()(i, i)) /
                                       inverse_norms(kept(i)));
    }
  }
  part.amplitudes = basis.cols();
  const Eigen::Index kept = columns.jacobian.cols();
  const Eigen::Index besides = more == nullptr ? 0 : more->cols();
  part.columns.resize(columns.residuals.size(),
                      basis.cols() + kept + besides + 1);
  part.columns.leftCols(basis.cols()) = basis;
  auto others = part.columns.rightCols(kept + besides + 1);
  others.leftCols(kept) = columns.jacobian;
  if (besides > 0) others.middleCols(kept, besides) = *more;
  others.rightCols<1>() = columns.residuals;
  if (basis.cols() > 0) {
    const MatrixXd shares = orthonormal.transpose() * others;
    others.noalias() -= basis * shares;
  }
  return part;
}

ShapedProducts ShapeLikelihood::ProductsAt(const NoiseShape& shape) const {
  ShapedProducts all;
  all.products = MatrixXd::Zero(width_ + 1, width_ + 1);
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const Part& part = parts_[s];
    const OutputErrorProblem::Segment& segment =
        problem_.segment(static_cast<int>(s));
    const InnovationsFilter filter(segment.times, shape, segment.weights);
    const Elimination amplitudes =
        EliminateFirst(part.amplitudes, filter.WhitenedProducts(part.columns));
    all.products += amplitudes.rest;
    all.log_amplitudes += amplitudes.log_determinant + part.log_scale;
    all.num_amplitudes += amplitudes.rank();
    all.log_determinant += filter.log_determinant();
  }
  return all;
}

Profile ShapeLikelihood::At(const NoiseShape& shape) const {
  Profile profile;
  profile.shape = shape;
  profile.factor = problem_.variance_factor();
  ShapedProducts shaped = ProductsAt(shape);
  const Elimination linearised =
      EliminateFirst(width_, std::move(shaped.products));
  profile.rank = linearised.rank();
  profile.coefficients = linearised.Coefficients(width_);
  // Exact data leave rounding, which has no likelihood.
  profile.squares = std::max(
      {linearised.rest(0, 0), 1e-26 * problem_.total_squares(), 1e-300});
  const double n = problem_.num_innovations(shape);
  profile.degrees = n - shaped.num_amplitudes - linearised.rank();
  profile.value = shaped.log_determinant;
  if (restricted_) {
    profile.value += profile.degrees * std::log(profile.variance()) +
                     shaped.log_amplitudes + linearised.log_determinant;
  } else {
    profile.value += n * std::log(profile.squares / n);
  }
  return profile;
}

double PricedValue(const OutputErrorProblem& problem, const Profile& profile) {
  int parameters = 0;
  for (int i = 1; i < kShapeParameters; ++i) {
    parameters += HasParameter(profile.shape, i) ? 1 : 0;
  }
  return profile.value +
         parameters * std::log(problem.num_innovations(NoiseShape()));
}

double MemoryOf(double pole) { return -1.0 / std::log(pole); }

double PoleOf(double memory) { return std::exp(-1.0 / memory); }

std::vector<PossibleRatio> PossibleRatios(const OutputErrorProblem& problem) {
  const double length = static_cast<double>(problem.num_samples()) /
                        static_cast<double>(problem.num_segments());
  std::vector<PossibleRatio> ratios = {{0.0, kShareBelow / length}};
  for (double log_ratio = -2.0 * std::log(length); log_ratio <= kMaxLogRatio;
       log_ratio += kRatioGridStep) {
    ratios.push_back(
        {std::exp(log_ratio), kShareOfValue * std::exp(0.5 * log_ratio)});
  }
  return ratios;
}

bool HasParameter(const NoiseShape& shape, int parameter) {
  if (parameter == 0) return shape.ratio > 0.0;
  return shape.coloured() && (parameter < 3 || shape.colour_damping > 0.0);
}

NoiseShape Moved(const NoiseShape& shape, int parameter, double by) {
  const double factor = std::exp(by);
  NoiseShape moved = shape;
  if (parameter == 0) moved.ratio *= factor;
  if (parameter == 1) moved.colour_ratio *= factor;
  if (parameter == 2) {
    moved.colour_pole = PoleOf(MemoryOf(shape.colour_pole) * factor);
  }
  if (parameter == 3) moved.colour_damping *= factor;
  return moved;
}

namespace {

Profile AtLogRatio(const ShapeLikelihood& likelihood, double log_ratio) {
  return likelihood.At({.ratio = std::exp(log_ratio)});
}

Profile SearchRatioBetween(const ShapeLikelihood& likelihood, double low,
                           double high) {
  Profile best;
  SearchLeast(low, high, kSearchBits, [&](double log_ratio) {
    const Profile profile = AtLogRatio(likelihood, log_ratio);
    if (profile.value < best.value) best = profile;
    return profile.value;
  });
  return best;
}

// Over all ρ, without colour: from `near` downhill or, where that is 0, on a
// grid, then between its neighbours.
Profile FindBestRatio(const ShapeLikelihood& likelihood, double near) {
  Profile best = likelihood.At(NoiseShape());
  if (near > 0.0) {
    double log_near = std::clamp(std::log(near), kMinLogRatio, kMaxLogRatio);
    Profile inner = AtLogRatio(likelihood, log_near);
    for (const double step : {kSearchStep, -kSearchStep}) {
      bool moved = false;
      for (double next = log_near + step;
           next >= kMinLogRatio && next <= kMaxLogRatio; next += step) {
        const Profile profile = AtLogRatio(likelihood, next);
        if (!(profile.value < inner.value)) break;
        inner = profile;
        log_near = next;
        moved = true;
      }
      if (moved) break;
    }
    const Profile between = SearchRatioBetween(
        likelihood, log_near - kSearchStep, log_near + kSearchStep);
    if (between.value < inner.value) inner = between;
    return inner.value < best.value ? inner : best;
  }
  double best_log = kMinLogRatio;
  for (double log_ratio = kMinLogRatio; log_ratio <= kMaxLogRatio;
       log_ratio += kSearchStep) {
    const Profile profile = AtLogRatio(likelihood, log_ratio);
    if (profile.value < best.value) {
      best = profile;
      best_log = log_ratio;
    }
  }
  const Profile inner = SearchRatioBetween(likelihood, best_log - kSearchStep,
                                           best_log + kSearchStep);
  return inner.value < best.value ? inner : best;
}

}  // namespace

Profile FindBestShape(const ShapeLikelihood& likelihood,
                      const NoiseShape& start, bool estimate_drift,
                      bool search_colour) {
  if (!estimate_drift) return likelihood.At(NoiseShape());
  Profile best;
  if (!start.coloured() || search_colour) {
    best = FindBestRatio(likelihood, start.coloured() ? 0.0 : start.ratio);
  }
  if (!start.coloured() && !search_colour) return best;
  const Profile walk = best;
  double least = walk.value;
  for (const int order : {1, 2}) {
    const bool known = start.coloured() && start.colour().order() == order;
    if (!known && !search_colour) continue;
    const Profile coloured = known ? ContinueColour(likelihood, start)
                                   : FindBestColour(likelihood, order, walk);
    const double value = PricedValue(likelihood.problem(), coloured);
    if (value < least) {
      least = value;
      best = coloured;
    }
  }
  return best;
}

}  // namespace mle
