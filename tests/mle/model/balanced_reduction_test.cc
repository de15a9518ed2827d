#include "mle/model/balanced_reduction.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/largest_gain.h"
#include "tests/mle/base/optimised_algebra.h"
#include "tests/sim/test_models.h"

namespace mle {
namespace {

using ::mle::testing::EmptyModel;
using ::testing::HasSubstr;

// g(s) = K ω² / (s² + 2ζω s + ω²) e^{−Ls}.
TransferFunction Resonance(double gain, double damping, double frequency,
                           double delay) {
  const double square = frequency * frequency;
  return TransferFunction({gain * square},
                          {1.0, 2.0 * damping * frequency, square}, delay);
}

ProcessModel WoodBerry() {
  ProcessModel model = EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-18.9, 21.0, 3.0);
  model.element(1, 0) = TransferFunction::FirstOrder(6.6, 10.9, 7.0);
  model.element(1, 1) = TransferFunction::FirstOrder(-19.4, 14.4, 3.0);
  return model;
}

// A light resonance, an inverse response, dead times that are not whole
// samples, feedthrough and a pair that is zero.
ProcessModel Awkward() {
  ProcessModel model = EmptyModel(2, 3);
  model.element(0, 0) = Resonance(2.0, 0.03, 0.6, 2.3);
  model.element(0, 1) = TransferFunction({-8.0, 1.0}, {30.0, 11.0, 1.0}, 0.75);
  model.element(0, 2) = TransferFunction({2.0, 3.0}, {5.0, 1.0}, 4.1);
  model.element(1, 0) = TransferFunction::FirstOrder(1e-4, 90.0, 12.0);
  model.element(1, 2) = Resonance(-500.0, 0.2, 1.5, 0.0);
  return model;
}

// Poles, dead times and gains by chance; a tenth of the pairs is zero.
ProcessModel RandomPlant(int p, int m, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  ProcessModel model = EmptyModel(p, m);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      if (uniform(engine) < 0.1) continue;
      const double slow = std::exp(1.0 + 3.0 * uniform(engine));
      const double fast = slow * (0.1 + 0.9 * uniform(engine));
      const double gain = normal(engine) * std::exp(4.0 * uniform(engine));
      model.element(i, j) = TransferFunction(
          {gain * slow * uniform(engine), gain},
          {slow * fast, slow + fast, 1.0}, 15.0 * uniform(engine));
    }
  }
  return model;
}

ReducedModel Reduce(const ProcessModel& model, double sample_time,
                    double tolerance) {
  ReductionOptions options;
  options.tolerance = tolerance;
  auto reduced = ReduceModel(model, sample_time, options);
  EXPECT_TRUE(reduced.ok()) << reduced.status();
  return *std::move(reduced);
}

// Impulse responses h(l), l = 0 … samples − 1, by differences of the step
// responses (transfer_function.h), which know nothing of the realisation.
Eigen::MatrixXd Impulses(const ProcessModel& model, double sample_time,
                         int samples) {
  return sample_time *
         ImpulseResponses(model.ComputeStepResponse(sample_time, samples));
}

// Largest magnitudes of step responses and gains.
Eigen::MatrixXd Sizes(const ProcessModel& model, double sample_time,
                      int samples) {
  const StepResponse response = model.ComputeStepResponse(sample_time, samples);
  Eigen::MatrixXd sizes = StaticGains(model).cwiseAbs();
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      sizes(i, j) =
          std::max(sizes(i, j), response.element(i, j).cwiseAbs().maxCoeff());
      if (sizes(i, j) == 0.0) sizes(i, j) = 1.0;
    }
  }
  return sizes;
}

// C (zI − A)⁻¹ B + D with the dead times.
Eigen::MatrixXcd Transfer(const DiscreteStateSpace& system, double omega) {
  Eigen::MatrixXcd transfer =
      FrequencyResponse(system.A, system.B, system.C, system.D, omega);
  for (int i = 0; i < system.num_outputs(); ++i) {
    for (int j = 0; j < system.num_inputs(); ++j) {
      transfer(i, j) *= std::polar(
          1.0, -omega * (system.input_delays[j] + system.output_delays[i]));
    }
  }
  return transfer;
}

// Σ_l h(l) e^{−jωl}.
Eigen::MatrixXcd Transfer(const Eigen::MatrixXd& impulses, int p, int m,
                          double omega) {
  return FourierSums(impulses, omega).reshaped<Eigen::RowMajor>(p, m);
}

std::vector<double> Frequencies() {
  std::vector<double> frequencies;
  for (int k = 0; k <= 300; ++k) {
    frequencies.push_back(3.14159 * std::pow(10.0, -5.0 * k / 300.0));
    frequencies.push_back(3.14159 * k / 300.0);
  }
  return frequencies;
}

// Over the frequencies and for each tolerance: no element is off by more than
// the bound, which is not far above the largest error either, and no row, as a
// whole, by more than twice the sum of the singular values neglected.
void CheckBounds(const ProcessModel& model, double sample_time, int samples) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  const Eigen::MatrixXd impulses = Impulses(model, sample_time, samples);
  const Eigen::MatrixXcd sizes =
      Sizes(model, sample_time, samples).cast<std::complex<double>>();
  std::vector<Eigen::MatrixXcd> wanted;
  for (const double omega : Frequencies()) {
    wanted.push_back(Transfer(impulses, p, m, omega));
  }
  for (const double tolerance : {0.1, 5e-3, 1e-5}) {
    SCOPED_TRACE(tolerance);
    const ReducedModel reduced = Reduce(model, sample_time, tolerance);
    Eigen::VectorXd largest = Eigen::VectorXd::Zero(p);
    Eigen::VectorXd largest_row = Eigen::VectorXd::Zero(p);
    std::size_t next = 0;
    for (const double omega : Frequencies()) {
      const Eigen::MatrixXd error =
          (wanted[next++] - Transfer(reduced.system, omega))
              .cwiseQuotient(sizes)
              .cwiseAbs();
      largest = largest.cwiseMax(error.rowwise().maxCoeff());
      largest_row = largest_row.cwiseMax(error.rowwise().norm());
    }
    for (int i = 0; i < p; ++i) {
      // 1e-8: what the impulse responses leave out, and rounding.
      EXPECT_LE(largest(i), reduced.error_bounds(i) + 1e-8) << i;
      EXPECT_GE(1.5 * largest(i), reduced.error_bounds(i) - 1e-8) << i;
      EXPECT_LE(largest_row(i), reduced.hankel_bounds(i) + 1e-8) << i;
      EXPECT_LE(reduced.error_bounds(i), tolerance) << i;
      EXPECT_LE(reduced.largest_differences(i), tolerance) << i;
    }
  }
}

TEST(BalancedReductionTest, TheErrorIsWithinItsBoundAtEveryFrequency) {
  CheckBounds(WoodBerry(), 0.5, 2000);
  CheckBounds(Awkward(), 0.5, 8000);
  CheckBounds(RandomPlant(3, 7, 11), 1.0, 3000);
}

// Of the largest difference that is reported, an independent computation.
TEST(BalancedReductionTest, TheLargestDifferenceIsThatOfTheStepResponses) {
  const ProcessModel model = Awkward();
  const ReducedModel reduced = Reduce(model, 0.5, 0.02);
  const StepResponse wanted = model.ComputeStepResponse(0.5, 3000);
  const StepResponse found = reduced.system.ComputeStepResponse(3000);
  const Eigen::MatrixXd sizes = Sizes(model, 0.5, 3000);
  for (int i = 0; i < 2; ++i) {
    double largest = 0.0;
    for (int j = 0; j < 3; ++j) {
      const double off =
          (wanted.element(i, j) - found.element(i, j)).cwiseAbs().maxCoeff();
      largest = std::max(largest, off / sizes(i, j));
    }
    EXPECT_GT(largest, 1e-4);
    EXPECT_NEAR(reduced.largest_differences(i), largest, 1e-6);
  }
}

TEST(LargestGainTest, IsAtMostFourPercentAboveTheMaximumOnADenseGrid) {
  std::mt19937 engine(9);
  std::normal_distribution<double> normal;
  for (const int size : {1, 2, 3, 7, 64, 100}) {
    Eigen::VectorXd impulse(size);
    for (double& value : impulse) value = normal(engine);
    double largest = 0.0;
    for (int k = 0; k <= 20000; ++k) {
      const double omega = 3.141592653589793 * k / 20000.0;
      std::complex<double> sum = 0.0;
      for (int l = 0; l < size; ++l) {
        sum += impulse(l) * std::polar(1.0, -omega * l);
      }
      largest = std::max(largest, std::abs(sum));
    }
    EXPECT_GE(LargestGainBound(impulse), largest * (1.0 - 1e-12)) << size;
    EXPECT_LE(LargestGainBound(impulse), 1.041 * largest) << size;
  }
  // All of it at one frequency between those of the transform.
  Eigen::VectorXd wave(100);
  for (int l = 0; l < 100; ++l) wave(l) = std::cos(1.2345 * l);
  EXPECT_GE(LargestGainBound(wave), 50.0);
  EXPECT_EQ(LargestGainBound(Eigen::VectorXd()), 0.0);
}

// The singular values of the matrix of impulse responses h(a + b − 1), written
// out, are those found by factors of gramians.
TEST(BalancedReductionTest, HankelValuesAreThoseOfTheHankelMatrix) {
  ProcessModel model = EmptyModel(2, 3);
  // Another output, so that dead times cannot be taken out of the inputs.
  for (int j = 0; j < 3; ++j) {
    model.element(1, j) = TransferFunction::FirstOrder(1.0, 3.0, 0.0);
  }
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 6.0, 1.0);
  model.element(0, 1) = Resonance(-0.5, 0.2, 0.7, 9.4);
  model.element(0, 2) = TransferFunction({-3.0, 1.0}, {8.0, 6.0, 1.0}, 5.0);
  const int half = 220;
  const Eigen::MatrixXd impulses = Impulses(model, 1.0, 2 * half);
  const Eigen::MatrixXd sizes = Sizes(model, 1.0, 2 * half);
  Eigen::MatrixXd hankel(half, 3 * half);
  for (int j = 0; j < 3; ++j) {
    for (int a = 0; a < half; ++a) {
      for (int b = 0; b < half; ++b) {
        const int lag = a + b + 2;  // one whole sample is taken out
        hankel(a, j * half + b) =
            lag < 2 * half ? impulses(lag, j) / sizes(0, j) : 0.0;
      }
    }
  }
  const Eigen::VectorXd expected = SingularValues(hankel);
  const ReducedModel reduced = Reduce(model, 1.0, 1e-3);
  EXPECT_EQ(reduced.system.input_delays[0] + reduced.system.output_delays[0],
            1);
  const Eigen::VectorXd& found = reduced.hankel_values[0];
  ASSERT_GE(found.size(), 12);
  for (int k = 0; k < 12; ++k) {
    EXPECT_NEAR(found(k), expected(k), 1e-9 * expected(0)) << k;
  }
}

// x_{k+1} = a x_k + u_k, y = (1 − a) x: σ = (1 − a) / (1 − a²).
TEST(BalancedReductionTest, TheValueOfAFirstOrderElementIsItsClosedForm) {
  ProcessModel model = EmptyModel(1, 1);
  model.element(0, 0) = TransferFunction::FirstOrder(-7.0, 50.0, 4.0);
  const ReducedModel reduced = Reduce(model, 0.5, 5e-3);
  const double a = std::exp(-0.01);
  ASSERT_EQ(reduced.hankel_values[0].size(), 1);
  EXPECT_NEAR(reduced.hankel_values[0](0), (1.0 - a) / (1.0 - a * a), 1e-12);
  EXPECT_EQ(reduced.system.order(), 1);
  EXPECT_NEAR(reduced.system.A(0, 0), a, 1e-12);
  EXPECT_EQ(reduced.system.input_delays[0], 8);
  EXPECT_LT(reduced.error_bounds(0), 1e-11);
  EXPECT_LT(reduced.largest_differences(0), 1e-12);
}

TEST(BalancedReductionTest, AtFullOrderTheModelIsExact) {
  for (const ProcessModel& model :
       {WoodBerry(), Awkward(), RandomPlant(4, 4, 3)}) {
    const ReducedModel reduced = Reduce(model, 0.5, 1e-9);
    const StepResponse exact = model.ComputeStepResponse(0.5, 900);
    const StepResponse found = reduced.system.ComputeStepResponse(900);
    const Eigen::MatrixXd sizes = Sizes(model, 0.5, 900);
    for (int i = 0; i < model.num_outputs(); ++i) {
      for (int j = 0; j < model.num_inputs(); ++j) {
        EXPECT_LT(
            (exact.element(i, j) - found.element(i, j)).cwiseAbs().maxCoeff(),
            1e-9 * sizes(i, j))
            << i << " " << j;
      }
    }
    EXPECT_LT((reduced.system.StaticGains() - StaticGains(model))
                  .cwiseQuotient(sizes)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
  }
}

// The orders of what has no dead times to approximate are those of the plant.
TEST(BalancedReductionTest, ElementsThatShareTheirDynamicsShareTheirStates) {
  ProcessModel model = EmptyModel(2, 3);
  for (int j = 0; j < 3; ++j) {
    model.element(0, j) = TransferFunction({1.0 + j}, {60.0, 16.0, 1.0}, 2.0);
    model.element(1, j) = TransferFunction::FirstOrder(-2.0, 7.0, 2.0 + j);
  }
  const ReducedModel reduced = Reduce(model, 1.0, 1e-9);
  EXPECT_EQ(reduced.orders[0], 2);
  EXPECT_EQ(reduced.orders[1], 1 + 2);  // and the line: dead times differ
  EXPECT_EQ(reduced.system.order(), reduced.orders[0] + reduced.orders[1]);
}

TEST(BalancedReductionTest, ChangesOfUnitsChangeNothingElse) {
  const ProcessModel model = Awkward();
  ProcessModel other = model;
  const double outputs[] = {1e5, 3.0};
  const double inputs[] = {1e-3, 7.0, 1e4};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      std::vector<double> numerator = model.element(i, j).numerator();
      for (double& value : numerator) value *= outputs[i] / inputs[j];
      other.element(i, j) =
          TransferFunction(numerator, model.element(i, j).denominator(),
                           model.element(i, j).delay());
    }
  }
  const ReducedModel a = Reduce(model, 0.5, 5e-3);
  const ReducedModel b = Reduce(other, 0.5, 5e-3);
  EXPECT_EQ(a.orders, b.orders);
  const StepResponse of_a = a.system.ComputeStepResponse(300);
  const StepResponse of_b = b.system.ComputeStepResponse(300);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(a.error_bounds(i), b.error_bounds(i), 1e-9);
    for (int j = 0; j < 3; ++j) {
      const double scale = outputs[i] / inputs[j];
      EXPECT_LT((of_b.element(i, j) / scale - of_a.element(i, j)).norm(),
                1e-9 * (1e-12 + of_a.element(i, j).norm()))
          << i << j;
    }
  }
}

TEST(BalancedReductionTest, AnOutputThatNothingMovesHasNoStates) {
  ProcessModel model = EmptyModel(3, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 0.0);
  model.element(2, 1) = TransferFunction::FirstOrder(2.0, 9.0, 3.0);
  const ReducedModel reduced = Reduce(model, 1.0, 5e-3);
  EXPECT_EQ(reduced.orders, (std::vector<int>{1, 0, 1}));
  EXPECT_TRUE(reduced.system.C.row(1).isZero(0.0));
  EXPECT_EQ(reduced.system.ComputeStepResponse(50).element(1, 0).norm(), 0.0);
}

// Dead times that differ by many samples take far fewer states.
TEST(BalancedReductionTest, ALineOfManySamplesIsCutShort) {
  ProcessModel model = EmptyModel(2, 2);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      model.element(i, j) =
          TransferFunction::FirstOrder(1.0, 40.0, i == j ? 1.0 : 61.0);
    }
  }
  const ReducedModel reduced = Reduce(model, 0.5, 0.02);
  EXPECT_LT(reduced.orders[0], 60);
  EXPECT_GT(reduced.orders[0], 3);
  EXPECT_EQ(reduced.orders[0], reduced.orders[1]);
  EXPECT_EQ(reduced.hankel_values[0].size(), 122);
}

std::string Refusal(const ProcessModel& model, double sample_time,
                    const ReductionOptions& options) {
  const auto reduced = ReduceModel(model, sample_time, options);
  EXPECT_FALSE(reduced.ok());
  return std::string(reduced.status().message());
}

TEST(BalancedReductionTest, FaultsSayWhatWouldBeRight) {
  const ProcessModel model = WoodBerry();
  EXPECT_THAT(Refusal(EmptyModel(1, 1), 1.0, {}), HasSubstr("is zero"));
  EXPECT_THAT(Refusal(model, 0.0, {}), HasSubstr("sample_time is 0"));
  ReductionOptions options;
  options.tolerance = 0.0;
  EXPECT_THAT(Refusal(model, 1.0, options), HasSubstr("tolerance is 0"));
  options = {};
  options.max_states = 0;
  EXPECT_THAT(Refusal(model, 1.0, options), HasSubstr("max_states is 0"));
  options.max_states = 50;
  EXPECT_THAT(Refusal(model, 0.05, options),
              HasSubstr("more than 50; a longer sample time"));
  options.max_states = 9;
  EXPECT_THAT(Refusal(model, 1.0, options),
              HasSubstr("at most 9 are supported"));
  options = {};
  options.tolerance = 1e-30;
  EXPECT_THAT(Refusal(model, 1.0, options), HasSubstr("rounding"));
}

// Levels beside outputs that settle: integrators of one row with dead times
// that differ, are not whole samples, with lags, a zero and an inverse
// response, and a pair of the row that settles.
TEST(BalancedReductionTest, LevelsKeepAnExactIntegrator) {
  ProcessModel model = EmptyModel(3, 3);
  model.element(0, 0) = TransferFunction::Integrator(0.3, 0.0, 1.0);
  model.element(0, 1) = TransferFunction::Integrator(-0.2, 4.0, 6.3);
  model.element(0, 2) = TransferFunction::FirstOrder(5.0, 9.0, 2.0);
  model.element(1, 0) = TransferFunction::FirstOrder(1.0, 7.0, 4.0);
  model.element(1, 1) = TransferFunction::FirstOrder(-2.0, 3.0, 1.5);
  model.element(2, 1) = TransferFunction::Integrator(2.0, 0.0, 5.0);
  model.element(2, 2) =
      TransferFunction({-0.6, 0.2}, {6.0, 5.0, 1.0, 0.0}, 8.1);
  constexpr double kSampleTime = 0.5;
  constexpr int kSamples = 2000;
  for (const double tolerance : {0.01, 1e-9}) {
    const absl::StatusOr<ReducedModel> reduced =
        ReduceModel(model, kSampleTime, {.tolerance = tolerance});
    ASSERT_TRUE(reduced.ok()) << reduced.status();
    const DiscreteStateSpace& system = reduced->system;
    EXPECT_TRUE(system.Validate().ok()) << system.Validate();
    EXPECT_LE(reduced->largest_differences.maxCoeff(), tolerance);
    EXPECT_LE(reduced->error_bounds.maxCoeff(), tolerance);
    EXPECT_GT(reduced->error_bounds.maxCoeff(), 0.0);
    const StepResponse found = system.ComputeStepResponse(kSamples);
    const StepResponse wanted =
        model.ComputeStepResponse(kSampleTime, kSamples);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const TransferFunction& g = model.element(i, j);
        const double size =
            std::abs(g.StaticGain()) *
            (g.IsIntegrating()
                 ? 10.0 * (g.delay() + g.SlowestTimeConstant() + kSampleTime)
                 : 1.0);
        EXPECT_LE(
            (found.element(i, j) - wanted.element(i, j)).cwiseAbs().maxCoeff(),
            1.01 * tolerance * size + 1e-9)
            << i << j;
        if (!g.IsIntegrating()) continue;
        EXPECT_NEAR(system.Slopes()(i, j), g.StaticGain(), 1e-9);
      }
    }
  }
  // Rounding of a dead time is nothing that is left to be reduced.
  ProcessModel rounded = EmptyModel(1, 2);
  rounded.element(0, 0) = TransferFunction::Integrator(0.3, 0.0, 1.0 + 1e-12);
  rounded.element(0, 1) = TransferFunction::Integrator(-0.3, 0.0, 5.4);
  const absl::StatusOr<ReducedModel> two =
      ReduceModel(rounded, kSampleTime, {});
  ASSERT_TRUE(two.ok()) << two.status();
  EXPECT_NEAR(two->system.ComputeStepResponse(100).element(0, 0)(99),
              0.3 * (99 * kSampleTime - 1.0), 1e-9);
  // A row of aligned integrators takes one state.
  ProcessModel tank = EmptyModel(1, 2);
  tank.element(0, 0) = TransferFunction::Integrator(0.3, 0.0, 1.0);
  tank.element(0, 1) = TransferFunction::Integrator(-0.3, 0.0, 2.0);
  const absl::StatusOr<ReducedModel> one = ReduceModel(tank, kSampleTime, {});
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->system.order(), 1);
  EXPECT_EQ(one->system.input_delays, (std::vector<int>{2, 4}));
}

}  // namespace
}  // namespace mle
