#include "mle/trial/trial_evidence.h"

#include <algorithm>
#include <cmath>

namespace mle {
namespace {

constexpr double kFromTheBegin = 0.8;
constexpr double kFourthMoment = 4.0;
constexpr double kMostStake = 1.5;
// More is not told apart from it.
constexpr double kMostEvidence = 1e100;

// Σ w_s of s ≥ n.
double WeightFrom(int n) { return n == 0 ? 1.0 : (1.0 - kFromTheBegin) / n; }

}  // namespace

void TrialEvidence::Add(double difference, double expected) {
  const double x = std::clamp(difference, -kMostDifference, kMostDifference);
  const double begins = WeightFrom(seen_) - WeightFrom(seen_ + 1);
  for (std::size_t i = 0; i < kBets.size(); ++i) {
    const double c = std::min(kBets[i] * expected, kMostStake);
    const double c2 = c * c;
    const double factor = std::pow(std::max(0.0, 1.0 + c * x), 4) /
                          (1.0 + 6.0 * c2 + kFourthMoment * c2 * c2);
    begun_[i] = std::min((begun_[i] + begins) * factor, kMostEvidence);
  }
  ++seen_;
}

double TrialEvidence::log() const {
  double sum = 0.0;
  for (const double begun : begun_) sum += begun;
  return std::log(sum / static_cast<double>(begun_.size()) + WeightFrom(seen_));
}

}  // namespace mle
