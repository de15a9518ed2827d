#include "mle/nonlinear/step_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/disturbance_search.h"
#include "mle/nonlinear/noise_search.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Samples of a segment before and after a step.
constexpr int kMargin = 8;
// Places of a segment at which the variance of a score is computed, at most,
// and samples between them at least.
constexpr int kPlaces = 48;
constexpr int kLeastStride = 12;
// Time scales nearer to each other than this factor are one.
constexpr double kSameLag = 1.5;
constexpr int kStepRefinements = 2;  // of place and shape in turn

// Σ_{k ≥ row} u_k x_k of the step that begins at each row.
VectorXd Scores(const std::vector<int>& times, double lag, const VectorXd& u) {
  VectorXd scores(u.size());
  const double decay = lag > 0.0 ? std::exp(-1.0 / lag) : 0.0;
  double sum = 0.0;
  double decayed = 0.0;  // Σ u_k exp(−(k − t)/T)
  for (Eigen::Index row = u.size() - 1; row >= 0; --row) {
    if (row + 1 < u.size() && lag > 0.0) {
      const int gap = times[row + 1] - times[row];
      decayed *= gap == 1 ? decay : std::pow(decay, gap);
    }
    sum += u(row);
    decayed += u(row);
    scores(row) = lag > 0.0 ? sum - decay * decayed : sum;
  }
  return scores;
}

class StepSearch {
 public:
  explicit StepSearch(const ExtendedFit& extended)
      : extended_(extended),
        problem_(extended.problem()),
        fit_(extended.fit()),
        shape_(ShapeOf(fit_.noise)),
        columns_(extended.columns()),
        lags_(StepLags(problem_, fit_.point)) {
    Fit();
  }

  const std::vector<double>& lags() const { return lags_; }

  // The step of the largest score, and its χ².
  std::pair<SegmentStep, double> Scan() const {
    const VectorXd white = problem_.WhiteResiduals(residuals_, shape_);
    const VectorXd u = problem_.weights().size() > 0
                           ? VectorXd(problem_.weights().cwiseProduct(white))
                           : white;
    std::pair<SegmentStep, double> best = {{}, 0.0};
    Eigen::Index begin = 0;
    for (int s = 0; s < problem_.num_segments(); ++s) {
      const std::vector<int>& times = problem_.times(s);
      const auto rows = static_cast<Eigen::Index>(times.size());
      for (const double lag : lags_) {
        if (rows <= 2 * kMargin) continue;
        const VectorXd scores = Scores(times, lag, u.segment(begin, rows));
        const VectorXd squares = Variances(s, begin, lag);
        for (Eigen::Index row = kMargin; row < rows - kMargin; ++row) {
          const double chi_square =
              scores(row) * scores(row) /
              (std::max(squares(row), 1e-300) * fit_.noise.variance);
          if (chi_square > best.second) {
            best = {{.segment = s, .sample = times[row], .lag = lag},
                    chi_square};
          }
        }
      }
      begin += rows;
    }
    return best;
  }

  // The column of `step` in each segment.
  std::vector<MatrixXd> Columns(const SegmentStep& step) const {
    std::vector<MatrixXd> more;
    for (int s = 0; s < problem_.num_segments(); ++s) {
      MatrixXd& column = more.emplace_back();
      if (s == step.segment) {
        AppendStep(problem_.times(s), step, column);
      } else {
        column.setZero(static_cast<Eigen::Index>(problem_.times(s).size()), 1);
      }
    }
    return more;
  }

  // The likeliest step near `step` at `shape`.
  SegmentStep Refine(SegmentStep step, const NoiseShape& shape) const {
    const std::vector<int>& times = problem_.times(step.segment);
    double best = extended_.With(Columns(step)).At(shape).value;
    const auto try_step = [&](const SegmentStep& other) {
      if (other.sample < times[kMargin] ||
          other.sample > times[times.size() - 1 - kMargin]) {
        return false;
      }
      const double value = extended_.With(Columns(other)).At(shape).value;
      if (!(value < best)) return false;
      best = value;
      step = other;
      return true;
    };
    for (int stride = 8; stride > 0; stride /= 2) {
      for (const int direction : {-1, 1}) {
        SegmentStep other = step;
        do {
          other = step;
          other.sample += direction * stride;
        } while (try_step(other));
      }
      for (const double lag : lags_) {
        SegmentStep other = step;
        other.lag = lag;
        if (lag != step.lag) try_step(other);
      }
    }
    return step;
  }

 private:
  // Makes a basis (N × rank) of the whitened columns of the free parameters,
  // and takes their part out of the residuals: at the initial values that is a
  // lot. Pivots choose among the rows of a triangular factor, which blocks of
  // reflections make.
  void Fit() {
    residuals_ = columns_;
    const WhitenedColumns whitened = problem_.Whiten(columns_, shape_);
    const Eigen::Index n = whitened.jacobian.rows();
    const Eigen::Index width = whitened.jacobian.cols();
    basis_.resize(n, 0);
    if (width == 0) return;
    const VectorXd inverse_norms =
        whitened.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::HouseholderQR<MatrixXd> tall(whitened.jacobian *
                                              inverse_norms.asDiagonal());
    const Eigen::Index rows = std::min(n, width);
    const MatrixXd triangle =
        tall.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> pivoted;
    pivoted.setThreshold(kAmplitudeTolerance);
    pivoted.compute(triangle);
    basis_.setZero(n, pivoted.rank());
    basis_.topRows(rows) =
        pivoted.householderQ() * MatrixXd::Identity(rows, pivoted.rank());
    basis_.applyOnTheLeft(tall.householderQ());
    VectorXd turned = whitened.residuals;
    turned.applyOnTheLeft(tall.householderQ().adjoint());
    const VectorXd step =
        inverse_norms.cwiseProduct(pivoted.solve(VectorXd(turned.head(rows))));
    for (SegmentColumns& of : residuals_) {
      of.residuals -= of.jacobian * step;
    }
  }

  // Variances of the scores of a segment whose rows begin at `begin`, over r:
  // from some places to all.
  VectorXd Variances(int segment, Eigen::Index begin, double lag) const {
    const std::vector<int>& times = problem_.times(segment);
    const auto rows = static_cast<Eigen::Index>(times.size());
    const Eigen::Index last = rows - kMargin;
    const Eigen::Index stride =
        std::max<Eigen::Index>((last - kMargin) / kPlaces, kLeastStride);
    std::vector<Eigen::Index> places;
    for (Eigen::Index row = kMargin; row < last; row += stride) {
      places.push_back(row);
    }
    if (places.back() != last - 1) places.push_back(last - 1);
    SegmentColumns columns = {.residuals = columns_[segment].residuals,
                              .jacobian = MatrixXd(rows, 0),
                              .amplitudes = columns_[segment].amplitudes};
    for (const Eigen::Index place : places) {
      AppendStep(times,
                 {.segment = segment, .sample = times[place], .lag = lag},
                 columns.jacobian);
    }
    const VectorXd squares = WithoutFitted(segment, begin, columns);
    VectorXd all = VectorXd::Zero(rows);
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const Eigen::Index from = places[i];
      const Eigen::Index to = places[i + 1];
      const auto at = static_cast<Eigen::Index>(i);
      for (Eigen::Index row = from; row <= to; ++row) {
        const double part =
            static_cast<double>(row - from) / static_cast<double>(to - from);
        all(row) = (1.0 - part) * squares(at) + part * squares(at + 1);
      }
    }
    return all;
  }

  // Squares of the whitened columns of a segment without what the free
  // parameters explain.
  VectorXd WithoutFitted(int segment, Eigen::Index begin,
                         const SegmentColumns& columns) const {
    const MatrixXd steps =
        problem_.WhitenSegment(segment, columns, shape_).jacobian;
    const VectorXd whole = steps.colwise().squaredNorm();
    VectorXd squares = whole;
    if (basis_.cols() > 0) {
      squares -= (basis_.middleRows(begin, steps.rows()).transpose() * steps)
                     .colwise()
                     .squaredNorm()
                     .transpose();
    }
    // A step that the parameters explain but for rounding is none.
    for (Eigen::Index i = 0; i < squares.size(); ++i) {
      if (!(squares(i) > 1e-6 * whole(i))) squares(i) = 1e300;
    }
    return squares;
  }

  const ExtendedFit& extended_;
  const OutputErrorProblem& problem_;
  const OutputFit& fit_;
  NoiseShape shape_;
  const std::vector<SegmentColumns>& columns_;
  std::vector<SegmentColumns> residuals_;  // the columns with what is left
  MatrixXd basis_;
  std::vector<double> lags_;
};

}  // namespace

std::vector<double> StepLags(const OutputErrorProblem& problem,
                             const OutputPoint& point) {
  std::vector<double> scales;
  for (int j = 0; j < problem.num_elements(); ++j) {
    if (!problem.elements()[j].has_value()) continue;
    scales.push_back(point.values[j].time_scale / problem.sample_time());
  }
  std::sort(scales.begin(), scales.end());
  std::vector<double> lags = {0.0};
  for (const double scale : scales) {
    if (scale > std::max(1.0, kSameLag * lags.back())) lags.push_back(scale);
  }
  return lags;
}

std::optional<FoundStep> FindStep(const ExtendedFit& extended) {
  const OutputErrorProblem& problem = extended.problem();
  const OutputFit& fit = extended.fit();
  if (problem.num_segments() == 0 || !(fit.noise.variance > 0.0)) {
    return std::nullopt;
  }
  const double log_samples = std::log(problem.num_innovations(NoiseShape()));
  const StepSearch search(extended);
  auto [step, chi_square] = search.Scan();
  if (!(chi_square > 2.0 * log_samples)) return std::nullopt;
  Profile with;
  with.shape = ShapeOf(fit.noise);
  for (int round = 0; round < kStepRefinements; ++round) {
    step = search.Refine(step, with.shape);
    with = extended.Best(search.Columns(step),
                         round == 0 ? NoiseShape() : with.shape,
                         /*search_ar=*/round == 0);
  }
  const double gain = PricedValue(problem, extended.Without()) -
                      PricedValue(problem, with) - StepPrice(problem);
  if (!(gain > 0.0) || extended.InputsGain(gain)) return std::nullopt;
  return FoundStep{.step = step, .gain = gain};
}

}  // namespace mle
