#include "mle/nonlinear/change_confirmation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/output_fitter.h"

namespace mle {
namespace {

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
  confirmed.point = with[main].point;
  confirmed.restarted = with[main].restarted;
  return confirmed;
}

}  // namespace mle
