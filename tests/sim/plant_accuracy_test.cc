// The plant against closed forms, exact discretisations and the matrix
// exponential of TransferFunction::StepResponse().

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "gtest/gtest.h"
#include "sim/noise.h"
#include "sim/plant.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::SecondOrder;
using testing::SingleLoop;

// What the default step promises, relative to the largest response.
constexpr double kTolerance = 1e-8;

Plant MakePlant(const ProcessModel& model, const PlantOptions& options) {
  absl::StatusOr<Plant> plant = Plant::Create(model, options);
  EXPECT_TRUE(plant.ok()) << plant.status();
  return *std::move(plant);
}

// p × (N + 1): the outputs at 0 … N under the inputs (m × N).
MatrixXd Simulate(const ProcessModel& model, const PlantOptions& options,
                  const MatrixXd& inputs) {
  Plant plant = MakePlant(model, options);
  MatrixXd outputs(plant.num_outputs(), inputs.cols() + 1);
  outputs.col(0) = plant.outputs();
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    plant.Advance(inputs.col(k));
    outputs.col(k + 1) = plant.outputs();
  }
  return outputs;
}

VectorXd StepOf(const TransferFunction& element, const PlantOptions& options,
                int steps) {
  return Simulate(SingleLoop(element), options, MatrixXd::Ones(1, steps))
      .row(0);
}

// `response` is h(t) without dead time, for t > 0; h(t) = 0 up to the dead time
// and at it, because a sample is taken just before the input changes.
void ExpectStepResponse(const TransferFunction& element, double sample_time,
                        const std::function<double(double)>& response) {
  const int steps = 400;
  const VectorXd y = StepOf(element, {.sample_time = sample_time}, steps);
  VectorXd expected(steps + 1);
  for (int k = 0; k <= steps; ++k) {
    const double t = k * sample_time - element.delay();
    expected[k] = t > 1e-9 * sample_time ? response(t) : 0.0;
  }
  EXPECT_LE((y - expected).cwiseAbs().maxCoeff(),
            kTolerance * expected.cwiseAbs().maxCoeff())
      << "delay " << element.delay();
}

TEST(PlantAccuracyTest, FirstOrderWithDeadTimesOnAndOffTheGrid) {
  for (const double delay : {0.0, 0.2, 0.6, 1.0, 0.05, 0.19, 0.31, 7.777}) {
    ExpectStepResponse(TransferFunction::FirstOrder(-18.9, 21.0, delay), 0.2,
                       [](double t) { return 18.9 * std::expm1(-t / 21.0); });
  }
}

// Pointwise, also where the response has only begun.
TEST(PlantAccuracyTest, FirstOrderIsAccurateRelativeToEverySample) {
  const VectorXd y = StepOf(TransferFunction::FirstOrder(12.8, 16.7, 0.0),
                            {.sample_time = 0.2}, 5000);
  for (int k = 1; k <= 5000; ++k) {
    const double expected = -12.8 * std::expm1(-0.2 * k / 16.7);
    ASSERT_NEAR(y[k], expected, kTolerance * expected) << k;
  }
}

TEST(PlantAccuracyTest, SecondOrderWithLeadAndWithInverseResponse) {
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

TEST(PlantAccuracyTest, UnderdampedSecondOrder) {
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

TEST(PlantAccuracyTest, StaticGain) {
  for (const double delay : {0.0, 0.6, 0.5}) {
    ExpectStepResponse(TransferFunction({-4.0}, {2.0}, delay), 0.2,
                       [](double) { return -2.0; });
  }
}

TEST(PlantAccuracyTest, BiproperElementJumpsAfterTheSampleOfTheStep) {
  for (const double delay : {0.0, 0.4, 0.5}) {
    ExpectStepResponse(
        TransferFunction({3.0 * 6.0, 3.0}, {4.0, 1.0}, delay), 0.2,
        [](double t) { return 3.0 * (1.0 + 0.5 * std::exp(-t / 4.0)); });
  }
}

// A mode much faster than the sample settles within it.
TEST(PlantAccuracyTest, ModesFarFasterThanTheSample) {
  const double T1 = 5.0, T2 = 1e-6;
  ExpectStepResponse(SecondOrder(1.0, 0.0, T1, T2, 0.3), 0.2, [&](double t) {
    return 1.0 - (T1 * std::exp(-t / T1) - T2 * std::exp(-t / T2)) / (T1 - T2);
  });
}

// Time in other units: the same numbers.
TEST(PlantAccuracyTest, DoesNotDependOnTheUnitOfTime) {
  const auto response = [](double unit) {
    return StepOf(TransferFunction({1.0},
                                   {8.0 * unit * unit * unit,
                                    12.0 * unit * unit, 6.0 * unit, 1.0},
                                   0.7 * unit),
                  {.sample_time = 0.2 * unit}, 200);
  };
  const VectorXd in_minutes = response(1.0);
  for (const double unit : {60.0, 1e-9, 1e9}) {
    EXPECT_LE((response(unit) - in_minutes).cwiseAbs().maxCoeff(), 1e-10)
        << unit;
  }
}

TEST(PlantAccuracyTest, AgreesWithTheMatrixExponential) {
  const ProcessModel model = testing::MixedModel();
  const int steps = 300;
  const StepResponse exact = model.ComputeStepResponse(0.2, steps + 1);
  for (int j = 0; j < model.num_inputs(); ++j) {
    MatrixXd inputs = MatrixXd::Zero(model.num_inputs(), steps);
    inputs.row(j).setOnes();
    const MatrixXd y = Simulate(model, {.sample_time = 0.2}, inputs);
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
TEST(PlantAccuracyTest, RandomInputAgainstTheExactDiscretisation) {
  const double K = 6.6, T = 10.9, dt = 0.2;
  const int steps = 5000;
  const MatrixXd u = GaussianNoise(3, 0).DrawMatrix(1, steps, 1.0);
  for (const auto& [q, f] : std::vector<std::pair<int, double>>{
           {0, 0.0}, {0, 0.4}, {5, 0.0}, {5, 0.75}}) {
    const MatrixXd y =
        Simulate(SingleLoop(TransferFunction::FirstOrder(K, T, (q + f) * dt)),
                 {.sample_time = dt}, u);
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
TEST(PlantAccuracyTest, RandomInputsAgainstSuperposedStepResponses) {
  const ProcessModel model = testing::MixedModel();
  const int steps = 250;
  const MatrixXd u = GaussianNoise(4, 0).DrawMatrix(3, steps, 1.0);
  const MatrixXd y = Simulate(model, {.sample_time = 0.2}, u);
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

// Steps that divide both parts of a sample, so that each halving of
// relative_step is one of the steps.
TEST(PlantAccuracyTest, ConvergesWithOrderFour) {
  const TransferFunction element = SecondOrder(1.0, 0.5, 2.0, 1.0, 2.0);
  const double dt = 8.0;
  const VectorXd exact = element.StepResponse(dt, 4);
  std::vector<double> log_step, log_error;
  for (double relative = 0.5; relative > 0.02; relative /= 2.0) {
    const VectorXd y =
        StepOf(element, {.sample_time = dt, .relative_step = relative}, 3);
    log_step.push_back(std::log2(relative));
    log_error.push_back(std::log2((y - exact).cwiseAbs().maxCoeff()));
  }
  const Eigen::Map<VectorXd> x(log_step.data(), log_step.size());
  const Eigen::Map<VectorXd> e(log_error.data(), log_error.size());
  const VectorXd centred = x.array() - x.mean();
  EXPECT_NEAR(centred.dot(e) / centred.squaredNorm(), 4.0, 0.2);
}

}  // namespace
}  // namespace mle::sim
