#include "mle/nonlinear/change_confirmation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/output_fitter.h"

namespace mle {
namespace {

// Elements that are tried alone in place of those that are named, and by how
// much −2 ln L must be less.
constexpr int kMostRivals = 3;
constexpr double kClearly = 6.0;

// A minimum of the squares with some elements free.
struct Minimum {
  OutputPoint point;
  double squares = std::numeric_limits<double>::infinity();
  int amplitudes = 0;      // that were fitted besides
  bool restarted = false;  // found from the initial values
};

class SquaresOfFits {
 public:
  SquaresOfFits(const OutputSetup& setup, const OutputFit& fit,
                const OutputErrorOptions& options)
      : setup_(setup), fit_(fit), options_(options) {}

  // From the values of `near`, and from the initial ones.
  Minimum At(const std::vector<bool>& free, const OutputPoint& near) const {
    if (std::find(free.begin(), free.end(), true) == free.end()) {
      return Evaluate(setup_.start);
    }
    Minimum best = From(near, free);
    // Of parts of the records that has been asked of all of them.
    if (options_.start != nullptr) return best;
    Minimum other = From(setup_.start, free);
    // An amplitude more explains r of any noise; less than that is no reason
    // to begin elsewhere.
    const double r = Scale();
    if (other.squares + r * (other.amplitudes + 1) <
        best.squares + r * best.amplitudes) {
      other.restarted = true;
      return other;
    }
    return best;
  }

  // r, raised by what correlation that is left does to likelihood ratios.
  double Scale() const {
    return fit_.noise.variance * fit_.inflation.statistic;
  }

 private:
  Minimum From(const OutputPoint& start, const std::vector<bool>& free) const {
    OutputPoint point = setup_.start;
    for (std::size_t j = 0; j < free.size(); ++j) {
      if (free[j]) point.values[j] = start.values[j];
    }
    point.SetCells(setup_.problem->sample_time());
    Fitter fitter(*setup_.problem, free, setup_.bounds, options_);
    fitter.RefineRoughly(point, ShapeOf(fit_.noise), /*near=*/false);
    return Evaluate(point);
  }

  Minimum Evaluate(const OutputPoint& point) const {
    const OutputErrorProblem& problem = *setup_.problem;
    const NoiseShape shape = ShapeOf(fit_.noise);
    const std::vector<bool> none(fit_.free.size(), false);
    const WhitenedColumns whitened =
        problem.Whiten(problem.Linearise(point, shape, none), shape);
    return {.point = point,
            .squares = whitened.residuals.squaredNorm(),
            .amplitudes = whitened.num_amplitudes};
  }

  const OutputSetup& setup_;
  const OutputFit& fit_;
  const OutputErrorOptions& options_;
};

// The elements whose gain alone, all else as it was, explains most of the
// residuals of the initial model, up to `most` of them.
std::vector<int> LikeliestGains(const OutputSetup& setup, const OutputFit& fit,
                                int most) {
  const OutputErrorProblem& problem = *setup.problem;
  const NoiseShape shape = ShapeOf(fit.noise);
  const WhitenedColumns whitened =
      problem.Whiten(problem.Linearise(setup.start, shape, fit.free), shape);
  std::vector<std::pair<double, int>> explained;
  Eigen::Index column = 0;
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    if (!fit.free[j]) continue;
    const auto of_gain = whitened.jacobian.col(column);
    column += 3;
    const double product = of_gain.dot(whitened.residuals);
    explained.emplace_back(
        product * product / std::max(of_gain.squaredNorm(), 1e-300),
        -static_cast<int>(j));
  }
  std::sort(explained.rbegin(), explained.rend());
  std::vector<int> elements;
  for (const auto& [squares, j] : explained) {
    if (std::ssize(elements) < most) elements.push_back(-j);
  }
  return elements;
}

// −2 ln Σ w exp(−S/2).
double Combined(const std::vector<AssumedFit>& fits,
                const std::vector<double>& statistics) {
  const double least = *std::min_element(statistics.begin(), statistics.end());
  const double sum = std::transform_reduce(
      fits.begin(), fits.end(), statistics.begin(), 0.0, std::plus<>(),
      [least](const AssumedFit& fit, double statistic) {
        return fit.weight * std::exp(-0.5 * (statistic - least));
      });
  return least - 2.0 * std::log(sum);
}

// Of F, for r with as many degrees of freedom as the element's variances have;
// `amplitudes` are fitted besides the element's parameters.
double TailOf(double statistic, int amplitudes, const OutputSetup& setup,
              const OutputFit& fit, int j) {
  std::vector<bool> one(fit.free.size(), false);
  one[j] = true;
  const auto degrees = static_cast<double>(
      setup.problem->FreeParameters(one).size() + std::max(amplitudes, 0));
  const double of_noise = fit.degrees_of_freedom.segment(3 * j, 3).minCoeff();
  return FisherTail(statistic / degrees, degrees, of_noise);
}

// The element whose change alone is a better account than those that have
// changed, with their minimum; -1: there is none, or nothing has changed.
int RivalOf(const OutputSetup& setup, const OutputFit& fit,
            const SquaresOfFits& squares, const Minimum& with,
            const std::vector<bool>& changed, double false_alarm) {
  // An amplitude explains r of any noise.
  const auto cost = [&](const Minimum& minimum) {
    return minimum.squares / squares.Scale() + minimum.amplitudes;
  };
  const auto count =
      static_cast<double>(std::count(changed.begin(), changed.end(), true));
  int rival = -1;
  if (count == 0.0) return rival;
  double least = cost(with);
  for (const int j : LikeliestGains(setup, fit, kMostRivals)) {
    if (count == 1.0 && changed[j]) continue;
    std::vector<bool> one(changed.size(), false);
    one[j] = true;
    const double of_noise = fit.degrees_of_freedom.segment(3 * j, 3).minCoeff();
    const double critical = 3.0 * FisherQuantile(false_alarm, 3.0, of_noise);
    const double alone = cost(squares.At(one, setup.start));
    const double limit =
        rival < 0 ? least + critical * (count - 1.0) - kClearly : least;
    if (!(alone < limit)) continue;
    rival = j;
    least = alone;
  }
  return rival;
}

}  // namespace

ConfirmedChanges ConfirmChanges(const OutputSetup& setup,
                                const std::vector<AssumedFit>& fits,
                                const std::vector<bool>& named,
                                double false_alarm,
                                const OutputErrorOptions& options) {
  const auto heaviest = std::max_element(
      fits.begin(), fits.end(), [](const AssumedFit& a, const AssumedFit& b) {
        return a.weight < b.weight;
      });
  const auto main = static_cast<std::size_t>(heaviest - fits.begin());
  std::vector<SquaresOfFits> squares;
  std::vector<Minimum> with;
  for (const AssumedFit& assumed : fits) {
    squares.emplace_back(setup, *assumed.fit, options);
    with.push_back(squares.back().At(named, assumed.fit->point));
  }
  ConfirmedChanges confirmed;
  confirmed.changed = named;
  confirmed.statistics.assign(named.size(), 0.0);
  confirmed.p_values.assign(named.size(), 1.0);
  for (;;) {
    double largest = -1.0;  // p
    std::size_t least = 0;  // the element of which it is
    std::vector<Minimum> without_least;
    for (std::size_t j = 0; j < named.size(); ++j) {
      if (!confirmed.changed[j]) continue;
      std::vector<bool> others = confirmed.changed;
      others[j] = false;
      std::vector<Minimum> without;
      std::vector<double> statistics;
      for (std::size_t f = 0; f < fits.size(); ++f) {
        without.push_back(squares[f].At(others, with[f].point));
        statistics.push_back((without[f].squares - with[f].squares) /
                             squares[f].Scale());
      }
      confirmed.statistics[j] = Combined(fits, statistics);
      confirmed.p_values[j] =
          TailOf(confirmed.statistics[j],
                 with[main].amplitudes - without[main].amplitudes, setup,
                 *fits[main].fit, static_cast<int>(j));
      if (confirmed.p_values[j] > largest) {
        largest = confirmed.p_values[j];
        least = j;
        without_least = std::move(without);
      }
    }
    if (!(largest >= false_alarm)) break;
    confirmed.changed[least] = false;
    with = std::move(without_least);
  }
  const int rival = RivalOf(setup, *fits[main].fit, squares[main], with[main],
                            confirmed.changed, false_alarm);
  if (rival >= 0) {
    confirmed.changed.assign(named.size(), false);
    const std::vector<bool> none = confirmed.changed;
    confirmed.changed[rival] = true;
    std::vector<double> statistics;
    int amplitudes = 0;
    for (std::size_t f = 0; f < fits.size(); ++f) {
      const Minimum without = squares[f].At(none, setup.start);
      with[f] = squares[f].At(confirmed.changed, setup.start);
      with[f].restarted = true;
      statistics.push_back((without.squares - with[f].squares) /
                           squares[f].Scale());
      if (f == main) amplitudes = with[f].amplitudes - without.amplitudes;
    }
    confirmed.statistics[rival] = Combined(fits, statistics);
    confirmed.p_values[rival] = TailOf(confirmed.statistics[rival], amplitudes,
                                       setup, *fits[main].fit, rival);
    confirmed.changed[rival] = confirmed.p_values[rival] < false_alarm;
  }
  confirmed.point = with[main].point;
  confirmed.restarted = with[main].restarted;
  return confirmed;
}

}  // namespace mle
