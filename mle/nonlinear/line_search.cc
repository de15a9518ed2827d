#include "mle/nonlinear/line_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/fast_length.h"
#include "mle/nonlinear/brent_search.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/disturbance_search.h"
#include "mle/nonlinear/noise_search.h"
#include "unsupported/Eigen/FFT"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFewestCycles = 4.0;  // in the shortest segment
constexpr double kFewestSamplesOfCycle = 4.0;
constexpr double kFalseAlarm = 1e-4;  // of a peak
// The least length of a transform, in lengths of the shortest segment, whose
// peaks are as wide as the inverse.
constexpr int kTransformLengths = 2;
constexpr int kLineRefinements = 3;  // of frequency and shape in turn
// A line that explains less than half of its price never pays.
constexpr double kHopeless = 0.5;
constexpr int kRefinementBits = 8;  // a hundredth of the width

// I(f) at f = 0, 1/n, … 1/2 (n even). A sine of such a frequency is the same n
// samples later, so that segments of any length, and gaps, fold into n.
VectorXd Periodogram(const OutputErrorProblem& problem,
                     const VectorXd& residuals, int n) {
  Eigen::FFT<double> transform;
  VectorXd folded(n);
  Eigen::VectorXcd spectrum;
  VectorXd power = VectorXd::Zero(n / 2 + 1);
  Eigen::Index begin = 0;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const std::vector<int>& times = problem.times(s);
    folded.setZero();
    for (const int time : times) {
      folded((time - times.front()) % n) += residuals(begin++);
    }
    transform.fwd(spectrum, folded);
    power += 2.0 / static_cast<double>(times.size()) *
             spectrum.head(power.size()).cwiseAbs2();
  }
  return power * (problem.num_samples() / residuals.squaredNorm());
}

// The frequency of the highest peak, if it is one.
std::optional<double> HighestPeak(const OutputErrorProblem& problem,
                                  const VectorXd& residuals) {
  const int shortest = problem.shortest_segment();
  const int n = kTransformLengths * FastLength(shortest);
  const auto first = static_cast<Eigen::Index>(
      std::ceil(kFewestCycles * n / static_cast<double>(shortest)));
  const auto last = static_cast<Eigen::Index>(n / kFewestSamplesOfCycle);
  if (first > last) return std::nullopt;
  Eigen::Index peak = 0;
  const double highest = Periodogram(problem, residuals, n)
                             .segment(first, last - first + 1)
                             .maxCoeff(&peak);
  if (static_cast<double>(last - first + 1) *
          ChiSquareTail(highest, 2 * problem.num_segments()) >
      kFalseAlarm) {
    return std::nullopt;
  }
  return static_cast<double>(first + peak) / n;
}

// Columns of a line in each segment.
std::vector<MatrixXd> LineColumns(const OutputErrorProblem& problem,
                                  double frequency) {
  std::vector<MatrixXd> columns;
  for (int s = 0; s < problem.num_segments(); ++s) {
    MatrixXd& line = columns.emplace_back();
    AppendLine(problem.times(s), 1.0 / frequency, line);
  }
  return columns;
}

// With a line whose amplitudes each segment has for itself: columns that are
// zero in all segments but one have their own coefficients.
std::vector<MatrixXd> OwnLines(const OutputErrorProblem& problem,
                               double frequency) {
  const std::vector<MatrixXd> own = LineColumns(problem, frequency);
  std::vector<MatrixXd> wide;
  for (std::size_t s = 0; s < own.size(); ++s) {
    const Eigen::Index width = own[s].cols();
    MatrixXd& columns = wide.emplace_back(MatrixXd::Zero(
        own[s].rows(), width * static_cast<Eigen::Index>(own.size())));
    columns.middleCols(width * static_cast<Eigen::Index>(s), width) = own[s];
  }
  return wide;
}

// The frequency within `width` of `frequency` that is likeliest at `shape`.
double RefineLine(const ExtendedFit& extended, double frequency, double width,
                  const NoiseShape& shape) {
  return SearchLeast(
      frequency - width, frequency + width, kRefinementBits, [&](double at) {
        return extended.With(OwnLines(extended.problem(), at)).At(shape).value;
      });
}

}  // namespace

std::optional<FoundPeriod> FindPeriod(const ExtendedFit& extended) {
  const OutputErrorProblem& problem = extended.problem();
  const OutputFit& fit = extended.fit();
  if (problem.num_segments() == 0) return std::nullopt;
  const NoiseShape shape = ShapeOf(fit.noise);
  // A resonance would follow the sine: without it.
  const bool resonant = shape.ar_damping > 0.0 && shape.ar_damping < 1.0;
  const NoiseShape plain =
      resonant ? extended.Best({}, NoiseShape(), /*search_ar=*/false).shape
               : shape;
  const VectorXd residuals =
      problem.Whiten(problem.Linearise(fit.point, plain, {}), plain).residuals;
  const std::optional<double> peak = HighestPeak(problem, residuals);
  if (!peak.has_value()) return std::nullopt;
  double frequency = *peak;
  double width = 1.0 / (kTransformLengths * problem.shortest_segment());
  const double price = LinePrice(problem);
  double gain = 0.0;
  NoiseShape followed = plain;
  for (int round = 0; round < kLineRefinements; ++round) {
    frequency = RefineLine(extended, frequency, width, followed);
    // A filter that follows the sine must not hide it.
    const Profile with = extended.Best(OwnLines(problem, frequency),
                                       round == 0 ? NoiseShape() : followed,
                                       /*search_ar=*/round == 0);
    gain = PricedValue(problem, extended.Without()) -
           PricedValue(problem, with) - price;
    if (gain < -kHopeless * price) return std::nullopt;
    followed = with.shape;
    width *= 0.5;
  }
  if (!(gain > 0.0) || extended.InputsGain(gain)) return std::nullopt;
  return FoundPeriod{.period = 1.0 / frequency, .gain = gain};
}

}  // namespace mle
