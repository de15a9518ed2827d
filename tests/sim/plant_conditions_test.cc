// Disturbances, valves and measurement faults in the closed loop.

#include "sim/plant_conditions.h"

#include <cmath>
#include <functional>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/closed_loop.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using ::mle::testing::EmptyModel;
using ::testing::HasSubstr;

void Idle(const Eigen::Ref<const VectorXd>&, const Eigen::Ref<const VectorXd>&,
          Eigen::Ref<VectorXd> next) {
  next.setZero();
}

Record SimulateUnder(const ProcessModel& model, const Controller& controller,
                     const ClosedLoopOptions& options,
                     const PlantConditions& conditions) {
  absl::StatusOr<Record> record =
      SimulateClosedLoop(model, controller, {}, options, conditions);
  EXPECT_TRUE(record.ok()) << record.status();
  return *std::move(record);
}

// The outputs of an idle plant of two outputs.
MatrixXd Outputs(const PlantConditions& conditions,
                 const ClosedLoopOptions& options = {}) {
  return SimulateUnder(EmptyModel(2, 1), Idle, options, conditions).outputs;
}

PlantConditions Coloured(double variance, double time_constant = 10.0) {
  PlantConditions conditions;
  conditions.output_disturbance.coloured_variance =
      Vector2d(variance, 2.0 * variance);
  conditions.output_disturbance.coloured_time_constant = time_constant;
  return conditions;
}

// Each kind adds the same signal whether the others are there or not.
TEST(OutputDisturbanceTest, KindsDoNotDisturbEachOther) {
  const MatrixXd noise = Outputs({});
  std::vector<PlantConditions> kinds(3);
  kinds[0].output_disturbance.coloured_variance = Vector2d(0.1, 0.2);
  kinds[1].output_disturbance.drift_variance = Vector2d(1e-3, 0.0);
  kinds[2].output_disturbance.step_deviation = Vector2d(1.0, 3.0);
  kinds[2].output_disturbance.step_rate = 0.01;
  PlantConditions all = kinds[0];
  all.output_disturbance.drift_variance =
      kinds[1].output_disturbance.drift_variance;
  all.output_disturbance.step_deviation =
      kinds[2].output_disturbance.step_deviation;
  all.output_disturbance.step_rate = 0.01;

  MatrixXd sum = noise;
  for (const PlantConditions& kind : kinds) {
    const MatrixXd signal = Outputs(kind) - noise;
    EXPECT_GT(signal.norm(), 1.0);
    sum += signal;
  }
  EXPECT_LE((Outputs(all) - sum).norm(), 1e-11);
}

TEST(OutputDisturbanceTest, SizesScaleTheSamePath) {
  const ClosedLoopOptions quiet{.noise_variance = 0.0};
  EXPECT_LE(
      (Outputs(Coloured(0.4), quiet) - 2.0 * Outputs(Coloured(0.1), quiet))
          .norm(),
      1e-12);
}

TEST(OutputDisturbanceTest, ColouredNoiseHasItsVarianceAndCorrelation) {
  const double time_constant = 2.0;
  const MatrixXd y = Outputs(Coloured(0.1, time_constant),
                             {.duration = 40000.0, .noise_variance = 0.0});
  const auto n = static_cast<double>(y.cols());
  for (int i = 0; i < 2; ++i) {
    const double variance = y.row(i).squaredNorm() / n;
    // About 40000 / (2 · 2) independent values: a standard error of 1.4 %.
    EXPECT_NEAR(variance / (0.1 * (i + 1)), 1.0, 0.06);
    const double lag_one =
        y.row(i).head(y.cols() - 1).dot(y.row(i).tail(y.cols() - 1)) / n;
    EXPECT_NEAR(lag_one / variance, std::exp(-0.2 / time_constant), 0.005);
  }
}

TEST(OutputDisturbanceTest, DriftIsARandomWalkFromZero) {
  PlantConditions conditions;
  conditions.output_disturbance.drift_variance = Vector2d(1e-4, 4e-4);
  const MatrixXd y =
      Outputs(conditions, {.duration = 4000.0, .noise_variance = 0.0});
  const auto n = y.cols() - 1;
  const MatrixXd increments = y.rightCols(n) - y.leftCols(n);
  EXPECT_EQ(y.col(0).norm(), 0.0);
  for (int i = 0; i < 2; ++i) {
    const double q = increments.row(i).squaredNorm() / static_cast<double>(n);
    // 20,000 increments: a standard error of 1 %.
    EXPECT_NEAR(q / conditions.output_disturbance.drift_variance[i], 1.0, 0.05);
  }
}

TEST(OutputDisturbanceTest, StepsAreRareAndHold) {
  PlantConditions conditions;
  conditions.output_disturbance.step_deviation = Vector2d(2.0, 0.0);
  conditions.output_disturbance.step_rate = 0.01;
  const MatrixXd y =
      Outputs(conditions, {.duration = 20000.0, .noise_variance = 0.0});
  int steps = 0;
  for (int k = 1; k < y.cols(); ++k) steps += y(0, k) != y(0, k - 1) ? 1 : 0;
  // Poisson with mean 200 and standard deviation 14.
  EXPECT_NEAR(steps, 200, 60);
  EXPECT_EQ(y.row(1).norm(), 0.0);
}

ProcessModel WithDisturbance() {
  ProcessModel model("d", "min",
                     {{"u", "1"}, {"d", "1", InputRole::kDisturbance}},
                     {{"y", "1"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 3.0, 0.5);
  model.element(0, 1) = TransferFunction::FirstOrder(-1.0, 4.0, 0.0);
  return model;
}

TEST(InputDisturbanceTest, ActsOnThePlantAndIsShownToTheController) {
  PlantConditions conditions;
  conditions.input_disturbance.steps = {{1, 10.0, 3.0}, {1, 20.1, -1.0}};
  std::vector<double> seen;
  const Controller controller = [&seen](const auto&, const auto&, auto next) {
    seen.push_back(next[1]);
    next[1] = 77.0;  // Not the controller's to move.
  };
  const Record record =
      SimulateUnder(WithDisturbance(), controller,
                    {.duration = 40.0, .noise_variance = 0.0}, conditions);
  for (int k = 0; k < record.samples(); ++k) {
    const double t = record.time(k);
    const double d = t < 10.0 - 1e-9 ? 0.0 : t < 20.1 ? 3.0 : -1.0;
    ASSERT_EQ(record.inputs(1, k), d) << t;
    double expected = 0.0;
    if (t > 10.0) expected += 3.0 * std::expm1(-(t - 10.0) / 4.0);
    if (t > 20.2) expected -= 4.0 * std::expm1(-(t - 20.2) / 4.0);
    ASSERT_NEAR(record.outputs(0, k), expected, 1e-8) << t;
  }
  ASSERT_EQ(seen.size(), 41u);
  EXPECT_EQ(seen[9], 0.0);
  EXPECT_EQ(seen[10], 3.0);
  EXPECT_EQ(seen[21], -1.0);
}

TEST(InputDisturbanceTest, NoiseIsDrawnForDisturbancesAlone) {
  PlantConditions conditions;
  conditions.input_disturbance.variance = Vector2d(5.0, 0.25);
  conditions.input_disturbance.time_constant = 1.0;
  const Record record =
      SimulateUnder(WithDisturbance(), Idle, {.duration = 20000.0}, conditions);
  EXPECT_EQ(record.inputs.row(0).norm(), 0.0);
  // About 10,000 independent values: a standard error of 1.4 %.
  EXPECT_NEAR(record.inputs.row(1).squaredNorm() / record.samples(), 0.25,
              0.02);
}

TEST(ValveLimitsTest, HoldWhateverTheControllerAsksFor) {
  PlantConditions conditions;
  conditions.valves.min = Vector2d(-0.5, 0.0);
  conditions.valves.max = Vector2d(0.25, 0.0);
  int calls = 0;
  const Controller controller = [&calls](const auto&, const auto&, auto next) {
    next[0] = ++calls < 20 ? 10.0 : -10.0;
  };
  const Record record =
      SimulateUnder(WithDisturbance(), controller,
                    {.duration = 100.0, .noise_variance = 0.0}, conditions);
  EXPECT_EQ(record.inputs.row(0).maxCoeff(), 0.25);
  EXPECT_EQ(record.inputs.row(0).minCoeff(), -0.5);
  // What the plant settles at is what came through: 2 · (−0.5).
  EXPECT_NEAR(record.outputs(0, record.samples() - 1), -1.0, 1e-8);
}

TEST(MeasurementFaultsTest, OutliersHaveTheirRateAndSize) {
  PlantConditions conditions;
  conditions.faults.outlier_probability = 0.01;
  conditions.faults.outlier_size = Vector2d(5.0, 0.0);
  const ClosedLoopOptions options{.duration = 20000.0};
  const MatrixXd outliers = Outputs(conditions, options) - Outputs({}, options);
  int count = 0;
  for (const double one : outliers.row(0)) {
    if (one == 0.0) continue;
    ++count;
    EXPECT_GE(std::abs(one), 1.0 - 1e-9);
    EXPECT_LE(std::abs(one), 5.0 + 1e-9);
  }
  EXPECT_NEAR(count, 1000, 150);  // Binomial, standard deviation 31.
  EXPECT_EQ(outliers.row(1).norm(), 0.0);
}

TEST(MeasurementFaultsTest, QuantisedValuesAreMultiples) {
  PlantConditions conditions;
  conditions.faults.quantum = Vector2d(0.25, 0.0);
  const ClosedLoopOptions options{.noise_variance = 1.0};
  const MatrixXd y = Outputs(conditions, options);
  const MatrixXd clean = Outputs({}, options);
  for (int k = 0; k < y.cols(); ++k) {
    ASSERT_EQ(y(0, k), 0.25 * std::round(4.0 * clean(0, k)));
    ASSERT_EQ(y(1, k), clean(1, k));
  }
}

TEST(MeasurementFaultsTest, FrozenChannelsRepeatTheirLastValue) {
  PlantConditions conditions;
  conditions.faults.freeze_rate = 0.01;
  conditions.faults.freeze_duration = 20.0;
  const ClosedLoopOptions options{.duration = 40000.0};
  const MatrixXd y = Outputs(conditions, options);
  const MatrixXd clean = Outputs({}, options);
  int frozen = 0;
  for (int k = 1; k < y.cols(); ++k) {
    if (y(0, k) == clean(0, k)) continue;
    ++frozen;
    ASSERT_EQ(y(0, k), y(0, k - 1));
  }
  // A freeze that meets another is the longer of both, so that it is frozen for
  // a little less than 1 − exp(−0.2) of the time, and more than half of that.
  const double part =
      static_cast<double>(frozen) / static_cast<double>(y.cols());
  EXPECT_LT(part, 0.25);
  EXPECT_GT(part, 0.1);
}

TEST(MeasurementFaultsTest, LostSamplesAreNanInTheRecordOnly) {
  PlantConditions conditions;
  conditions.faults.lost_probability = 0.2;
  conditions.faults.lost_input_probability = 0.1;
  const ProcessModel model = WithDisturbance();
  std::vector<double> seen;
  const Controller controller = [&seen](const auto& y, const auto&, auto next) {
    seen.push_back(y[0]);
    next[0] = 0.5;
  };
  const ClosedLoopOptions options{.control_period = 0.2, .duration = 2000.0};
  const Record record = SimulateUnder(model, controller, options, conditions);
  const Record clean = SimulateUnder(
      model, [](const auto&, const auto&, auto next) { next[0] = 0.5; },
      options, {});
  int lost = 0;
  double last_good = 0.0;
  for (int k = 0; k < record.samples(); ++k) {
    if (std::isnan(record.outputs(0, k))) {
      ++lost;
    } else {
      ASSERT_EQ(record.outputs(0, k), clean.outputs(0, k));
      last_good = record.outputs(0, k);
    }
    ASSERT_EQ(seen[k], last_good);
  }
  EXPECT_NEAR(lost, 2000, 250);  // Binomial, standard deviation 40.
  const auto lost_inputs = record.inputs.row(0).array().isNaN().count();
  EXPECT_NEAR(static_cast<double>(lost_inputs), 1000.0, 180.0);  // 30
}

TEST(MeasurementFaultsTest, FaultsMayBeTheHistoriansAlone) {
  PlantConditions conditions;
  conditions.faults.outlier_probability = 0.1;
  conditions.faults.outlier_size = VectorXd::Constant(1, 100.0);
  conditions.faults.lost_probability = 0.1;
  conditions.faults.only_in_record = true;
  double worst = 0.0;
  const Controller controller = [&worst](const auto& y, const auto&,
                                         auto next) {
    worst = std::max(worst, std::abs(y[0]));
    next.setZero();
  };
  const Record record =
      SimulateUnder(WithDisturbance(), controller, {}, conditions);
  EXPECT_LT(worst, 1.0);
  EXPECT_TRUE(record.outputs.hasNaN());
}

TEST(PlantConditionsTest, AreChecked) {
  const auto message = [](const std::function<void(PlantConditions&)>& spoil) {
    PlantConditions conditions;
    spoil(conditions);
    const absl::Status status = conditions.Validate(WithDisturbance());
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message([](auto& c) {
                c.output_disturbance.drift_variance = Vector2d(1.0, 1.0);
              }),
              HasSubstr("drift_variance has 2 values, but it needs 1"));
  EXPECT_THAT(message([](auto& c) {
                c.output_disturbance.coloured_time_constant = 0.0;
              }),
              HasSubstr("coloured_time_constant = 0"));
  EXPECT_THAT(message([](auto& c) { c.output_disturbance.step_rate = -1.0; }),
              HasSubstr("step_rate = -1"));
  EXPECT_THAT(message([](auto& c) {
                c.input_disturbance.steps = {{0, 1.0, 1.0}};
              }),
              HasSubstr("input 'u' is moved by the controller"));
  EXPECT_THAT(message([](auto& c) {
                c.input_disturbance.steps = {{2, 1.0, 1.0}};
              }),
              HasSubstr("input = 2"));
  EXPECT_THAT(message([](auto& c) { c.faults.lost_probability = 1.5; }),
              HasSubstr("lost_probability = 1.5"));
  EXPECT_THAT(message([](auto& c) {
                c.valves.min = Vector2d(1.0, 0.0);
                c.valves.max = Vector2d(0.0, 0.0);
              }),
              HasSubstr("min = 1 above max = 0"));
  EXPECT_THAT(message([](auto& c) {
                c.manual = {{.input = 1, .from = 1.0, .to = 2.0}};
              }),
              HasSubstr("input = 1 in manual"));
  EXPECT_THAT(message([](auto& c) {
                c.manual = {{.input = 0, .from = 2.0, .to = 2.0}};
              }),
              HasSubstr("manual from 2 to 2"));
  EXPECT_THAT(message([](auto& c) { c.loads = {{.answered = INFINITY}}; }),
              HasSubstr("answered = inf"));
}

}  // namespace
}  // namespace mle::sim
