#include "mle/nonlinear/shape_posterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "mle/nonlinear/linear_evidence.h"
#include "mle/nonlinear/noise_search.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// σ: the standard deviation of the gain that h adds, in what it is measured by.
constexpr std::array<double, 7> kShapes = {0.01, 0.03, 0.1, 0.3,
                                           1.0,  3.0,  10.0};
// τ in time scales; the standard deviation of h falls e-fold in 2τ.
constexpr std::array<double, 4> kDecays = {0.25, 0.5, 1.0, 2.0};
// Standard deviations of K (in gains), ln T and L (in T + L) of an element
// that has changed.
constexpr double kGainDeviation = 1.0;
constexpr double kLogTimeDeviation = 0.7;
constexpr double kDelayDeviation = 0.5;
// −2 ln prior odds of a change of K, T, L; of a shape, each scale alike; and of
// a pair that is not in the model.
const double kParameterCost = 2.0 * std::log(4.0);
const double kShapeCost =
    2.0 * std::log(19.0) + 2.0 * std::log(static_cast<double>(kShapes.size()));
const double kPairCost =
    2.0 * std::log(99.0) + 2.0 * std::log(static_cast<double>(kShapes.size()));

constexpr int kMaxShapeRounds = 6;
constexpr int kMaxShapeMoves = 24;
constexpr int kNoiseSteps = 3;
constexpr double kLogRatioStep = 1.0;
constexpr double kLeastRatio = 1e-10;
constexpr double kMostRatio = 1e6;
constexpr double kPosteriorTolerance =
    1e-3;  // of deviances and of steps in deviations
// Largest step of ln T, and of L in samples or shares of T, in a round.
constexpr double kMaxLogStep = 0.5;

struct State {
  std::vector<ElementChoice> choices;
  double decay = 1.0;
};

class Search {
 public:
  Search(const OutputErrorProblem& problem,
         const std::vector<ElementPrior>& priors,
         const std::vector<int>& first_lags, const OutputFitBounds& bounds)
      : problem_(problem),
        priors_(priors),
        first_lags_(first_lags),
        bounds_(bounds),
        sums_(problem.LagSums(first_lags)) {
    Accumulate();
  }

  OutputPosterior Run(OutputPoint point, NoiseEstimate noise, State state,
                      bool estimate_drift) {
    OutputPosterior best;
    best.deviance = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kMaxShapeRounds; ++round) {
      const ShapeLikelihood columns = Linearise(point, ShapeOf(noise));
      LinearEvidence evidence = Evidence(columns, ShapeOf(noise));
      Improve(evidence, point, noise.variance, state);
      if (estimate_drift && noise.offset) {
        EstimateRatio(columns, point, state, noise);
        evidence = Evidence(columns, ShapeOf(noise));
      }
      noise.variance = Variance(evidence, point, state, noise.variance);
      Improve(evidence, point, noise.variance, state);
      const LinearPosterior posterior =
          evidence.Posterior(PriorOf(point, state), noise.variance);
      const double deviance = posterior.deviance + Cost(state);
      // Rounding in place of data, or columns that are one.
      if (!std::isfinite(deviance) || !posterior.means.allFinite()) break;
      const bool better = deviance < best.deviance - kPosteriorTolerance;
      if (deviance < best.deviance) {
        best.point = point;
        best.noise = noise;
        best.choices = state.choices;
        best.decay = state.decay;
        best.first_lags = first_lags_;
        best.means = posterior.means;
        best.covariance = posterior.covariance;
        best.deviance = deviance;
        Weigh(evidence, point, state, best);
      }
      if (!better && round > 0) break;
      point = Moved(point, posterior.means);
    }
    return best;
  }

 private:
  Eigen::Index num_ranges() const {
    return static_cast<Eigen::Index>(first_lags_.size()) - 1;
  }
  Eigen::Index num_elements() const {
    return static_cast<Eigen::Index>(priors_.size());
  }

  // Sums over ranges become those from the first lag of their element on.
  void Accumulate() {
    const Eigen::Index ranges = num_ranges();
    for (MatrixXd& sums : sums_) {
      for (Eigen::Index j = 0; j < num_elements(); ++j) {
        for (Eigen::Index b = 0; b < ranges; ++b) {
          auto column = sums.col(j * ranges + b);
          if (first_lags_[b] < priors_[j].first_lag) {
            column.setZero();
          } else if (b > 0) {
            column += sums.col(j * ranges + b - 1);
          }
        }
      }
    }
  }

  ShapeLikelihood Linearise(const OutputPoint& point,
                            const NoiseShape& shape) const {
    return ShapeLikelihood(problem_, point,
                           std::vector<bool>(priors_.size(), true), shape,
                           /*restricted=*/true)
        .With(sums_);
  }

  // Derivatives are those of the response: less those of the residuals.
  LinearEvidence Evidence(const ShapeLikelihood& columns,
                          const NoiseShape& shape) const {
    ShapedProducts shaped = columns.ProductsAt(shape);
    const Eigen::Index width = shaped.products.cols() - 1;
    const Eigen::Index derivatives = 3 * num_elements();
    MatrixXd gram = shaped.products.topLeftCorner(width, width);
    VectorXd products = shaped.products.col(width).head(width);
    const Eigen::Index sums = width - derivatives;
    gram.topRightCorner(derivatives, sums) *= -1.0;
    gram.bottomLeftCorner(sums, derivatives) *= -1.0;
    products.head(derivatives) *= -1.0;
    return LinearEvidence(
        std::move(gram), std::move(products), shaped.products(width, width),
        problem_.num_innovations(shape) - shaped.num_amplitudes,
        shaped.log_determinant + shaped.log_amplitudes);
  }

  LinearPrior PriorOf(const OutputPoint& point, const State& state) const {
    const Eigen::Index m = num_elements();
    const Eigen::Index ranges = num_ranges();
    LinearPrior prior = {VectorXd::Zero((3 + ranges) * m),
                         VectorXd::Zero((3 + ranges) * m)};
    for (Eigen::Index j = 0; j < m; ++j) {
      const ElementPrior& element = priors_[j];
      const ElementChoice& choice = state.choices[j];
      if (element.present) {
        const ElementValues& now = point.values[j];
        prior.means.segment(3 * j, 3) << element.values.gain - now.gain,
            std::log(element.values.time_scale / now.time_scale),
            element.values.delay - now.delay;
        if (choice.parameters) {
          prior.variances.segment(3 * j, 3)
              << std::pow(kGainDeviation * element.gain_scale, 2),
              std::pow(kLogTimeDeviation, 2),
              std::pow(kDelayDeviation *
                           (element.values.time_scale + element.values.delay),
                       2);
        }
      }
      if (choice.shape > 0.0) {
        prior.variances.segment(3 * m + j * ranges, ranges) =
            Increments(element, choice.shape, state.decay);
      }
    }
    return prior;
  }

  // Var of h(l) is v β^l, that of its gain then 2 v τ²: the increments of h
  // between the first lags of two ranges have the difference.
  VectorXd Increments(const ElementPrior& element, double shape,
                      double decay) const {
    const double tau = decay * element.time_scale / problem_.sample_time();
    const double variance =
        std::pow(shape * element.shape_scale, 2) / (2.0 * tau * tau);
    VectorXd variances = VectorXd::Zero(num_ranges());
    for (Eigen::Index b = 0; b < num_ranges(); ++b) {
      const auto from = [&](int lag) {
        return std::exp(-(lag - element.first_lag) / tau);
      };
      if (first_lags_[b] < element.first_lag) continue;
      const double end = b + 1 < num_ranges() ? from(first_lags_[b + 1]) : 0.0;
      variances(b) = variance * (from(first_lags_[b]) - end);
    }
    return variances;
  }

  double Cost(const State& state) const {
    double cost = 0.0;
    for (std::size_t j = 0; j < priors_.size(); ++j) {
      if (state.choices[j].parameters) cost += kParameterCost;
      if (state.choices[j].shape > 0.0) {
        cost += priors_[j].present ? kShapeCost : kPairCost;
      }
    }
    return cost;
  }

  double Deviance(const LinearEvidence& evidence, const OutputPoint& point,
                  const State& state, double variance) const {
    return evidence.Deviance(PriorOf(point, state), variance) + Cost(state);
  }

  // The best of all single moves (another choice of an element, another decay),
  // as long as one helps: the order of the inputs decides nothing.
  void Improve(const LinearEvidence& evidence, const OutputPoint& point,
               double variance, State& state) const {
    double best = Deviance(evidence, point, state, variance);
    const auto better = [&](const State& other) {
      const double deviance = Deviance(evidence, point, other, variance);
      if (deviance >= best - kPosteriorTolerance) return false;
      best = deviance;
      return true;
    };
    for (int move = 0; move < kMaxShapeMoves; ++move) {
      const double before = best;
      State next = state;
      for (std::size_t j = 0; j < priors_.size(); ++j) {
        if (!priors_[j].informed) continue;
        State other = state;
        for (const bool parameters : {false, true}) {
          if (parameters && !priors_[j].present) continue;
          other.choices[j] = {parameters, 0.0};
          if (better(other)) next = other;
          for (const double shape : kShapes) {
            other.choices[j].shape = shape;
            if (better(other)) next = other;
          }
        }
      }
      State other = state;
      for (const double decay : kDecays) {
        other.decay = decay;
        if (better(other)) next = other;
      }
      if (best > before - kPosteriorTolerance) break;
      state = std::move(next);
    }
  }

  double Variance(const LinearEvidence& evidence, const OutputPoint& point,
                  const State& state, double variance) const {
    const LinearPrior prior = PriorOf(point, state);
    for (int step = 0; step < kNoiseSteps; ++step) {
      variance = evidence.Posterior(prior, variance).next_noise_variance;
    }
    return variance;
  }

  // The best ratio of drift, in steps from the present one.
  void EstimateRatio(const ShapeLikelihood& columns, const OutputPoint& point,
                     const State& state, NoiseEstimate& noise) const {
    const auto at = [&](double ratio, double& variance) {
      NoiseShape shape = ShapeOf(noise);
      shape.ratio = ratio;
      const LinearEvidence evidence = Evidence(columns, shape);
      variance = Variance(evidence, point, state, variance);
      return Deviance(evidence, point, state, variance);
    };
    double variance = noise.variance;
    double best = at(noise.ratio, variance);
    noise.variance = variance;
    for (const double direction : {-kLogRatioStep, kLogRatioStep}) {
      double ratio = std::max(noise.ratio, kLeastRatio);
      while (true) {
        ratio *= std::exp(direction);
        if (ratio < kLeastRatio || ratio > kMostRatio) break;
        double moved = noise.variance;
        const double deviance = at(ratio, moved);
        if (deviance >= best) break;
        best = deviance;
        noise.ratio = ratio;
        noise.variance = moved;
      }
    }
  }

  OutputPoint Moved(const OutputPoint& point, const VectorXd& means) const {
    OutputPoint moved = point;
    for (std::size_t j = 0; j < priors_.size(); ++j) {
      if (!priors_[j].present) continue;
      const auto change = means.segment(3 * static_cast<Eigen::Index>(j), 3);
      ElementValues& values = moved.values[j];
      values.gain += change(0);
      values.time_scale = std::clamp(
          values.time_scale *
              std::exp(std::clamp(change(1), -kMaxLogStep, kMaxLogStep)),
          bounds_.min_time_scales[j], bounds_.max_time_scales[j]);
      values.delay =
          std::clamp(values.delay + change(2), 0.0, bounds_.max_delays[j]);
    }
    moved.SetCells(problem_.sample_time());
    return moved;
  }

  // Weighs each choice, the others as they are.
  void Weigh(const LinearEvidence& evidence, const OutputPoint& point,
             const State& state, OutputPosterior& posterior) const {
    const double now =
        Deviance(evidence, point, state, posterior.noise.variance);
    posterior.change_evidence.assign(priors_.size(), 0.0);
    posterior.shape_evidence.assign(priors_.size(), 0.0);
    for (std::size_t j = 0; j < priors_.size(); ++j) {
      const auto without = [&](ElementChoice choice) {
        State other = state;
        other.choices[j] = choice;
        return Deviance(evidence, point, other, posterior.noise.variance) - now;
      };
      posterior.change_evidence[j] = without({});
      posterior.shape_evidence[j] = without({state.choices[j].parameters, 0.0});
    }
  }

  const OutputErrorProblem& problem_;
  const std::vector<ElementPrior>& priors_;
  const std::vector<int>& first_lags_;
  const OutputFitBounds& bounds_;
  std::vector<MatrixXd> sums_;  // of each segment, rows × (m · ranges)
};

State Fitted(const OutputFit& start) {
  State state;
  for (const bool free : start.free) state.choices.push_back({free, 0.0});
  return state;
}

State Nothing(std::size_t elements) {
  State state;
  state.choices.assign(elements, {false, 0.0});
  return state;
}

OutputPoint InitialPoint(const OutputErrorProblem& problem,
                         const std::vector<ElementPrior>& priors,
                         const OutputFit& start) {
  OutputPoint initial = start.point;
  for (std::size_t j = 0; j < priors.size(); ++j) {
    if (priors[j].present) initial.values[j] = priors[j].values;
  }
  initial.SetCells(problem.sample_time());
  return initial;
}

}  // namespace

bool OutputPosterior::HasShape() const {
  return std::any_of(choices.begin(), choices.end(),
                     [](const ElementChoice& c) { return c.shape > 0.0; });
}

OutputPosterior FindPosterior(const OutputErrorProblem& problem,
                              const std::vector<ElementPrior>& priors,
                              const std::vector<int>& first_lags,
                              const OutputFitBounds& bounds,
                              const OutputFit& start, bool estimate_drift) {
  Search search(problem, priors, first_lags, bounds);
  const State fitted = Fitted(start);
  const State none = Nothing(priors.size());
  const OutputPoint initial = InitialPoint(problem, priors, start);
  OutputPosterior from_fit =
      search.Run(start.point, start.noise, fitted, estimate_drift);
  if (start.noise.colour_ratio > 0.0) {
    // A lack of the structure may have been taken for an AR component. That
    // this has parameters of its own does not count: a disturbance is likelier.
    NoiseEstimate plain = start.noise;
    plain.colour_ratio = 0.0;
    OutputPosterior without =
        search.Run(start.point, plain, fitted, estimate_drift);
    if (without.HasShape() && without.deviance < from_fit.deviance) {
      from_fit = std::move(without);
    }
  }
  // Where the structure suffices, the fit is where the initial values lead to.
  if (!from_fit.HasShape()) return from_fit;
  OutputPosterior from_initial =
      search.Run(initial, from_fit.noise, none, estimate_drift);
  return from_fit.deviance <= from_initial.deviance ? from_fit : from_initial;
}

}  // namespace mle
