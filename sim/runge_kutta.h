// One step of the classical fourth-order Runge–Kutta scheme for ẋ = f(x), with
// whatever else f depends on held constant over the step:
//
//   k₁ = f(x), k₂ = f(x + h k₁/2), k₃ = f(x + h k₂/2), k₄ = f(x + h k₃),
//   x ← x + h (k₁ + 2 k₂ + 2 k₃ + k₄) / 6.
//
// `State` is an Eigen vector, or a matrix whose columns are trajectories of
// their own. The derivative is a callable (const State& x, State& derivative)
// whose second argument has the size of x on entry. Allocates in the
// constructor only. (Hairer, Nørsett and Wanner, Solving Ordinary Differential
// Equations I, 1993, sec. II.1.)
//
//   RungeKutta4 scheme(x);
//   scheme.Step([u](const VectorXd& x, VectorXd& dx) { dx = u - x; }, h, x);

#ifndef SIM_RUNGE_KUTTA_H_
#define SIM_RUNGE_KUTTA_H_

#include <type_traits>

namespace mle::sim {

template <typename State>
class RungeKutta4 {
 public:
  // For states of the size of `like`.
  explicit RungeKutta4(const State& like)
      : k1_(like), k2_(like), k3_(like), k4_(like), point_(like) {}

  // The increment of `x` over one step. Valid until the next call.
  template <typename Derivative>
  const State& Increment(const Derivative& f, double h, const State& x) {
    const auto at = [&f](double since, const State& point, State& derivative) {
      if constexpr (std::is_invocable_v<Derivative, double, const State&,
                                        State&>) {
        f(since, point, derivative);
      } else {
        f(point, derivative);
      }
    };
    at(0.0, x, k1_);
    point_ = x + 0.5 * h * k1_;
    at(0.5 * h, point_, k2_);
    point_ = x + 0.5 * h * k2_;
    at(0.5 * h, point_, k3_);
    point_ = x + h * k3_;
    at(h, point_, k4_);
    point_ = h / 6.0 * (k1_ + 2.0 * k2_ + 2.0 * k3_ + k4_);
    return point_;
  }

  template <typename Derivative>
  void Step(const Derivative& f, double h, State& x) {
    x += Increment(f, h, x);
  }

 private:
  State k1_, k2_, k3_, k4_, point_;
};

}  // namespace mle::sim

#endif  // SIM_RUNGE_KUTTA_H_
