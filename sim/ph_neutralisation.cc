#include "sim/ph_neutralisation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::Array3d;
using Eigen::VectorXd;

constexpr double kTankArea = 207.0;           // A [cm²]
constexpr double kValve = 8.75;               // C_v [mL/(s √cm)]
const double kK1 = std::pow(10.0, -6.35);     // of carbonic acid [mol/L]
const double kK2 = std::pow(10.0, -10.25);    // of bicarbonate [mol/L]
constexpr double kWater = 1e-14;              // K_w [mol²/L²]
const Array3d kCharges(3.00, -30.0, -3.05);   // W_ai [mmol/L]
const Array3d kCarbonates(0.0, 30.0, 0.050);  // W_bi [mmol/L]
constexpr double kNeutral = 7.0;  // where an electrode's slope turns

// q₁, q₂, q₃ [mL/s].
Array3d Streams(const PhNeutralisationOptions& options, double time,
                const VectorXd& w) {
  return {options.acid_factor.At(time) * std::max(w[0], 0.0),
          options.buffer_factor.At(time) * options.buffer,
          options.base_factor.At(time) * std::max(w[1], 0.0)};
}

double Shown(const PhNeutralisationOptions& options, double time, double wa,
             double wb) {
  return kNeutral +
         options.slope_factor.At(time) * (PhOfInvariants(wa, wb) - kNeutral);
}

void NeutralisationDerivative(const PhNeutralisationOptions& options,
                              double time, const VectorXd& x, const VectorXd& w,
                              VectorXd& dx) {
  const Array3d streams = Streams(options, time, w);
  const double volume = kTankArea * x[0];
  const double outflow =
      options.outlet_factor.At(time) * kValve * std::sqrt(std::max(x[0], 0.0));
  dx[0] = (streams.sum() - outflow) / kTankArea;
  dx[1] = (streams * (kCharges - x[1])).sum() / volume;
  dx[2] = (streams * (kCarbonates - x[2])).sum() / volume;
  dx[3] = (Shown(options, time, x[1], x[2]) - x[3]) /
          (options.lag_factor.At(time) * options.electrode_lag);
}

// Where the tank is the mixture of its streams.
VectorXd RestingState(const PhNeutralisationOptions& options, double time,
                      const VectorXd& w) {
  const Array3d streams = Streams(options, time, w);
  const double total = streams.sum();
  const double root = total / (options.outlet_factor.At(time) * kValve);
  const double wa = (streams * kCharges).sum() / total;
  const double wb = (streams * kCarbonates).sum() / total;
  return Eigen::Vector4d(root * root, wa, wb, Shown(options, time, wa, wb));
}

absl::Status ValidateNeutralisation(PhNeutralisationOptions options) {
  for (const auto& [name, value] :
       {std::pair("acid", options.acid), std::pair("base", options.base),
        std::pair("buffer", options.buffer),
        std::pair("electrode_lag", options.electrode_lag)}) {
    MLE_RETURN_IF_ERROR(CheckPositive(name, value));
  }
  return CheckFactors(AgeingFactors(options));
}

}  // namespace

// Newton's method, kept between bounds by bisection: the charge grows with pH.
double PhOfInvariants(double wa, double wb) {
  constexpr int kMostSteps = 100;
  constexpr double kRounding = 1e-14;
  double low = -2.0;
  double high = 16.0;
  double ph = kNeutral;
  for (int i = 0; i < kMostSteps; ++i) {
    const double hydrogen = std::pow(10.0, -ph);
    const double a = hydrogen / kK1;
    const double b = kK2 / hydrogen;
    const double parts = 1.0 + a + b;
    const double charge = 1e-3 * wa + kWater / hydrogen - hydrogen +
                          1e-3 * wb * (1.0 + 2.0 * b) / parts;
    const double slope =
        std::log(10.0) * (kWater / hydrogen + hydrogen +
                          1e-3 * wb * (a + b + 4.0 * a * b) / (parts * parts));
    (charge > 0.0 ? high : low) = ph;
    double next = ph - charge / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double move = std::abs(next - ph);
    ph = next;
    if (move <= kRounding * kNeutral) break;
  }
  return ph;
}

std::vector<AgeingFactor> AgeingFactors(PhNeutralisationOptions& options) {
  return {{"acid", &options.acid_factor},
          {"base", &options.base_factor},
          {"buffer", &options.buffer_factor},
          {"outlet", &options.outlet_factor},
          {"electrode_slope", &options.slope_factor},
          {"electrode_lag", &options.lag_factor}};
}

absl::StatusOr<ContinuousSystem> MakePhNeutralisation(
    PhNeutralisationOptions options, double start_time) {
  MLE_RETURN_IF_ERROR(ValidateNeutralisation(options));
  const Eigen::Vector2d inputs(options.acid, options.base);
  return MakePlantAtRest(
      {.derivative = std::bind_front(NeutralisationDerivative, options),
       .outputs = {0, 3},
       .inputs = inputs,
       .guess = RestingState(options, start_time, inputs),
       .delays = {}},
      AgeingFactors(options), start_time);
}

}  // namespace mle::sim
