#include "mle/nonlinear/ar_component.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"

namespace mle {

ArComponent::ArComponent(double pole, double damping)
    : second_order_(damping > 0.0), centre_(pole), gap_(1.0 - pole) {
  CHECK(pole >= 0.0 && pole < 1.0);
  CHECK(damping >= 0.0 && std::isfinite(damping));
  if (!second_order_) return;
  if (pole == 0.0) {  // as fast as can be: white
    gap_ = 1.0;
    return;
  }
  const double frequency = -std::log(pole);
  const double decay = damping * frequency;
  if (damping >= 1.0) {
    const double half = frequency * std::sqrt(damping * damping - 1.0);
    // The slow pole first, from its small rate: ω²/(decay + half).
    const double slow_rate = frequency * frequency / (decay + half);
    const double slow = std::exp(-slow_rate);
    const double fast = std::exp(-(decay + half));
    centre_ = 0.5 * (slow + fast);
    const double difference = 0.5 * slow * -std::expm1(-2.0 * half);
    spread_ = difference * difference;
    gap_ = std::expm1(-slow_rate) * std::expm1(-(decay + half));
  } else {
    const double angle = frequency * std::sqrt(1.0 - damping * damping);
    const double size = std::exp(-decay);
    centre_ = size * std::cos(angle);
    const double imaginary = size * std::sin(angle);
    spread_ = -imaginary * imaginary;
    // |1 − p|² = (1 − size)² + 4 size sin²(angle/2).
    gap_ = std::pow(std::expm1(-decay), 2) +
           4.0 * size * std::pow(std::sin(0.5 * angle), 2);
  }
}

ArComponent::Power ArComponent::After(int steps) const {
  if (!second_order_) {
    return {.own = steps == 1 ? centre_ : std::pow(centre_, steps)};
  }
  Power result;
  Power square = {.own = centre_, .cross = 1.0};
  const auto times = [this](const Power& x, const Power& y) {
    return Power{.own = x.own * y.own + spread_ * x.cross * y.cross,
                 .cross = x.own * y.cross + x.cross * y.own};
  };
  for (; steps > 0; steps /= 2) {
    if (steps % 2 == 1) result = times(result, square);
    square = times(square, square);
  }
  return result;
}

// γ_0 = s (1 + q)/((1 − q) (1 − p₁)(1 − p₂) (1 + p₁)(1 + p₂)) with q = p₁p₂,
// γ_1 = γ_0 2μ/(1 + q), and b_k = a_{k+1} − μ a_k.
ArComponent::Covariance ArComponent::Stationary() const {
  if (!second_order_) return {.aa = 1.0 / (gap_ * (1.0 + centre_))};
  const double square = centre_ * centre_;
  const double q = square - spread_;
  // 1 − q = (p₁ + p₂)/2 … : (1 − p₁)(1 − p₂) + 2 (μ − q).
  const double less = gap_ + 2.0 * (centre_ - q);
  Covariance of;
  of.aa = (1.0 + q) / (less * gap_ * (1.0 + 2.0 * centre_ + q));
  of.ab = of.aa * centre_ * less / (1.0 + q);
  of.bb = of.aa * ((1.0 - square) * (1.0 - square) - spread_ * (1.0 + square)) /
          (1.0 + q);
  return of;
}

ArSignal::ArSignal(const ArComponent& ar, double shock_variance,
                   GaussianNoise& random)
    : step_(ar.After(1)),
      spread_(ar.spread()),
      second_order_(ar.order() == 2),
      deviation_(std::sqrt(shock_variance)),
      random_(random) {
  const ArComponent::Covariance start = ar.Stationary();
  a_ = random_.Draw(deviation_ * std::sqrt(start.aa));
  if (!second_order_) return;
  const double slope = start.ab / start.aa;
  b_ = slope * a_ +
       random_.Draw(deviation_ *
                    std::sqrt(std::max(start.bb - slope * start.ab, 0.0)));
}

void ArSignal::Advance() {
  const double shock = random_.Draw(deviation_);
  const double a = step_.own * a_ + step_.cross * b_;
  if (second_order_) {
    b_ = spread_ * step_.cross * a_ + step_.own * b_ + shock;
    a_ = a;
  } else {
    a_ = a + shock;
  }
}

}  // namespace mle
