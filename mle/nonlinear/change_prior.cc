#include "mle/nonlinear/change_prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/nonlinear/model_average.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kScales = 4;
constexpr std::array<double, kScales> kScale = {0.02, 0.2, 0.6, 2.0};
constexpr std::array<double, kScales> kPrior = {1.0 / 2, 1.0 / 6, 1.0 / 6,
                                                1.0 / 6};
constexpr int kMaxVisits = 300;
constexpr double kSmallestWeightRatio = 1e-4;  // of a weight that is visited
constexpr double kEnough = 0.999;
constexpr std::size_t kMaxParts = 64;

// The number of one of the four σ for each parameter.
using Choice = std::vector<std::uint8_t>;

// The changes of n parameters that are determined.
struct Changes {
  std::vector<Index> numbers;  // among the fit's 3m
  VectorXd change;             // d
  MatrixXd covariance;         // V
  VectorXd units;              // u
};

Changes ChangesOf(const OutputFit& fit, const OutputPoint& initial) {
  Changes changes;
  std::vector<double> units;
  for (std::size_t j = 0; j < fit.free.size(); ++j) {
    if (!fit.free[j]) continue;
    const ElementValues& v = initial.values[j];
    const std::array<double, 3> unit = {std::abs(v.gain), v.time_scale,
                                        v.time_scale + v.delay};
    for (Index k = 0; k < 3; ++k) {
      const Index number = 3 * static_cast<Index>(j) + k;
      const double variance = fit.covariance(number, number);
      if (!std::isfinite(variance) || !(variance > 0.0)) continue;
      changes.numbers.push_back(number);
      units.push_back(unit[k]);
    }
  }
  changes.change =
      (ParametersOf(fit.point) - ParametersOf(initial))(changes.numbers);
  changes.covariance = fit.covariance(changes.numbers, changes.numbers);
  changes.units = Eigen::Map<const VectorXd>(units.data(),
                                             static_cast<Index>(units.size()));
  return changes;
}

VectorXd PriorVariances(const Changes& changes, const Choice& choice) {
  VectorXd variances(changes.units.size());
  for (Index k = 0; k < variances.size(); ++k) {
    variances(k) = std::pow(kScale[choice[k]] * changes.units(k), 2);
  }
  return variances;
}

// Best for each parameter as if it were the only one.
Choice Start(const Changes& changes) {
  Choice choice(changes.numbers.size());
  for (Index k = 0; k < changes.change.size(); ++k) {
    double best = -std::numeric_limits<double>::infinity();
    for (int s = 0; s < kScales; ++s) {
      const double variance =
          changes.covariance(k, k) + std::pow(kScale[s] * changes.units(k), 2);
      const double log_weight =
          std::log(kPrior[s]) -
          0.5 * (std::log(variance) +
                 changes.change(k) * changes.change(k) / variance);
      if (log_weight > best) {
        best = log_weight;
        choice[k] = static_cast<std::uint8_t>(s);
      }
    }
  }
  return choice;
}

using Weighed = std::pair<double, Choice>;  // the logarithm of a weight

// The weights of all choices with one σ unlike that of `at`, to `add`: with
// P = (V + D)⁻¹ and a change Δ of D_kk, ln det grows by ln(1 + Δ P_kk) and
// dᵀPd by −Δ (Pd)_k²/(1 + Δ P_kk).
template <typename Add>
void WeighNeighbours(const Changes& changes, const Weighed& at,
                     const Add& add) {
  const VectorXd variances = PriorVariances(changes, at.second);
  MatrixXd sum = changes.covariance;
  sum.diagonal() += variances;
  const MatrixXd inverse =
      sum.llt().solve(MatrixXd::Identity(sum.rows(), sum.cols()));
  const VectorXd pull = inverse * changes.change;
  for (Index k = 0; k < variances.size(); ++k) {
    for (int s = 0; s < kScales; ++s) {
      const int former = at.second[k];
      if (s == former) continue;
      const double more =
          std::pow(kScale[s] * changes.units(k), 2) - variances(k);
      const double factor = 1.0 + more * inverse(k, k);
      if (!(factor > 0.0)) continue;
      Choice choice = at.second;
      choice[k] = static_cast<std::uint8_t>(s);
      add(at.first + std::log(kPrior[s] / kPrior[former]) -
              0.5 * (std::log(factor) - more * pull(k) * pull(k) / factor),
          std::move(choice));
    }
  }
}

// The choices seen, heaviest first; logarithms of weights to the first's.
std::vector<Weighed> VisitChoices(const Changes& changes) {
  std::map<Choice, double> seen;
  std::priority_queue<Weighed> waiting;
  double best = 0.0;
  const auto add = [&](double log_weight, Choice choice) {
    if (log_weight < best + std::log(kSmallestWeightRatio)) return;
    if (!seen.emplace(choice, log_weight).second) return;
    best = std::max(best, log_weight);
    waiting.emplace(log_weight, std::move(choice));
  };
  add(0.0, Start(changes));
  for (int visit = 0; visit < kMaxVisits && !waiting.empty(); ++visit) {
    const Weighed at = waiting.top();
    waiting.pop();
    if (at.first < best + std::log(kSmallestWeightRatio)) break;
    WeighNeighbours(changes, at, add);
  }
  std::vector<Weighed> choices;
  for (const auto& [choice, log_weight] : seen) {
    choices.emplace_back(log_weight, choice);
  }
  std::stable_sort(
      choices.begin(), choices.end(),
      [](const Weighed& a, const Weighed& b) { return a.first > b.first; });
  const double first = choices.front().first;
  for (Weighed& choice : choices) choice.first -= first;
  return choices;
}

LinearEstimate UnderChoice(const OutputFit& fit, const Changes& changes,
                           const Choice& choice) {
  const VectorXd variances = PriorVariances(changes, choice);
  MatrixXd sum = changes.covariance;
  sum.diagonal() += variances;
  const Eigen::LLT<MatrixXd> factor(sum);
  // E δ − d = −V (V + D)⁻¹ d, and Var δ = V − V (V + D)⁻¹ V: exact also where
  // the prior says little.
  const MatrixXd& V = changes.covariance;
  LinearEstimate estimate;
  estimate.change = VectorXd::Zero(fit.covariance.rows());
  estimate.change(changes.numbers) = -V * factor.solve(changes.change);
  estimate.covariance = fit.covariance;
  const MatrixXd left = V - V * factor.solve(V);
  estimate.covariance(changes.numbers, changes.numbers) =
      0.5 * (left + left.transpose());
  for (const Index k : changes.numbers) {
    estimate.covariance(k, k) = std::max(estimate.covariance(k, k), 0.0);
  }
  estimate.degrees_of_freedom = fit.degrees_of_freedom;
  return estimate;
}

}  // namespace

std::vector<LinearEstimate> IntegrateChanges(const OutputFit& fit,
                                             const OutputPoint& initial) {
  const Changes changes = ChangesOf(fit, initial);
  if (changes.numbers.empty()) {
    return {{.weight = 1.0,
             .change = VectorXd::Zero(fit.covariance.rows()),
             .covariance = fit.covariance,
             .degrees_of_freedom = fit.degrees_of_freedom}};
  }
  const std::vector<Weighed> choices = VisitChoices(changes);
  double total = 0.0;
  for (const Weighed& choice : choices) total += std::exp(choice.first);
  std::vector<LinearEstimate> estimates;
  double sum = 0.0;
  for (const Weighed& choice : choices) {
    if (sum >= kEnough * total || estimates.size() == kMaxParts) break;
    estimates.push_back(UnderChoice(fit, changes, choice.second));
    estimates.back().weight = std::exp(choice.first);
    sum += estimates.back().weight;
  }
  for (LinearEstimate& estimate : estimates) estimate.weight /= sum;
  return estimates;
}

double Improbability(double change) {
  double density = 0.0;
  double highest = 0.0;
  for (int s = 1; s < kScales; ++s) {
    const double z = change / kScale[s];
    density += kPrior[s] * std::exp(-0.5 * z * z) / kScale[s];
    highest += kPrior[s] / kScale[s];
  }
  return -2.0 * std::log(std::max(density / highest, 1e-300));
}

}  // namespace mle
