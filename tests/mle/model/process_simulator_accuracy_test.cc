// The simulator against closed forms, exact discretisations and superposed step
// responses.

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"
#include "tests/sim/test_models.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::SecondOrder;
using testing::SingleLoop;

// Rounding of hundreds of samples, relative to the largest response.
constexpr double kTolerance = 1e-12;

// p × (N + 1): the outputs at 0 … N under the inputs (m × N).
MatrixXd SimulateHeld(const ProcessModel& model, double sample_time,
                      const MatrixXd& inputs) {
  absl::StatusOr<ProcessSimulator> created =
      ProcessSimulator::Create(model, sample_time);
  EXPECT_TRUE(created.ok()) << created.status();
  ProcessSimulator plant = *std::move(created);
  MatrixXd outputs(plant.num_outputs(), inputs.cols() + 1);
  outputs.col(0) = plant.outputs();
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    plant.Advance(inputs.col(k));
    outputs.col(k + 1) = plant.outputs();
  }
  return outputs;
}

VectorXd StepOf(const TransferFunction& element, double sample_time,
                int steps) {
  return SimulateHeld(SingleLoop(element), sample_time,
                      MatrixXd::Ones(1, steps))
      .row(0);
}

// `response` is h(t) without dead time, for t > 0; h(t) = 0 up to the dead time
// and at it, because a sample is taken just before the input changes.
void ExpectStepResponse(const TransferFunction& element, double sample_time,
                        const std::function<double(double)>& response) {
  const int steps = 400;
  const VectorXd y = StepOf(element, sample_time, steps);
  VectorXd expected(steps + 1);
  for (int k = 0; k <= steps; ++k) {
    const double t = k * sample_time - element.delay();
    expected[k] = t > 1e-9 * sample_time ? response(t) : 0.0;
  }
  EXPECT_LE((y - expected).cwiseAbs().maxCoeff(),
            kTolerance * expected.cwiseAbs().maxCoeff())
      << "delay " << element.delay();
}

TEST(ProcessSimulatorAccuracyTest, FirstOrderWithDeadTimesOnAndOffTheGrid) {
  for (const double delay : {0.0, 0.2, 0.6, 1.0, 0.05, 0.19, 0.31, 7.777}) {
    ExpectStepResponse(TransferFunction::FirstOrder(-18.9, 21.0, delay), 0.2,
                       [](double t) { return 18.9 * std::expm1(-t / 21.0); });
  }
}

// Pointwise, also where the response has only begun.
TEST(ProcessSimulatorAccuracyTest, FirstOrderIsAccurateRelativeToEverySample) {
  const VectorXd y =
      StepOf(TransferFunction::FirstOrder(12.8, 16.7, 0.0), 0.2, 5000);
  for (int k = 1; k <= 5000; ++k) {
    const double expected = -12.8 * std::expm1(-0.2 * k / 16.7);
    ASSERT_NEAR(y[k], expected, kTolerance * expected) << k;
  }
}

TEST(ProcessSimulatorAccuracyTest, SecondOrderWithLeadAndWithInverseResponse) {
  const double T1 = 5.0, T2 = 0.9;
  for (const double lead : {0.0, 8.0, -3.0}) {
    for (const double delay : {0.0, 0.6, 0.47}) {
      ExpectStepResponse(
          SecondOrder(1.7, lead, T1, T2, delay), 0.2, [&](double t) {
            return 1.7 * (1.0 + (lead - T1) / (T1 - T2) * std::exp(-t / T1) +
                          (T2 - lead) / (T1 - T2) * std::exp(-t / T2));
          });
    }
  }
}

TEST(ProcessSimulatorAccuracyTest, UnderdampedSecondOrder) {
  const double omega = 1.3, zeta = 0.2;
  const double damped = omega * std::sqrt(1.0 - zeta * zeta);
  ExpectStepResponse(
      TransferFunction({omega * omega},
                       {1.0, 2.0 * zeta * omega, omega * omega}, 0.33),
      0.2, [&](double t) {
        return 1.0 - std::exp(-zeta * omega * t) *
                         (std::cos(damped * t) +
                          zeta * omega / damped * std::sin(damped * t));
      });
}

TEST(ProcessSimulatorAccuracyTest, StaticGain) {
  for (const double delay : {0.0, 0.6, 0.5}) {
    ExpectStepResponse(TransferFunction({-4.0}, {2.0}, delay), 0.2,
                       [](double) { return -2.0; });
  }
}

TEST(ProcessSimulatorAccuracyTest,
     BiproperElementJumpsAfterTheSampleOfTheStep) {
  for (const double delay : {0.0, 0.4, 0.5}) {
    ExpectStepResponse(
        TransferFunction({3.0 * 6.0, 3.0}, {4.0, 1.0}, delay), 0.2,
        [](double t) { return 3.0 * (1.0 + 0.5 * std::exp(-t / 4.0)); });
  }
}

// A mode much faster than the sample settles within it.
TEST(ProcessSimulatorAccuracyTest, ModesFarFasterThanTheSample) {
  const double T1 = 5.0, T2 = 1e-6;
  ExpectStepResponse(SecondOrder(1.0, 0.0, T1, T2, 0.3), 0.2, [&](double t) {
    return 1.0 - (T1 * std::exp(-t / T1) - T2 * std::exp(-t / T2)) / (T1 - T2);
  });
}

// Time in other units: the same numbers.
TEST(ProcessSimulatorAccuracyTest, DoesNotDependOnTheUnitOfTime) {
  const auto response = [](double unit) {
    return StepOf(TransferFunction({1.0},
                                   {8.0 * unit * unit * unit,
                                    12.0 * unit * unit, 6.0 * unit, 1.0},
                                   0.7 * unit),
                  0.2 * unit, 200);
  };
  const VectorXd in_minutes = response(1.0);
  for (const double unit : {60.0, 1e-9, 1e9}) {
    EXPECT_LE((response(unit) - in_minutes).cwiseAbs().maxCoeff(), 1e-10)
        << unit;
  }
}

TEST(ProcessSimulatorAccuracyTest, AgreesWithTheStepResponses) {
  const ProcessModel model = testing::MixedModel();
  const int steps = 300;
  const StepResponse exact = model.ComputeStepResponse(0.2, steps + 1);
  for (int j = 0; j < model.num_inputs(); ++j) {
    MatrixXd inputs = MatrixXd::Zero(model.num_inputs(), steps);
    inputs.row(j).setOnes();
    const MatrixXd y = SimulateHeld(model, 0.2, inputs);
    for (int i = 0; i < model.num_outputs(); ++i) {
      const VectorXd expected = exact.element(i, j);
      EXPECT_LE((y.row(i).transpose() - expected).cwiseAbs().maxCoeff(),
                kTolerance * std::max(1.0, expected.cwiseAbs().maxCoeff()))
          << "element " << i << ", " << j;
    }
  }
}

// x_{k+1} = a x_k + K (c − a) u_{k−q−1} + K (1 − c) u_{k−q},
// a = e^{−Δt/T}, c = e^{−(1−f)Δt/T}.
TEST(ProcessSimulatorAccuracyTest, RandomInputAgainstTheExactDiscretisation) {
  const double K = 6.6, T = 10.9, dt = 0.2;
  const int steps = 5000;
  const MatrixXd u = GaussianNoise(3, 0).DrawMatrix(1, steps, 1.0);
  for (const auto& [q, f] : std::vector<std::pair<int, double>>{
           {0, 0.0}, {0, 0.4}, {5, 0.0}, {5, 0.75}}) {
    const MatrixXd y = SimulateHeld(
        SingleLoop(TransferFunction::FirstOrder(K, T, (q + f) * dt)), dt, u);
    const double a = std::exp(-dt / T);
    const double c = std::exp(-(1.0 - f) * dt / T);
    double x = 0.0;
    double largest = 0.0;
    double worst = 0.0;
    for (int k = 0; k < steps; ++k) {
      const double older = k - q - 1 >= 0 ? u(0, k - q - 1) : 0.0;
      const double newer = k - q >= 0 ? u(0, k - q) : 0.0;
      x = a * x + K * (c - a) * older + K * (1.0 - c) * newer;
      largest = std::max(largest, std::abs(x));
      worst = std::max(worst, std::abs(y(0, k + 1) - x));
    }
    EXPECT_LE(worst, kTolerance * largest) << "q = " << q << ", f = " << f;
  }
}

// y_k = Σ_j Σ_{i<k} φ_{k−i}^{j} (u_i − u_{i−1}), since inputs change at
// samples.
TEST(ProcessSimulatorAccuracyTest, RandomInputsAgainstSuperposedStepResponses) {
  const ProcessModel model = testing::MixedModel();
  const int steps = 250;
  const MatrixXd u = GaussianNoise(4, 0).DrawMatrix(3, steps, 1.0);
  const MatrixXd y = SimulateHeld(model, 0.2, u);
  const StepResponse phi = model.ComputeStepResponse(0.2, steps + 1);
  MatrixXd expected = MatrixXd::Zero(2, steps + 1);
  for (int k = 1; k <= steps; ++k) {
    for (int i = 0; i < k; ++i) {
      VectorXd move = u.col(i);
      if (i > 0) move -= u.col(i - 1);
      for (int out = 0; out < 2; ++out) {
        for (int in = 0; in < 3; ++in) {
          expected(out, k) += phi.element(out, in)[k - i] * move[in];
        }
      }
    }
  }
  EXPECT_LE((y - expected).cwiseAbs().maxCoeff(),
            kTolerance * expected.cwiseAbs().maxCoeff());
}

// Π (1 + s/λ_i), highest power first.
std::vector<double> Lags(const std::vector<double>& rates) {
  std::vector<double> product = {1.0};
  for (const double rate : rates) {
    std::vector<double> next(product.size() + 1, 0.0);
    for (std::size_t k = 0; k < product.size(); ++k) {
      next[k] += product[k] / rate;
      next[k + 1] += product[k];
    }
    product = std::move(next);
  }
  return product;
}

// 1/(s + 1)⁸ responds with 1 − e^{−t} Σ_{k<8} tᵏ/k!.
TEST(ProcessSimulatorAccuracyTest, EightEqualLags) {
  ExpectStepResponse(
      TransferFunction({1.0}, Lags(std::vector<double>(8, 1.0)), 0.33), 0.2,
      [](double t) {
        double term = std::exp(-t), rest = 0.0;
        for (int i = 0; i < 8; ++i) {
          rest += term;
          term *= t / (i + 1);
        }
        return 1.0 - rest;
      });
}

// Thirty lags over six decades: 1 − Σ_i e^{−λ_i t} Π_{j≠i} λ_j/(λ_j − λ_i).
TEST(ProcessSimulatorAccuracyTest, ThirtyLagsOverSixDecades) {
  std::vector<double> rates;
  for (int i = 0; i < 30; ++i) rates.push_back(std::pow(1.6, i - 15));
  const int steps = 2000;
  const VectorXd y =
      StepOf(TransferFunction({1.0}, Lags(rates), 0.3), 0.5, steps);
  for (int k = 1; k <= steps; ++k) {
    const double t = 0.5 * k - 0.3;
    long double expected = 1.0L;
    for (const double rate : rates) {
      long double term = std::exp(-static_cast<long double>(rate) * t);
      for (const double other : rates) {
        if (other != rate) {
          term *= other / (static_cast<long double>(other) - rate);
        }
      }
      expected -= term;
    }
    ASSERT_NEAR(y[k], static_cast<double>(expected), 1e-10) << k;
  }
}

// A damping ratio of 1e-5 over thousands of periods: only the phase gathers
// rounding, ε ω t.
TEST(ProcessSimulatorAccuracyTest, LightlyDampedOverManyPeriods) {
  const double zeta = 1e-5;
  const double damped = std::sqrt(1.0 - zeta * zeta);
  const int steps = 100'000;
  for (const double dt : {0.2, 7.0}) {
    const VectorXd y = StepOf(
        TransferFunction({1.0}, {1.0, 2.0 * zeta, 1.0}, 0.4 * dt), dt, steps);
    double worst = 0.0;
    for (int k = 1; k <= steps; ++k) {
      const double t = (k - 0.4) * dt;
      const double expected =
          1.0 - std::exp(-zeta * t) * (std::cos(damped * t) +
                                       zeta / damped * std::sin(damped * t));
      worst = std::max(worst, std::abs(y[k] - expected));
    }
    EXPECT_LE(worst, 1e-9) << dt;
  }
}

// A mode that no sample could resolve acts as its static gain.
TEST(ProcessSimulatorAccuracyTest, ATimeConstantFarBelowRoundingOfTheSample) {
  for (const double tau : {1e-9, 1e-20, 1e-100}) {
    const VectorXd y =
        StepOf(TransferFunction::FirstOrder(3.0, tau, 0.5), 0.2, 10);
    for (int k = 0; k <= 10; ++k) {
      EXPECT_NEAR(y[k], k >= 3 ? 3.0 : 0.0, 1e-13) << tau << " " << k;
    }
  }
}

}  // namespace
}  // namespace mle
