#include "mle/nonlinear/line_search.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "mle/nonlinear/brent_search.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/disturbance_search.h"
#include "mle/nonlinear/noise_search.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFewestCycles = 4.0;  // in the shortest segment
constexpr double kFewestSamplesOfCycle = 4.0;
constexpr double kFalseAlarm = 1e-4;       // of a peak
constexpr double kStepOfResolution = 0.5;  // of the frequencies, times 1/N
constexpr int kRefinements = 3;            // of frequency and shape in turn
constexpr int kRefinementBits = 8;         // a hundredth of the width

// Σ_s 2 |Σ_k e_k exp(2πi f k)|² / (N_s v).
double Power(const OutputErrorProblem& problem, const VectorXd& residuals,
             double frequency) {
  const double angle = 2.0 * M_PI * frequency;
  const std::complex<double> turn = std::polar(1.0, angle);
  double power = 0.0;
  Eigen::Index begin = 0;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const std::vector<int>& times = problem.times(s);
    const auto rows = static_cast<Eigen::Index>(times.size());
    std::complex<double> phase = 1.0;
    std::complex<double> sum = 0.0;
    for (Eigen::Index k = 0; k < rows; ++k) {
      const int steps = k == 0 ? 0 : times[k] - times[k - 1];
      phase *= steps == 1 ? turn : std::polar(1.0, angle * steps);
      sum += residuals(begin + k) * phase;
    }
    power += 2.0 * std::norm(sum) / static_cast<double>(rows);
    begin += rows;
  }
  return power / (residuals.squaredNorm() / problem.num_samples());
}

// The frequency of the highest peak, if it is one.
std::optional<double> HighestPeak(const OutputErrorProblem& problem,
                                  const VectorXd& residuals) {
  const double shortest = problem.shortest_segment();
  const double step = kStepOfResolution / shortest;
  double best = 0.0;
  double highest = 0.0;
  double count = 0.0;
  for (double frequency = kFewestCycles / shortest;
       frequency <= 1.0 / kFewestSamplesOfCycle; frequency += step) {
    const double power = Power(problem, residuals, frequency);
    count += 1.0;
    if (power > highest) {
      highest = power;
      best = frequency;
    }
  }
  if (!(count > 0.0) ||
      count * ChiSquareTail(highest, 2 * problem.num_segments()) >
          kFalseAlarm) {
    return std::nullopt;
  }
  return best;
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

// −2 ln L at the fit with a line of each segment's own amplitude. Columns that
// are zero in all segments but one have their own coefficients.
class LineLikelihood {
 public:
  LineLikelihood(const OutputErrorProblem& problem, const OutputFit& fit)
      : problem_(problem),
        fit_(fit),
        columns_(problem.Linearise(fit.point, ShapeOf(fit.noise), true)) {}

  ShapeLikelihood With(const std::vector<MatrixXd>& own) const {
    std::vector<MatrixXd> more;
    for (std::size_t s = 0; s < own.size(); ++s) {
      const Eigen::Index width = own[s].cols();
      MatrixXd& wide = more.emplace_back(MatrixXd::Zero(
          own[s].rows(), width * static_cast<Eigen::Index>(own.size())));
      wide.middleCols(width * static_cast<Eigen::Index>(s), width) = own[s];
    }
    return Shared(more);
  }
  // The same coefficients in all segments.
  ShapeLikelihood Shared(const std::vector<MatrixXd>& more) const {
    return {problem_, columns_, fit_.free, /*restricted=*/false, more};
  }

  // The frequency within `width` of `frequency` that is likeliest at `shape`.
  double Refine(double frequency, double width, const NoiseShape& shape) const {
    return SearchLeast(frequency - width, frequency + width, kRefinementBits,
                       [&](double at) {
                         return With(LineColumns(problem_, at)).At(shape).value;
                       });
  }

 private:
  const OutputErrorProblem& problem_;
  const OutputFit& fit_;
  std::vector<SegmentColumns> columns_;
};

}  // namespace

std::optional<FoundPeriod> FindPeriod(const OutputErrorProblem& problem,
                                      const OutputFit& fit,
                                      bool estimate_drift) {
  if (problem.num_segments() == 0) return std::nullopt;
  const NoiseShape shape = ShapeOf(fit.noise);
  const LineLikelihood likelihood(problem, fit);
  // A resonance would follow the sine: without it.
  const bool resonant =
      shape.colour_damping > 0.0 && shape.colour_damping < 1.0;
  const NoiseShape plain =
      resonant ? FindBestShape(likelihood.Shared({}), NoiseShape(),
                               estimate_drift, /*search_colour=*/false)
                     .shape
               : shape;
  const VectorXd residuals =
      problem.Whiten(problem.Linearise(fit.point, plain, false), plain)
          .residuals;
  const std::optional<double> peak = HighestPeak(problem, residuals);
  if (!peak.has_value()) return std::nullopt;
  double frequency = *peak;
  double width = kStepOfResolution / problem.shortest_segment();
  Profile with;
  with.shape = plain;
  for (int round = 0; round < kRefinements; ++round) {
    frequency = likelihood.Refine(frequency, width, with.shape);
    // A filter that follows the sine must not hide it.
    with = FindBestShape(likelihood.With(LineColumns(problem, frequency)),
                         round == 0 ? NoiseShape() : with.shape, estimate_drift,
                         /*search_colour=*/round == 0);
    width *= 0.5;
  }
  const auto best = [&](const ShapeLikelihood& of) {
    return FindBestShape(of, shape, estimate_drift, /*search_colour=*/true);
  };
  const Profile without = best(likelihood.Shared({}));
  const double gain = PricedValue(problem, without) -
                      PricedValue(problem, with) - LinePrice(problem);
  if (!(gain > 0.0)) return std::nullopt;
  const double of_inputs = GainOfInputs(problem, fit.point, without,
                                        [&](const std::vector<MatrixXd>& more) {
                                          return best(likelihood.Shared(more));
                                        });
  if (!(gain > of_inputs)) return std::nullopt;
  return FoundPeriod{.period = 1.0 / frequency, .gain = gain};
}

}  // namespace mle
