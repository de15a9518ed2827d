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
#include "mle/base/double_limits.h"
#include "mle/nonlinear/change_prior.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/output_fitter.h"

namespace mle {
namespace {

// Elements that are tried, and by how much −2 ln L must be less with others in
// place of those that are named.
constexpr int kMostTried = 3;
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
    // Fits to parts of the records begin at the fit to all of them, which has
    // been compared with the initial values already.
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

  // In units of r, of which an amplitude explains one of any noise, and less
  // likely where parameters have changed by more than they are wont to.
  double Cost(const Minimum& minimum) const {
    double cost = minimum.squares / Scale() + minimum.amplitudes;
    for (std::size_t j = 0; j < fit_.free.size(); ++j) {
      if (!fit_.free[j]) continue;
      const ElementValues& from = setup_.start.values[j];
      const ElementValues& to = minimum.point.values[j];
      cost += Improbability((to.gain - from.gain) / std::abs(from.gain)) +
              Improbability(to.time_scale / from.time_scale - 1.0) +
              Improbability((to.delay - from.delay) /
                            (from.time_scale + from.delay));
    }
    return cost;
  }

  // The squares of the fit with all elements free.
  Minimum OfFit() const { return Evaluate(fit_.point); }

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

// The elements of `among` whose gain alone, all else as it is at `point`,
// explains most of the residuals there, up to kMostTried of them.
std::vector<int> LikeliestGains(const OutputSetup& setup, const OutputFit& fit,
                                const OutputPoint& point,
                                const std::vector<bool>& among) {
  const OutputErrorProblem& problem = *setup.problem;
  const NoiseShape shape = ShapeOf(fit.noise);
  const WhitenedColumns whitened =
      problem.Whiten(problem.Linearise(point, shape, among), shape);
  std::vector<std::pair<double, int>> explained;
  Eigen::Index column = 0;
  for (std::size_t j = 0; j < among.size(); ++j) {
    if (!among[j]) continue;
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
    if (std::ssize(elements) < kMostTried) elements.push_back(-j);
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

// The p-value of F for the parameters of `elements`, for r with as many degrees
// of freedom as their variances have at least; `amplitudes` are fitted besides.
double TailOf(double statistic, int amplitudes, const OutputSetup& setup,
              const OutputFit& fit, const std::vector<bool>& elements) {
  const auto degrees = static_cast<double>(
      setup.problem->FreeParameters(elements).size() + std::max(amplitudes, 0));
  if (!(degrees > 0.0)) return 1.0;
  double of_noise = kInfinity;
  for (std::size_t j = 0; j < elements.size(); ++j) {
    if (!elements[j]) continue;
    const auto first = 3 * static_cast<Eigen::Index>(j);
    of_noise =
        std::min(of_noise, fit.degrees_of_freedom.segment(first, 3).minCoeff());
  }
  return FisherTail(std::max(statistic, 0.0) / degrees, degrees, of_noise);
}

std::vector<bool> OnlyElement(std::size_t j, std::size_t count) {
  std::vector<bool> one(count, false);
  one[j] = true;
  return one;
}

// The critical value for the three parameters of an element.
double CriticalValue(const OutputFit& fit, int j, double false_alarm) {
  const double of_noise = fit.degrees_of_freedom.segment(3 * j, 3).minCoeff();
  return 3.0 * FisherQuantile(false_alarm, 3.0, of_noise);
}

// The elements that have changed, with the fits in which they have, under all
// assumptions; it begins with those that are named.
class Confirmation {
 public:
  Confirmation(const OutputSetup& setup, const std::vector<AssumedFit>& fits,
               const std::vector<bool>& named, const std::vector<bool>& certain,
               double false_alarm, const OutputErrorOptions& options);

  // Adds the element that makes the likeliest fit, if one is worth its critical
  // value; whether it is.
  bool AddLikeliest();
  // The same again and again, while the fit with all elements free is better
  // than chance makes it.
  void AddMissing();
  // Drops elements one by one that may as well be as they were, and are not
  // certain.
  void DropUnchanged();
  // Puts what has changed by likelihood alone, whatever is named, in the place
  // of all where it is the better account.
  void TakeRival();

  ConfirmedChanges Result() const;

 private:
  // The likelihood ratio of two of fits, and its p for what is tested of them.
  struct Ratio {
    double statistic = 0.0;
    double p_value = 1.0;
  };
  Ratio RatioOf(const std::vector<Minimum>& without,
                const std::vector<Minimum>& with,
                const std::vector<bool>& tested) const;
  // The ratio of the fit with all elements free to that of what has changed.
  Ratio Missing() const;

  std::vector<Minimum> FitsWith(const std::vector<bool>& free) const {
    std::vector<Minimum> minima;
    for (std::size_t f = 0; f < fits_.size(); ++f) {
      minima.push_back(squares_[f].At(free, with_[f].point));
    }
    return minima;
  }
  const OutputFit& main_fit() const { return *fits_[main_].fit; }
  double Cost(const Minimum& minimum) const {
    return squares_[main_].Cost(minimum);
  }
  std::vector<bool> Unchanged() const;  // of the free elements
  int NumChanged() const {
    return static_cast<int>(
        std::count(confirmed_.changed.begin(), confirmed_.changed.end(), true));
  }

  const OutputSetup& setup_;
  const std::vector<AssumedFit>& fits_;
  const std::vector<bool>& certain_;
  double false_alarm_;
  const OutputErrorOptions& options_;
  std::size_t main_ = 0;  // the heaviest assumption
  std::vector<SquaresOfFits> squares_;
  std::vector<Minimum> with_;
  std::vector<Minimum> full_;
  ConfirmedChanges confirmed_;
  bool added_ = false;  // an element that was not named
};

Confirmation::Confirmation(const OutputSetup& setup,
                           const std::vector<AssumedFit>& fits,
                           const std::vector<bool>& named,
                           const std::vector<bool>& certain, double false_alarm,
                           const OutputErrorOptions& options)
    : setup_(setup),
      fits_(fits),
      certain_(certain),
      false_alarm_(false_alarm),
      options_(options) {
  const auto heaviest = std::max_element(
      fits.begin(), fits.end(), [](const AssumedFit& a, const AssumedFit& b) {
        return a.weight < b.weight;
      });
  main_ = static_cast<std::size_t>(heaviest - fits.begin());
  confirmed_.changed = named;
  confirmed_.statistics.assign(named.size(), 0.0);
  confirmed_.p_values.assign(named.size(), 1.0);
  for (std::size_t j = 0; j < certain.size(); ++j) {
    if (certain[j]) confirmed_.p_values[j] = 0.0;
  }
  for (const AssumedFit& assumed : fits) {
    const SquaresOfFits& squares =
        squares_.emplace_back(setup, *assumed.fit, options);
    with_.push_back(squares.At(confirmed_.changed, assumed.fit->point));
    full_.push_back(squares.OfFit());
  }
}

Confirmation::Ratio Confirmation::RatioOf(
    const std::vector<Minimum>& without, const std::vector<Minimum>& with,
    const std::vector<bool>& tested) const {
  std::vector<double> statistics;
  for (std::size_t f = 0; f < fits_.size(); ++f) {
    statistics.push_back((without[f].squares - with[f].squares) /
                         squares_[f].Scale());
  }
  Ratio ratio;
  ratio.statistic = Combined(fits_, statistics);
  ratio.p_value = TailOf(ratio.statistic,
                         with[main_].amplitudes - without[main_].amplitudes,
                         setup_, main_fit(), tested);
  return ratio;
}

std::vector<bool> Confirmation::Unchanged() const {
  std::vector<bool> unchanged = main_fit().free;
  for (std::size_t j = 0; j < unchanged.size(); ++j) {
    unchanged[j] = unchanged[j] && !confirmed_.changed[j];
  }
  return unchanged;
}

Confirmation::Ratio Confirmation::Missing() const {
  return RatioOf(with_, full_, Unchanged());
}

bool Confirmation::AddLikeliest() {
  int likeliest = -1;
  double least = Cost(with_[main_]);
  std::vector<Minimum> best;
  for (const int j :
       LikeliestGains(setup_, main_fit(), with_[main_].point, Unchanged())) {
    std::vector<bool> more = confirmed_.changed;
    more[j] = true;
    std::vector<Minimum> minima = FitsWith(more);
    const double cost =
        Cost(minima[main_]) + CriticalValue(main_fit(), j, false_alarm_);
    if (!(cost < least)) continue;
    likeliest = j;
    least = cost;
    best = std::move(minima);
  }
  if (likeliest < 0) return false;
  confirmed_.changed[likeliest] = true;
  with_ = std::move(best);
  added_ = true;
  return true;
}

void Confirmation::AddMissing() {
  const std::vector<bool>& free = main_fit().free;
  const double level = false_alarm_ * static_cast<double>(std::count(
                                          free.begin(), free.end(), true));
  while (Missing().p_value < level && AddLikeliest()) {
  }
}

void Confirmation::DropUnchanged() {
  const std::size_t m = confirmed_.changed.size();
  for (;;) {
    double largest = -1.0;  // p
    std::size_t least = 0;  // the element of which it is
    std::vector<Minimum> without_least;
    for (std::size_t j = 0; j < m; ++j) {
      if (!confirmed_.changed[j] || certain_[j]) continue;
      std::vector<bool> others = confirmed_.changed;
      others[j] = false;
      std::vector<Minimum> without = FitsWith(others);
      const Ratio ratio = RatioOf(without, with_, OnlyElement(j, m));
      confirmed_.statistics[j] = ratio.statistic;
      confirmed_.p_values[j] = ratio.p_value;
      if (ratio.p_value > largest) {
        largest = ratio.p_value;
        least = j;
        without_least = std::move(without);
      }
    }
    if (!(largest >= false_alarm_)) return;
    confirmed_.changed[least] = false;
    with_ = std::move(without_least);
  }
}

void Confirmation::TakeRival() {
  if (confirmed_.changed == certain_) return;
  Confirmation rival(setup_, fits_, certain_, certain_, false_alarm_, options_);
  if (!rival.AddLikeliest()) return;
  rival.AddMissing();
  if (rival.confirmed_.changed == confirmed_.changed) return;
  rival.DropUnchanged();
  const int fewer = NumChanged() - rival.NumChanged();
  if (rival.confirmed_.changed == certain_ || fewer < 0) return;
  const auto first = std::find(rival.confirmed_.changed.begin(),
                               rival.confirmed_.changed.end(), true) -
                     rival.confirmed_.changed.begin();
  const double critical =
      CriticalValue(main_fit(), static_cast<int>(first), false_alarm_);
  if (!(rival.Cost(rival.with_[main_]) <
        Cost(with_[main_]) + critical * fewer - kClearly)) {
    return;
  }
  confirmed_ = std::move(rival.confirmed_);
  with_ = std::move(rival.with_);
  added_ = true;
}

ConfirmedChanges Confirmation::Result() const {
  ConfirmedChanges confirmed = confirmed_;
  confirmed.point = with_[main_].point;
  confirmed.restarted = added_ || with_[main_].restarted;
  return confirmed;
}

}  // namespace

ConfirmedChanges ConfirmChanges(const OutputSetup& setup,
                                const std::vector<AssumedFit>& fits,
                                const std::vector<bool>& named,
                                const std::vector<bool>& certain,
                                double false_alarm,
                                const OutputErrorOptions& options) {
  Confirmation confirmation(setup, fits, named, certain, false_alarm, options);
  confirmation.AddMissing();
  confirmation.DropUnchanged();
  confirmation.TakeRival();
  return confirmation.Result();
}

}  // namespace mle
