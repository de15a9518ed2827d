#include "mle/nonlinear/noise_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/ar_search.h"
#include "mle/nonlinear/elimination.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRatioGridStep = 1.0;  // of possible ratios
// Steps of the search for the best: in general, and the first from where it was
// before (RatioSearch: e-folds of ρ where there is much drift).
constexpr double kSearchStep = 2.5;
constexpr double kNearStep = 0.5;
constexpr double kFar = 0.75;  // from where on points are not trusted
// A smaller difference of −2 ln L does not count: at its square root, 3 %, of a
// standard error of ln ρ.
constexpr double kNoRatioGain = 1e-3;
constexpr int kMostParabolas = 12;
constexpr double kGoldenSection = 0.381966;
// A parabola through far points may promise this many times too little.
constexpr double kMostOfParabola = 4.0;
// A parabola cannot see a third derivative, of this share of the second.
constexpr double kThirdDerivative = 0.3;

// Beforehand every √ρ is as likely as any other: what of it is nearest to a
// value of the grid, as a share of √ρ there; and below the smallest, of that.
const double kShareOfValue =
    std::exp(0.25 * kRatioGridStep) - std::exp(-0.25 * kRatioGridStep);
const double kShareBelow = std::exp(-0.25 * kRatioGridStep);

// In samples, the mean.
double SegmentLength(const OutputErrorProblem& problem) {
  return static_cast<double>(problem.num_samples()) /
         static_cast<double>(problem.num_segments());
}

// The row from which on a column is zero.
Eigen::Index EndOf(const Eigen::Ref<const VectorXd>& column) {
  Eigen::Index end = column.size();
  while (end > 0 && column(end - 1) == 0.0) --end;
  return end;
}

// Takes out of `others`, about their means, what the columns of `basis`
// explain, which are orthonormal once they have no mean. Only rows up to where
// the columns end are read but for the others' sums.
void TakeOut(const MatrixXd& basis, Eigen::Ref<RowMajorMatrix> others) {
  if (basis.cols() == 0) return;
  Eigen::Index end = 0;
  for (const auto& column : basis.colwise()) {
    end = std::max(end, EndOf(column));
  }
  const auto top = basis.topRows(end);
  MatrixXd shares = top.transpose() * others.topRows(end);
  shares.noalias() -=
      basis.colwise().mean().transpose() * others.colwise().sum();
  others.topRows(end).noalias() -= top * shares;
}

}  // namespace

double Profile::variance() const {
  return factor * squares / std::max(degrees, 1.0);
}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const OutputPoint& point,
                                 const std::vector<bool>& free,
                                 const NoiseShape& start, bool restricted)
    : ShapeLikelihood(problem, problem.Linearise(point, start, free), free,
                      restricted) {}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const std::vector<SegmentColumns>& columns,
                                 const std::vector<bool>& free, bool restricted)
    : problem_(problem),
      width_(3 * std::count(free.begin(), free.end(), true)),
      restricted_(restricted) {
  for (const SegmentColumns& of : columns) parts_.push_back(MakePart(of));
}

ShapeLikelihood ShapeLikelihood::With(const std::vector<MatrixXd>& more) const {
  if (more.empty()) return *this;
  ShapeLikelihood with(problem_, {}, {}, restricted_);
  with.width_ = width_ + more.front().cols();
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    with.parts_.push_back(Extended(parts_[s], more[s]));
  }
  return with;
}

// Under white noise with an offset: about the means.
ShapeLikelihood::Part ShapeLikelihood::MakePart(const SegmentColumns& columns) {
  Part part;
  const MatrixXd& amplitudes = columns.amplitudes;
  MatrixXd basis(amplitudes.rows(), 0);
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
    for (Eigen::Index i = 0; i < rank; ++i) {
      part.log_scale += 2.0 * std::log(std::abs(qr.matrixQR()(i, i)) /
                                       inverse_norms(kept(i)));
    }
  }
  part.amplitudes = basis.cols();
  for (const auto& column : basis.colwise()) part.ends.push_back(EndOf(column));
  const Eigen::Index kept = columns.jacobian.cols();
  part.columns.resize(columns.residuals.size(), basis.cols() + kept + 1);
  part.columns.leftCols(basis.cols()) = basis;
  part.columns.middleCols(basis.cols(), kept) = columns.jacobian;
  part.columns.rightCols<1>() = columns.residuals;
  TakeOut(basis, part.columns.rightCols(kept + 1));
  part.ends.resize(part.columns.cols(), part.columns.rows());
  return part;
}

ShapeLikelihood::Part ShapeLikelihood::Extended(const Part& part,
                                                const MatrixXd& more) {
  const Eigen::Index before = part.columns.cols() - 1;
  Part extended = {.ends = part.ends,
                   .amplitudes = part.amplitudes,
                   .log_scale = part.log_scale};
  extended.columns.resize(part.columns.rows(), before + more.cols() + 1);
  extended.columns.leftCols(before) = part.columns.leftCols(before);
  extended.columns.middleCols(before, more.cols()) = more;
  extended.columns.rightCols<1>() = part.columns.rightCols<1>();
  TakeOut(part.columns.leftCols(part.amplitudes),
          extended.columns.middleCols(before, more.cols()));
  extended.ends.resize(extended.columns.cols(), extended.columns.rows());
  return extended;
}

ShapedProducts ShapeLikelihood::ProductsAt(const NoiseShape& shape) const {
  ShapedProducts all;
  all.products = MatrixXd::Zero(width_ + 1, width_ + 1);
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const Part& part = parts_[s];
    const OutputErrorProblem::Segment& segment =
        problem_.segment(static_cast<int>(s));
    const InnovationsFilter filter(segment.times, shape, segment.weights);
    const Elimination amplitudes = EliminateFirst(
        part.amplitudes, filter.WhitenedProducts(part.columns, part.ends));
    all.products += amplitudes.rest;
    all.log_amplitudes += amplitudes.log_determinant + part.log_scale;
    all.num_amplitudes += amplitudes.rank();
    all.log_determinant += filter.log_determinant();
  }
  return all;
}

Profile ShapeLikelihood::ProfileOf(const NoiseShape& shape,
                                   const ShapedProducts& shaped) const {
  Profile profile;
  profile.shape = shape;
  profile.factor = problem_.variance_factor();
  const Elimination linearised = EliminateFirst(width_, shaped.products);
  profile.rank = linearised.rank();
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

double LeastRatio(const OutputErrorProblem& problem) {
  const double length = SegmentLength(problem);
  return std::max(1.0 / (length * length), std::exp(kMinLogRatio));
}

double MemoryOf(double pole) { return -1.0 / std::log(pole); }

double PoleOf(double memory) { return std::exp(-1.0 / memory); }

std::vector<PossibleRatio> PossibleRatios(const OutputErrorProblem& problem) {
  const double length = SegmentLength(problem);
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
  return shape.has_ar() && (parameter < 3 || shape.ar_damping > 0.0);
}

NoiseShape Moved(const NoiseShape& shape, int parameter, double by) {
  const double factor = std::exp(by);
  NoiseShape moved = shape;
  if (parameter == 0) moved.ratio *= factor;
  if (parameter == 1) moved.ar_ratio *= factor;
  if (parameter == 2) {
    moved.ar_pole = PoleOf(MemoryOf(shape.ar_pole) * factor);
  }
  if (parameter == 3) moved.ar_damping *= factor;
  return moved;
}

namespace {

// The likelihood of ρ without an AR component: the best that was asked, and
// what encloses it.
//
// ρ is placed at z = 2 arsinh(√ρ / s), 0 where noise is white. Samples of an
// interval L long, of which the columns fitted take up k, tell nothing of drift
// as long as √ρ is far below (1 + k)/L: s is half of that. Beyond it −2 ln L
// goes with √ρ + ρ₀/√ρ (Whittle's integral over the drift's spectrum), with
// cosh((z − z₀)/2); up to it with a parabola of √ρ, to which z is proportional
// there. So parabolas of z fit wherever the best is, and white noise is a point
// like others.
class RatioSearch {
 public:
  explicit RatioSearch(const ShapeLikelihood& likelihood)
      : likelihood_(likelihood),
        scale_(ScaleOf(likelihood)),
        least_(PlaceOf(LeastRatio(likelihood.problem()))),
        most_(PlaceOf(std::exp(kMaxLogRatio))),
        white_(likelihood.At(NoiseShape())) {}

  // The best of a grid and its neighbours. Above √N there is hardly white
  // noise, and Climb() goes on.
  void AskGrid(double num_samples) {
    double former = std::numeric_limits<double>::infinity();
    bool rose = false;  // from the best to what comes after it
    const double last = PlaceOf(std::sqrt(num_samples)) + kSearchStep;
    for (double at = 0.0; at <= last; at += kSearchStep) {
      Profile profile = At(at);
      const double value = profile.value;
      if (value < best_.value) {
        low_ = {at - kSearchStep, former};
        place_ = at;
        best_ = std::move(profile);
        rose = false;
      } else if (!rose) {
        high_ = {at, value};
        rose = true;
      }
      former = value;
    }
    if (!rose) Climb(kSearchStep);
  }

  // Downhill from `ratio`, in steps that double.
  void AskNear(double ratio) {
    place_ = std::min(PlaceOf(ratio), most_);
    best_ = At(place_);
    // The way down leads to white noise.
    if (place_ <= least_ && white_.value <= best_.value) {
      place_ = 0.0;
      return;
    }
    if (!Climb(kNearStep)) Climb(-kNearStep);
  }

  // The parabola through the three best points tells where the next is asked
  // (Brent, Algorithms for Minimization without Derivatives, 1973), until it
  // promises nothing, or nothing that is better than white noise. Through
  // points that are far it is not trusted.
  Profile Refine() {
    // A place that is better than white noise may be nearer to it.
    if (place_ == 0.0 && high_.place > kFar) {
      Take(kGoldenSection * high_.place);
    }
    std::array<Point, 2> others = {low_, high_};
    for (int asked = 0; asked < kMostParabolas && place_ > 0.0; ++asked) {
      if (others[1].value < others[0].value) std::swap(others[0], others[1]);
      const double near = others[0].place - place_;
      const double far = others[1].place - place_;
      const double near_slope = (others[0].value - best_.value) / near;
      const double far_slope = (others[1].value - best_.value) / far;
      const double curvature = (near_slope - far_slope) / (near - far);
      const double slope = near_slope - curvature * near;
      const double gain = 0.25 * slope * slope / curvature;
      if (!std::isfinite(gain)) break;
      if (curvature > 0.0 &&
          best_.value - kMostOfParabola * gain >= white_.value) {
        break;
      }
      const double nearer = std::min(std::abs(near), std::abs(far));
      const double farther = std::max(std::abs(near), std::abs(far));
      const bool enclosed = near * far < 0.0;
      double step = -0.5 * slope / curvature;
      // By so much the least value is elsewhere.
      const double shift = kThirdDerivative * near * far / 6.0;
      if ((enclosed ? nearer : farther) > kFar) {
        step = std::copysign(std::max(std::abs(step), kNearStep),
                             enclosed ? step : -near);
      } else if (curvature > 0.0 &&
                 gain + curvature * shift * shift < kNoRatioGain) {
        break;
      }
      const double below = low_.place - place_;
      const double above = high_.place - place_;
      if (!(curvature > 0.0 && step > below && step < above)) {
        step = kGoldenSection * (above > -below ? above : below);
      }
      others[1] = Take(place_ + step);
    }
    return best_.value < white_.value ? best_ : white_;
  }

 private:
  struct Point {
    double place = 0.0;
    double value = std::numeric_limits<double>::infinity();
  };

  static double ScaleOf(const ShapeLikelihood& likelihood) {
    const OutputErrorProblem& problem = likelihood.problem();
    const double columns = static_cast<double>(likelihood.width()) /
                           static_cast<double>(problem.num_segments());
    return 0.5 * (1.0 + columns) / SegmentLength(problem);
  }
  double PlaceOf(double ratio) const {
    return 2.0 * std::asinh(std::sqrt(ratio) / scale_);
  }

  Profile At(double place) const {
    const double root = scale_ * std::sinh(0.5 * place);
    const double ratio = root * root;
    return std::log(ratio) < kMinLogRatio ? white_
                                          : likelihood_.At({.ratio = ratio});
  }

  // Moves on by `step` while that is better; whether it was.
  bool Climb(double step) {
    Point& ahead = step > 0.0 ? high_ : low_;
    Point& behind = step > 0.0 ? low_ : high_;
    bool climbed = false;
    while (true) {
      ahead = {std::clamp(place_ + step, 0.0, most_)};
      if (ahead.place == place_) return climbed;
      Profile profile = At(ahead.place);
      ahead.value = profile.value;
      if (!(profile.value < best_.value)) return climbed;
      behind = {place_, best_.value};
      place_ = ahead.place;
      best_ = std::move(profile);
      climbed = true;
      step = std::clamp(2.0 * step, -kSearchStep, kSearchStep);
    }
  }

  // Asks one more point between the ends; which of it and the best before is
  // not the best now.
  Point Take(double place) {
    Profile profile = At(place);
    const Point next = {place, profile.value};
    if (!(profile.value < best_.value)) {
      (place > place_ ? high_ : low_) = next;
      return next;
    }
    const Point former = {place_, best_.value};
    (place > place_ ? low_ : high_) = former;
    place_ = place;
    best_ = std::move(profile);
    return former;
  }

  const ShapeLikelihood& likelihood_;
  double scale_;  // s
  double least_;  // drift, as a place
  double most_;
  Profile white_;
  Profile best_;
  double place_ = 0.0;  // of the best
  Point low_;
  Point high_;
};

// Over all ρ, without an AR component: from `near` downhill or, where that is
// 0, on a grid.
Profile FindBestRatio(const ShapeLikelihood& likelihood, double near) {
  RatioSearch search(likelihood);
  if (near > 0.0) {
    search.AskNear(near);
  } else {
    search.AskGrid(likelihood.problem().num_samples());
  }
  return search.Refine();
}

}  // namespace

Profile FindBestShape(const ShapeLikelihood& likelihood,
                      const NoiseShape& start, bool estimate_drift,
                      bool search_ar) {
  if (!estimate_drift) return likelihood.At(NoiseShape());
  Profile best;
  if (!start.has_ar() || search_ar) {
    best = FindBestRatio(likelihood, start.has_ar() ? 0.0 : start.ratio);
  }
  if (!start.has_ar() && !search_ar) return best;
  const Profile walk = best;
  double least = walk.value;
  for (const int order : {1, 2}) {
    const bool known = start.has_ar() && start.ar().order() == order;
    if (!known && !search_ar) continue;
    const Profile coloured = known ? ContinueAr(likelihood, start)
                                   : FindBestAr(likelihood, order, walk);
    const double value = PricedValue(likelihood.problem(), coloured);
    if (value < least) {
      least = value;
      best = coloured;
    }
  }
  return best;
}

}  // namespace mle
