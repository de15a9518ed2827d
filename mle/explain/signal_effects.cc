#include "mle/explain/signal_effects.h"

#include <algorithm>
#include <cmath>

#include "mle/model/element_response.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

}  // namespace

VectorXd TwoLags(double rising, double falling, double sample_time,
                 double delay, double sign, const VectorXd& input) {
  const SampledDelay samples = SampledDelayOf(delay, sample_time);
  const double up = std::exp(-sample_time / rising);
  const double down = std::exp(-sample_time / falling);
  VectorXd z(input.size());
  double state = 0.0;
  const auto at = [&](Index k) { return k < 0 ? 0.0 : input[k]; };
  for (Index k = 0; k < input.size(); ++k) {
    z[k] = state;
    const double u = (1.0 - samples.fraction) * at(k - samples.whole) +
                     samples.fraction * at(k - samples.whole - 1);
    const double kept = sign * (u - state) > 0.0 ? up : down;
    state = kept * state + (1.0 - kept) * u;
  }
  return z;
}

VectorXd Earlier(const VectorXd& z, double samples) {
  const Index last = z.size() - 1;
  const auto whole = static_cast<Index>(
      std::min(std::floor(samples), static_cast<double>(last)));
  const double rest = samples - std::floor(samples);
  VectorXd earlier(z.size());
  for (Index k = 0; k <= last; ++k) {
    earlier[k] = (1.0 - rest) * z[std::min(k + whole, last)] +
                 rest * z[std::min(k + whole + 1, last)];
  }
  return earlier;
}

VectorXd Averaged(const VectorXd& z, double width) {
  if (!(width > 1.0)) return z;
  VectorXd sums(z.size() + 1);
  sums[0] = 0.0;
  for (Index k = 0; k < z.size(); ++k) sums[k + 1] = sums[k] + z[k];
  const auto sum_at = [&](double k) {
    if (k <= 0.0) return 0.0;
    const auto whole = static_cast<Index>(k);
    const Index next = std::min(whole + 1, z.size());
    return sums[whole] +
           (k - static_cast<double>(whole)) * (sums[next] - sums[whole]);
  };
  VectorXd means(z.size());
  for (Index k = 0; k < z.size(); ++k) {
    const double end = static_cast<double>(k + 1);
    means[k] = (sum_at(end) - sum_at(end - width)) / width;
  }
  return means;
}

}  // namespace mle
