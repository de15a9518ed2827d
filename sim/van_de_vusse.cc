#include "sim/van_de_vusse.h"

#include <cmath>
#include <functional>

#include "absl/status/status.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::VectorXd;

constexpr double k10 = 1.287e12;              // k₁₀ = k₂₀ [1/h]
constexpr double k30 = 9.043e9;               // k₃₀ [L/(mol h)]
constexpr double kE1 = -9758.3;               // E₁ = E₂ [K]
constexpr double kE3 = -8560.0;               // E₃ [K]
constexpr double kHeatAB = 4.2;               // ΔH_AB [kJ/mol]
constexpr double kHeatBC = -11.0;             // ΔH_BC [kJ/mol]
constexpr double kHeatAD = -41.85;            // ΔH_AD [kJ/mol]
constexpr double kDensity = 0.9342;           // ρ [kg/L]
constexpr double kHeatCapacity = 3.01;        // C_p [kJ/(kg K)]
constexpr double kTransfer = 4032.0;          // k_w [kJ/(h m² K)]
constexpr double kArea = 0.215;               // A_R [m²]
constexpr double kVolume = 10.0;              // V_R [L]
constexpr double kCoolant = 5.0;              // m_K [kg]
constexpr double kCoolantHeatCapacity = 2.0;  // C_pK [kJ/(kg K)]
constexpr double kZeroCelsius = 273.15;       // [K]

void ReactorDerivative(const VanDeVusseOptions& options, double time,
                       const VectorXd& x, const VectorXd& w, VectorXd& dx) {
  const double cA = x[0];
  const double cB = x[1];
  const double temperature = x[2];
  const double jacket = x[3];
  const double activity = options.activity.At(time);
  const double kelvin = temperature + kZeroCelsius;
  const double k1 = activity * k10 * std::exp(kE1 / kelvin);
  const double k3 = activity * k30 * std::exp(kE3 / kelvin);
  const double released =
      k1 * cA * kHeatAB + k1 * cB * kHeatBC + k3 * cA * cA * kHeatAD;
  const double to_jacket = options.heat_transfer.At(time) * kTransfer * kArea *
                           (temperature - jacket);
  constexpr double kCapacity = kDensity * kHeatCapacity;

  dx[0] = w[0] * (options.feed_concentration - cA) - k1 * cA - k3 * cA * cA;
  dx[1] = -w[0] * cB + k1 * cA - k1 * cB;
  dx[2] = w[0] * (options.feed_temperature - temperature) -
          released / kCapacity - to_jacket / (kCapacity * kVolume);
  dx[3] = (w[1] + to_jacket) / (kCoolant * kCoolantHeatCapacity);
}

absl::Status ValidateReactor(VanDeVusseOptions options) {
  MLE_RETURN_IF_ERROR(CheckPositive("feed", options.feed));
  MLE_RETURN_IF_ERROR(
      CheckPositive("feed_concentration", options.feed_concentration));
  MLE_RETURN_IF_ERROR(CheckFactors(AgeingFactors(options)));
  if (!std::isfinite(options.heat) ||
      !std::isfinite(options.feed_temperature)) {
    return InvalidArgument("heat = ", options.heat,
                           ", feed_temperature = ", options.feed_temperature,
                           ", but both must be finite");
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<AgeingFactor> AgeingFactors(VanDeVusseOptions& options) {
  return {{"activity", &options.activity},
          {"heat_transfer", &options.heat_transfer}};
}

absl::StatusOr<ContinuousSystem> MakeVanDeVusseReactor(
    VanDeVusseOptions options, double start_time) {
  MLE_RETURN_IF_ERROR(ValidateReactor(options));
  return MakePlantAtRest(
      {.derivative = std::bind_front(ReactorDerivative, options),
       .outputs = {1, 2},
       .inputs = Eigen::Vector2d(options.feed, options.heat),
       .guess = Eigen::Vector4d(2.14, 1.09, 114.2, 112.9),  // as published
       .delays = {options.feed_delay, options.heat_delay}},
      AgeingFactors(options), start_time);
}

}  // namespace mle::sim
