#include "mle/nonlinear/noise_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/QR"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The range of ρ, as ln ρ. Below it drift is less than a sample's noise in
// 10⁵ samples, above it white noise is none. σ has the same.
const double kMinLogRatio = std::log(1e-10);
const double kMaxLogRatio = std::log(1e6);
constexpr double kGridStep = 1.0;
constexpr double kTolerance = 1e-3;

// Beforehand every √ρ is as likely as any other: what of it is nearest to a
// value of the grid, as a share of √ρ there; and below the smallest, of that.
const double kShareOfValue =
    std::exp(0.25 * kGridStep) - std::exp(-0.25 * kGridStep);
const double kShareBelow = std::exp(-0.25 * kGridStep);

// −1/ln φ of the fastest colour, in samples: below, it is white.
constexpr double kShortestMemory = 0.8;
constexpr double kLongestShare = 1.0 / 3.0;  // of the shortest segment
// The coarse grid of colours.
constexpr double kMemoryStep = 4.0;  // factor of −1/ln φ
constexpr double kColourStep = 2.5;  // of ln σ
// Of the stationary variance over that of the white part, the least.
constexpr double kLeastColour = 0.02;
// From where it was before.
constexpr double kLocalStep = 0.25;
// A smaller difference of −2 ln L does not count.
constexpr double kNoGain = 0.01;

// ln ρ, ln σ and ln(−1/ln φ).
using LogShape = std::array<double, 3>;

}  // namespace

double Profile::variance() const {
  return factor * squares / std::max(degrees, 1.0);
}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const OutputPoint& point,
                                 const std::vector<bool>& free,
                                 const NoiseShape& start, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : ShapeLikelihood(problem, problem.Linearise(point, start, true), free,
                      restricted, more) {}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 std::vector<SegmentColumns> columns,
                                 const std::vector<bool>& free, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : problem_(problem), columns_(std::move(columns)), restricted_(restricted) {
  std::vector<int> kept;
  for (std::size_t j = 0; j < free.size(); ++j) {
    for (int i = 0; free[j] && i < 3; ++i) {
      kept.push_back(3 * static_cast<int>(j) + i);
    }
  }
  for (std::size_t s = 0; s < columns_.size(); ++s) {
    MatrixXd jacobian = columns_[s].jacobian(Eigen::all, kept);
    const Eigen::Index width = jacobian.cols();
    if (!more.empty()) {
      jacobian.conservativeResize(Eigen::NoChange, width + more[s].cols());
      jacobian.rightCols(more[s].cols()) = more[s];
    }
    columns_[s].jacobian = std::move(jacobian);
  }
}

Profile ShapeLikelihood::At(const NoiseShape& shape) const {
  const WhitenedColumns whitened = problem_.Whiten(columns_, shape);
  Profile profile;
  profile.shape = shape;
  profile.factor = problem_.variance_factor();
  profile.squares = whitened.residuals.squaredNorm();
  double log_jacobian = 0.0;
  Eigen::Index rank = 0;
  if (whitened.jacobian.cols() > 0) {
    // By normal equations: fast, and good enough for a first-order term.
    const VectorXd inverse_norms =
        whitened.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const MatrixXd jacobian = whitened.jacobian * inverse_norms.asDiagonal();
    const MatrixXd normal = jacobian.transpose() * jacobian;
    const VectorXd gradient = jacobian.transpose() * whitened.residuals;
    Eigen::ColPivHouseholderQR<MatrixXd> qr;
    qr.setThreshold(1e-12);
    qr.compute(normal);
    rank = qr.rank();
    profile.rank = static_cast<int>(rank);
    for (Eigen::Index i = 0; i < rank; ++i) {
      log_jacobian += std::log(std::abs(qr.matrixQR()(i, i)));
    }
    log_jacobian -= 2.0 * inverse_norms.array().log().sum();
    // By rank: a solve by pivots would take rounding for a direction.
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
    decomposition.setThreshold(1e-12);
    decomposition.compute(normal);
    profile.squares -=
        std::min(profile.squares, gradient.dot(decomposition.solve(gradient)));
  }
  // Exact data leave rounding, which has no likelihood.
  profile.squares =
      std::max({profile.squares, 1e-26 * problem_.total_squares(), 1e-300});
  const double n = problem_.num_innovations(shape);
  profile.degrees = n - whitened.num_amplitudes - static_cast<double>(rank);
  profile.value = whitened.log_determinant;
  if (restricted_) {
    profile.value += profile.degrees * std::log(profile.variance()) +
                     whitened.log_amplitudes + log_jacobian;
  } else {
    profile.value += n * std::log(profile.squares / n);
  }
  return profile;
}

double MemoryOf(double pole) { return -1.0 / std::log(pole); }

double PoleOf(double memory) { return std::exp(-1.0 / memory); }

std::vector<PossibleRatio> PossibleRatios(const OutputErrorProblem& problem) {
  const double length = static_cast<double>(problem.num_samples()) /
                        static_cast<double>(problem.num_segments());
  std::vector<PossibleRatio> ratios = {{0.0, kShareBelow / length}};
  for (double log_ratio = -2.0 * std::log(length); log_ratio <= kMaxLogRatio;
       log_ratio += kGridStep) {
    ratios.push_back(
        {std::exp(log_ratio), kShareOfValue * std::exp(0.5 * log_ratio)});
  }
  return ratios;
}

bool HasParameter(const NoiseShape& shape, int parameter) {
  return parameter == 0 ? shape.ratio > 0.0 : shape.coloured();
}

NoiseShape Moved(const NoiseShape& shape, int parameter, double by) {
  const double factor = std::exp(by);
  NoiseShape moved = shape;
  if (parameter == 0) moved.ratio *= factor;
  if (parameter == 1) moved.colour_ratio *= factor;
  if (parameter == 2) {
    moved.colour_pole = PoleOf(MemoryOf(shape.colour_pole) * factor);
  }
  return moved;
}

double LongestColour(const OutputErrorProblem& problem) {
  return std::max(kLongestShare * problem.shortest_segment(), kShortestMemory);
}

namespace {

Profile AtLogRatio(const ShapeLikelihood& likelihood, double log_ratio) {
  return likelihood.At({.ratio = std::exp(log_ratio)});
}

// Golden-section search between two values of ln ρ.
Profile SearchBetween(const ShapeLikelihood& likelihood, double low,
                      double high) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double left = high - golden * (high - low);
  double right = low + golden * (high - low);
  Profile at_left = AtLogRatio(likelihood, left);
  Profile at_right = AtLogRatio(likelihood, right);
  while (high - low > kTolerance) {
    if (at_left.value < at_right.value) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = AtLogRatio(likelihood, left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = AtLogRatio(likelihood, right);
    }
  }
  return at_left.value < at_right.value ? at_left : at_right;
}

// Over all ρ, without colour.
Profile FindBestRatio(const ShapeLikelihood& likelihood) {
  Profile best = likelihood.At(NoiseShape());
  double best_log = kMinLogRatio;
  for (double log_ratio = kMinLogRatio; log_ratio <= kMaxLogRatio;
       log_ratio += kGridStep) {
    const Profile profile = AtLogRatio(likelihood, log_ratio);
    if (profile.value < best.value) {
      best = profile;
      best_log = log_ratio;
    }
  }
  const Profile inner =
      SearchBetween(likelihood, best_log - kGridStep, best_log + kGridStep);
  return inner.value < best.value ? inner : best;
}

// Shapes with colour about a point of (ln ρ, ln σ, ln(−1/ln φ)).
class ColourSearch {
 public:
  explicit ColourSearch(const ShapeLikelihood& likelihood)
      : likelihood_(likelihood),
        longest_(LongestColour(likelihood.problem())) {}

  // The best of a coarse grid: without a walk, and with one as in `walk`.
  Profile OfGrid(const NoiseShape& walk) const {
    std::vector<double> ratios = {0.0};
    if (walk.ratio > 0.0) ratios.push_back(walk.ratio);
    Profile best;
    for (double memory = kShortestMemory; memory <= longest_ * (1.0 + 1e-9);
         memory *= kMemoryStep) {
      const double pole = PoleOf(memory);
      for (double log = std::log(kLeastColour * (1.0 - pole * pole));
           log < kMaxLogRatio; log += kColourStep) {
        for (const double ratio : ratios) {
          const Profile profile = likelihood_.At({.ratio = ratio,
                                                  .colour_ratio = std::exp(log),
                                                  .colour_pole = pole});
          if (profile.value < best.value) best = profile;
        }
      }
    }
    return best;
  }

  // Nelder and Mead's simplex (Computer Journal 7, 1965) from `start`, whose
  // colour is positive, and the same without a walk.
  Profile From(const Profile& start, double step) const;

 private:
  struct Vertex {
    LogShape x;
    Profile profile;
  };

  Vertex AtLog(LogShape x) const {
    for (int i = 0; i < 2; ++i) {
      x[i] = std::clamp(x[i], kMinLogRatio, kMaxLogRatio);
    }
    x[2] = std::clamp(x[2], std::log(kShortestMemory), std::log(longest_));
    return {x, likelihood_.At({.ratio = std::exp(x[0]),
                               .colour_ratio = std::exp(x[1]),
                               .colour_pole = PoleOf(std::exp(x[2]))})};
  }

  std::vector<Vertex> SimplexAt(const LogShape& x, double step) const {
    std::vector<Vertex> simplex = {AtLog(x)};
    for (int i = 0; i < 3; ++i) {
      LogShape moved = x;
      // Away from the longest memory, and towards less of a walk.
      moved[i] += i == 1 ? step : -step;
      simplex.push_back(AtLog(moved));
    }
    return simplex;
  }

  const ShapeLikelihood& likelihood_;
  double longest_;
};

Profile ColourSearch::From(const Profile& start, double step) const {
  constexpr int kMostEvaluations = 150;
  const double log_colour = std::log(start.shape.colour_ratio);
  // A walk too small to matter still has a slope.
  const double log_ratio =
      std::log(std::max(start.shape.ratio, 1e-3 * start.shape.colour_ratio));
  std::vector<Vertex> simplex = SimplexAt(
      {log_ratio, log_colour, std::log(MemoryOf(start.shape.colour_pole))},
      step);
  const auto better = [](const Vertex& a, const Vertex& b) {
    return a.profile.value < b.profile.value;
  };
  for (int evaluations = 4; evaluations < kMostEvaluations;) {
    std::sort(simplex.begin(), simplex.end(), better);
    if (simplex[3].profile.value - simplex[0].profile.value < 0.1 * kNoGain) {
      break;
    }
    const auto along = [&](double factor) {
      LogShape at;
      for (int i = 0; i < 3; ++i) {
        const double centre =
            (simplex[0].x[i] + simplex[1].x[i] + simplex[2].x[i]) / 3.0;
        at[i] = centre + factor * (simplex[3].x[i] - centre);
      }
      ++evaluations;
      return AtLog(at);
    };
    const Vertex reflected = along(-1.0);
    if (better(reflected, simplex[0])) {
      const Vertex expanded = along(-2.0);
      simplex[3] = better(expanded, reflected) ? expanded : reflected;
      continue;
    }
    if (better(reflected, simplex[2])) {
      simplex[3] = reflected;
      continue;
    }
    const Vertex contracted = along(better(reflected, simplex[3]) ? -0.5 : 0.5);
    if (better(contracted, simplex[3]) && better(contracted, reflected)) {
      simplex[3] = contracted;
      continue;
    }
    for (int v = 1; v < 4; ++v) {
      for (int i = 0; i < 3; ++i) {
        simplex[v].x[i] = 0.5 * (simplex[v].x[i] + simplex[0].x[i]);
      }
      simplex[v] = AtLog(simplex[v].x);
      ++evaluations;
    }
  }
  Profile best =
      std::min_element(simplex.begin(), simplex.end(), better)->profile;
  NoiseShape still = best.shape;
  still.ratio = 0.0;
  const Profile without_walk = likelihood_.At(still);
  return without_walk.value < best.value + kNoGain ? without_walk : best;
}

}  // namespace

Profile FindBestShape(const ShapeLikelihood& likelihood,
                      const NoiseShape& start, bool estimate_drift,
                      bool search_colour) {
  if (!estimate_drift) return likelihood.At(NoiseShape());
  Profile plain;
  if (!start.coloured() || search_colour) plain = FindBestRatio(likelihood);
  if (!start.coloured() && !search_colour) return plain;
  const ColourSearch search(likelihood);
  Profile coloured;
  if (start.coloured()) {
    const Profile former = likelihood.At(start);
    coloured = search.From(former, kLocalStep);
    if (!(coloured.value < former.value - kNoGain)) coloured = former;
  } else {
    coloured = search.From(search.OfGrid(plain.shape), kGridStep);
  }
  const double price =
      2.0 * std::log(likelihood.problem().num_innovations(plain.shape));
  return coloured.value + price < plain.value ? coloured : plain;
}

}  // namespace mle
