#include "mle/exchange/discrete_model.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <utility>

#include "Eigen/Eigenvalues"
#include "mle/base/number_range.h"
#include "mle/base/status.h"
#include "mle/exchange/element_table.h"
#include "mle/exchange/state_space_responses.h"
#include "mle/model/held_response.h"
#include "mle/model/state_space.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

// z = 1 is a root of a polynomial whose value there is at most this share of
// the sum of magnitudes of its coefficients.
constexpr double kRootAtOne = 1e-9;
constexpr int kMostDiscreteCoefficients = 1000;

// b_0 + b_1 z⁻¹ + … over 1 + a_1 z⁻¹ + …; dead time and the difference of the
// degrees are leading zeros' number in `shift`.
struct Polynomials {
  std::vector<double> b;
  std::vector<double> a;
  int shift = 0;
};

Polynomials Expand(const DiscreteElement& element, DiscreteVariable variable) {
  Polynomials g = {element.numerator, element.denominator, element.delay};
  if (variable == DiscreteVariable::kZ) {
    g.shift += static_cast<int>(g.a.size()) - static_cast<int>(g.b.size());
  }
  const double leading = element.denominator.front();
  for (double& value : g.b) value /= leading;
  for (double& value : g.a) value /= leading;
  return g;
}

bool HasRootAtOne(const std::vector<double>& polynomial) {
  const double value =
      std::accumulate(polynomial.begin(), polynomial.end(), 0.0);
  double size = 0.0;
  for (const double c : polynomial) size += std::abs(c);
  return std::abs(value) <= kRootAtOne * size;
}

// a / (1 − z⁻¹), which is a factor of it: the partial sums.
std::vector<double> WithoutRootAtOne(std::vector<double> a) {
  std::partial_sum(a.begin(), a.end(), a.begin());
  a.pop_back();
  return a;
}

// The largest magnitude of a root of z^r + a_1 z^(r−1) + …; 0 without any.
double LargestRoot(const std::vector<double>& a) {
  const auto r = static_cast<Eigen::Index>(a.size()) - 1;
  if (r < 1) return 0.0;
  MatrixXd companion = MatrixXd::Zero(r, r);
  companion.diagonal(1).setOnes();
  for (Eigen::Index k = 0; k < r; ++k) companion(r - 1, k) = -a[r - k];
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}

bool HasIntegrator(const Polynomials& g) {
  return g.a.size() > 1 && HasRootAtOne(g.a);
}

// The largest magnitude of a pole that does not integrate.
double SlowestPole(const Polynomials& g) {
  return LargestRoot(HasIntegrator(g) ? WithoutRootAtOne(g.a) : g.a);
}

absl::Status CheckNumbers(const char* kind,
                          const std::vector<double>& numbers) {
  if (numbers.empty() || numbers.size() > kMostDiscreteCoefficients) {
    return InvalidArgument("the ", kind, " has ", numbers.size(),
                           " coefficients, must have 1 to ",
                           kMostDiscreteCoefficients);
  }
  for (const double number : numbers) {
    if (std::isfinite(number)) continue;
    return InvalidArgument("the ", kind,
                           " has a coefficient that is not finite");
  }
  return absl::OkStatus();
}

absl::Status CheckPoles(const Polynomials& g) {
  if (SlowestPole(g) < 1.0 && !(HasIntegrator(g) && HasRootAtOne(g.b))) {
    return absl::OkStatus();
  }
  if (HasIntegrator(g) && HasRootAtOne(g.b)) {
    return absl::InvalidArgumentError(
        "numerator and denominator are both zero at z = 1; cancel the common "
        "factor z − 1");
  }
  return InvalidArgument(
      "the denominator has a root of magnitude ", SlowestPole(g),
      " (an unstable mode); each must be below 1, but for at most one at z = "
      "1 (an output that integrates)");
}

absl::Status CheckElement(const DiscreteElement& element,
                          DiscreteVariable variable) {
  MLE_RETURN_IF_ERROR(CheckNumbers("numerator", element.numerator));
  MLE_RETURN_IF_ERROR(CheckNumbers("denominator", element.denominator));
  if (element.denominator.front() == 0.0) {
    return absl::InvalidArgumentError(
        "the denominator begins with 0, must begin with another number");
  }
  if (element.delay < 0 || element.delay > kMaxStateSpaceDelay) {
    return InvalidArgument("delay is ", element.delay, ", must be from 0 to ",
                           kMaxStateSpaceDelay, " samples");
  }
  const Polynomials g = Expand(element, variable);
  const auto first =
      std::find_if(g.b.begin(), g.b.end(), [](double b) { return b != 0.0; });
  if (first != g.b.end() && g.shift + (first - g.b.begin()) < 1) {
    return absl::InvalidArgumentError(
        "the output follows its input within the same sample, but outputs are "
        "measured just before the inputs change: where numerator and "
        "denominator begin alike, \"delay\" must be at least 1");
  }
  return CheckPoles(g);
}

// h_0 … h_{samples−1}: a step passes through the difference equation.
VectorXd Respond(const Polynomials& g, int samples) {
  VectorXd response = VectorXd::Zero(samples);
  double sum = 0.0;  // of b_0 … of those that the step has reached
  for (int k = std::max(g.shift, 0); k < samples; ++k) {
    const auto reached = static_cast<std::size_t>(k - g.shift);
    if (reached < g.b.size()) sum += g.b[reached];
    double value = sum;
    const auto past = std::min<std::size_t>(g.a.size() - 1, k);
    for (std::size_t l = 1; l <= past; ++l) {
      value -= g.a[l] * response(k - static_cast<int>(l));
    }
    response(k) = value;
  }
  return response;
}

// Π (1 − z_i z⁻¹) with z_i − 1 the eigenvalues of E; one of an integrating
// element is 0 to the bit.
std::vector<double> DenominatorOf(const MatrixXd& e, bool integrating) {
  VectorXcd roots = e.eigenvalues();
  if (integrating) {
    Eigen::Index least = 0;
    roots.cwiseAbs().minCoeff(&least);
    roots(least) = 0.0;
  }
  std::vector<std::complex<double>> product = {1.0};
  for (const std::complex<double> root : roots) {
    product.emplace_back(0.0);
    for (std::size_t k = product.size() - 1; k > 0; --k) {
      product[k] -= (1.0 + root) * product[k - 1];
    }
  }
  std::vector<double> denominator;
  for (const std::complex<double> c : product) denominator.push_back(c.real());
  return denominator;
}

}  // namespace

absl::Status DiscreteModel::Validate() const {
  MLE_RETURN_IF_ERROR(channels.Validate());
  MLE_RETURN_IF_ERROR(ValidateSampleTime("sample_time", sample_time));
  for (const DiscreteElement& element : elements) {
    const absl::Status status = CheckElement(element, variable);
    if (status.ok()) continue;
    return InvalidArgument(PairName(channels, element.output, element.input),
                           ": ", status.message());
  }
  return absl::OkStatus();
}

StepResponse ComputeStepResponse(const DiscreteModel& model, int samples) {
  StepResponse response(model.sample_time, model.channels.num_outputs(),
                        model.channels.num_inputs(), samples);
  for (const DiscreteElement& element : model.elements) {
    response.element(element.output, element.input) =
        Respond(Expand(element, model.variable), samples);
  }
  return response;
}

absl::StatusOr<StepResponseModel> StepResponsesOf(const DiscreteModel& model) {
  MLE_RETURN_IF_ERROR(model.Validate());
  const int p = model.channels.num_outputs();
  const int m = model.channels.num_inputs();
  SampledModel sampled;
  sampled.channels = model.channels;
  sampled.sample_time = model.sample_time;
  sampled.ramps = Eigen::MatrixXi::Zero(p, m);
  sampled.rounding = MatrixXd::Zero(p, m);
  for (const DiscreteElement& element : model.elements) {
    const Polynomials g = Expand(element, model.variable);
    sampled.ramps(element.output, element.input) = HasIntegrator(g) ? 1 : 0;
    const double steps = static_cast<double>(g.a.size() + g.b.size());
    sampled.samples = std::max(
        sampled.samples,
        g.shift + std::max(std::ceil(SamplesToDecay(SlowestPole(g))), steps));
  }
  sampled.respond = [&](int samples) {
    return ComputeStepResponse(model, samples);
  };
  return Sample(sampled);
}

absl::StatusOr<DiscreteElement> Discretized(const TransferFunction& element,
                                            double sample_time,
                                            DiscreteVariable variable) {
  MLE_ASSIGN_OR_RETURN(const HeldResponse held,
                       HeldResponse::Create(element, sample_time));
  const auto r = static_cast<int>(held.C.size());
  DiscreteElement discrete;
  discrete.denominator =
      r == 0 ? std::vector<double>{1.0}
             : DenominatorOf(held.map.E, element.IsIntegrating());
  // The impulse response from one sample after the whole dead time on; the
  // first r + 1 of the product with the denominator are the numerator.
  const int count = r + 1;
  const TransferFunction without_delay(
      element.numerator(), element.denominator(),
      std::max(element.delay() - held.whole_delay * sample_time, 0.0));
  const VectorXd steps = without_delay.StepResponse(sample_time, count + 1);
  std::vector<double> numerator(count, 0.0);
  for (int k = 0; k < count; ++k) {
    for (int l = 0; l <= k; ++l) {
      numerator[k] +=
          discrete.denominator[l] * (steps(k - l + 1) - steps(k - l));
    }
  }
  // Without a fraction of a sample the last one is 0, but for rounding.
  const bool past = held.D != 0.0 || !held.map.older.isZero(0.0);
  discrete.delay = held.whole_delay + 1;
  if (!past && r > 0) {
    numerator.pop_back();
    if (variable == DiscreteVariable::kZ) --discrete.delay;
  }
  discrete.numerator = std::move(numerator);
  return discrete;
}

absl::StatusOr<DiscreteModel> WithChange(const DiscreteModel& model,
                                         const ProcessModel& before,
                                         const ProcessModel& after) {
  DiscreteModel changed = model;
  for (int i = 0; i < after.num_outputs(); ++i) {
    for (int j = 0; j < after.num_inputs(); ++j) {
      const TransferFunction& g = after.element(i, j);
      if (IsSameElement(g, before.element(i, j))) continue;
      MLE_ASSIGN_OR_RETURN(DiscreteElement element,
                           Discretized(g, model.sample_time, model.variable));
      element.output = i;
      element.input = j;
      const auto found =
          std::find_if(changed.elements.begin(), changed.elements.end(),
                       [&](const DiscreteElement& e) {
                         return e.output == i && e.input == j;
                       });
      if (found != changed.elements.end()) {
        *found = std::move(element);
      } else {
        changed.elements.push_back(std::move(element));
      }
    }
  }
  return changed;
}

}  // namespace mle
