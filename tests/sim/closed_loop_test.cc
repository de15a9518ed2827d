#include "sim/closed_loop.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;
using ::testing::HasSubstr;
using testing::MixedModel;
using testing::SingleLoop;

void LeaveAlone(const Ref<const VectorXd>&, const Ref<const VectorXd>&,
                Ref<VectorXd> next) {
  next.setZero();
}

// Proportional feedback for a single loop.
Controller Proportional(double gain) {
  return [gain](const Ref<const VectorXd>& y, const Ref<const VectorXd>& r,
                Ref<VectorXd> next) { next = gain * (r - y); };
}

Record Simulate(const ProcessModel& plant, const Controller& controller,
                const SetPointProfile& set_points,
                const ClosedLoopOptions& options) {
  const absl::StatusOr<Record> record =
      SimulateClosedLoop(plant, controller, set_points, options);
  EXPECT_TRUE(record.ok()) << record.status();
  return *record;
}

TEST(ClosedLoopTest, RecordHasTheShapeOfTheExperiment) {
  const Record record =
      Simulate(MixedModel(), LeaveAlone,
               {.steps = {{.output = 1, .time = 5.0, .value = 3.0}}},
               {.duration = 10.0});
  EXPECT_TRUE(record.Validate().ok());
  EXPECT_EQ(record.samples(), 51);
  EXPECT_EQ(record.num_inputs(), 3);
  EXPECT_EQ(record.num_outputs(), 2);
  EXPECT_EQ(record.sample_time, 0.2);
  EXPECT_EQ(record.set_points(1, 24), 0.0);
  EXPECT_EQ(record.set_points(1, 25), 3.0);
}

// The n-th call returns n: it acts one period later, the first period is zero.
TEST(ClosedLoopTest, OutputOfTheControllerActsFromTheNextInstantOn) {
  double calls = 0.0;
  const auto count = [&calls](const Ref<const VectorXd>&,
                              const Ref<const VectorXd>&, Ref<VectorXd> next) {
    next.setConstant(++calls);
  };
  const Record record =
      Simulate(MixedModel(), count, {},
               {.sample_time = 0.2, .control_period = 0.6, .duration = 2.2});
  const Eigen::RowVectorXd expected =
      (Eigen::RowVectorXd(12) << 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3).finished();
  for (int j = 0; j < 3; ++j) EXPECT_EQ(record.inputs.row(j), expected);
  EXPECT_EQ(calls, 4.0);
}

TEST(ClosedLoopTest, ControllerSeesWhatIsRecordedAtItsInstants) {
  std::vector<VectorXd> measured, set_points;
  const auto look = [&](const Ref<const VectorXd>& y,
                        const Ref<const VectorXd>& r, Ref<VectorXd> next) {
    measured.push_back(y);
    set_points.push_back(r);
    next.setConstant(y.sum());
  };
  const Record record = Simulate(
      MixedModel(), look,
      {.steps = {{.time = 3.0, .value = 2.0}, {.output = 1, .time = 4.1}}},
      {.sample_time = 0.2, .control_period = 1.0, .duration = 8.0});
  ASSERT_EQ(measured.size(), 9U);
  for (int l = 0; l < 9; ++l) {
    EXPECT_EQ(measured[l], record.outputs.col(5 * l));
    EXPECT_EQ(set_points[l], record.set_points.col(5 * l));
  }
  EXPECT_GT(measured[0].norm(), 0.0);  // Noise, from the first sample on.
}

// P control of K/(Ts + 1) with the period of delay: a scalar recursion,
// x_{l+1} = a x_l + K (1 − a) u_l, u_{l+1} = g (r − x_l).
TEST(ClosedLoopTest, ProportionalLoopAgainstItsRecursion) {
  const double K = 2.0, T = 3.0, g = 0.8;
  const Record record =
      Simulate(SingleLoop(TransferFunction::FirstOrder(K, T, 0.0)),
               Proportional(g), {.steps = {{.time = 0.0, .value = 1.0}}},
               {.sample_time = 0.25,
                .control_period = 0.5,
                .duration = 30.0,
                .noise_variance = 0.0});
  const double a = std::exp(-0.5 / T);
  double x = 0.0, u = 0.0;
  for (int l = 0; l <= 60; ++l) {
    ASSERT_NEAR(record.outputs(0, 2 * l), x, 1e-8) << l;
    ASSERT_NEAR(record.inputs(0, 2 * l), u, 1e-8) << l;
    const double next_u = g * (1.0 - x);
    x = a * x + K * (1.0 - a) * u;
    u = next_u;
  }
}

TEST(ClosedLoopTest, OutputsAreTheResponseToTheRecordedInputsPlusWhiteNoise) {
  const ProcessModel plant =
      SingleLoop(TransferFunction::FirstOrder(1.5, 4.0, 0.7));
  const double variance = 0.04;
  const Record record = Simulate(
      plant, Proportional(0.2), {.steps = {{.time = 50.0, .value = 1.0}}},
      {.duration = 600.0, .noise_variance = variance});
  const int N = record.samples();
  const StepResponse phi = plant.ComputeStepResponse(0.2, N);
  VectorXd noise(N);
  for (int k = 0; k < N; ++k) {
    double response = 0.0;
    for (int i = 0; i < k; ++i) {
      const double before = i > 0 ? record.inputs(0, i - 1) : 0.0;
      response += phi.element(0, 0)[k - i] * (record.inputs(0, i) - before);
    }
    noise[k] = (record.outputs(0, k) - response) / std::sqrt(variance);
  }
  // Five standard errors each.
  const double root = std::sqrt(static_cast<double>(N));
  EXPECT_NEAR(noise.mean(), 0.0, 5.0 / root);
  EXPECT_NEAR(noise.squaredNorm() / N, 1.0, 5.0 * std::sqrt(2.0) / root);
  EXPECT_NEAR(noise.head(N - 1).dot(noise.tail(N - 1)) / N, 0.0, 5.0 / root);
}

TEST(ClosedLoopTest, SeedAndStreamDecideTheNoise) {
  ClosedLoopOptions options{.duration = 20.0, .seed = 3, .stream = 1};
  const MatrixXd y = Simulate(MixedModel(), LeaveAlone, {}, options).outputs;
  EXPECT_EQ(y, Simulate(MixedModel(), LeaveAlone, {}, options).outputs);
  options.stream = 2;
  EXPECT_NE(y, Simulate(MixedModel(), LeaveAlone, {}, options).outputs);
  options = {.duration = 20.0, .seed = 4, .stream = 1};
  EXPECT_NE(y, Simulate(MixedModel(), LeaveAlone, {}, options).outputs);
}

TEST(ClosedLoopTest, LongerRunBeginsAsTheShorterOne) {
  const ClosedLoopOptions brief{.duration = 20.0};
  const ClosedLoopOptions lasting{.duration = 30.0};
  const ProcessModel plant =
      SingleLoop(TransferFunction::FirstOrder(1.0, 2.0, 0.5));
  const Record a = Simulate(plant, Proportional(0.5), {}, brief);
  const Record b = Simulate(plant, Proportional(0.5), {}, lasting);
  EXPECT_EQ(a.outputs, b.outputs.leftCols(a.samples()));
  EXPECT_EQ(a.inputs, b.inputs.leftCols(a.samples()));
}

TEST(ClosedLoopTest, ReportsALoopThatRunsAway) {
  const absl::StatusOr<Record> record = SimulateClosedLoop(
      SingleLoop(TransferFunction::FirstOrder(1.0, 2.0, 1.0)),
      Proportional(20.0), {.steps = {{.time = 5.0, .value = 1.0}}}, {});
  EXPECT_EQ(record.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(record.status().message()), HasSubstr("diverges"));
  EXPECT_THAT(std::string(record.status().message()), HasSubstr("at time "));
}

TEST(ClosedLoopTest, ReportsAControllerThatReturnsNoNumber) {
  const auto broken = [](const Ref<const VectorXd>&, const Ref<const VectorXd>&,
                         Ref<VectorXd> next) {
    next.setZero();
    next[1] = std::numeric_limits<double>::quiet_NaN();
  };
  const absl::StatusOr<Record> record =
      SimulateClosedLoop(MixedModel(), broken, {}, {});
  EXPECT_EQ(record.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(record.status().message()),
              HasSubstr("input 'u2' is not a number at time 1"));
}

// The same loop with the output in units of 1e-9 and 1e9, the input in units of
// 1e9 and 1e-9: no false alarm, and the same record but for the units.
TEST(ClosedLoopTest, RunawayDoesNotDependOnUnits) {
  const auto run = [](double output_unit, double input_unit) {
    return Simulate(SingleLoop(TransferFunction::FirstOrder(
                        2.0 * output_unit / input_unit, 3.0, 0.5)),
                    Proportional(0.4 * input_unit / output_unit),
                    {.steps = {{.time = 1.0, .value = output_unit}}},
                    {.duration = 30.0, .noise_variance = 0.0});
  };
  const Record plain = run(1.0, 1.0);
  for (const double unit : {1e-9, 1e9}) {
    const Record scaled = run(unit, 1.0 / unit);
    EXPECT_LE((scaled.outputs / unit - plain.outputs).norm(), 1e-12);
    EXPECT_LE((scaled.inputs * unit - plain.inputs).norm(), 1e-12);
  }
}

// u1 moves both outputs, u2 the first alone, whose set point stands at zero: u2
// has to make up for what u1 does there.
TEST(ClosedLoopTest, AnInputMayMakeUpForAnother) {
  ProcessModel plant("", "min", {{"u1", ""}, {"u2", ""}},
                     {{"y1", ""}, {"y2", ""}});
  plant.element(0, 0) = TransferFunction::FirstOrder(0.5, 2.0, 0.0);
  plant.element(0, 1) = TransferFunction::FirstOrder(2.0, 2.0, 0.0);
  plant.element(1, 0) = TransferFunction::FirstOrder(1.0, 2.0, 0.0);
  const auto decoupled = [](const Ref<const VectorXd>& outputs,
                            const Ref<const VectorXd>& set_points,
                            Ref<VectorXd> next) {
    next[0] = 0.5 * (set_points[1] - outputs[1]);
    next[1] = -0.25 * next[0];
  };
  const Record record = Simulate(
      plant, decoupled, {.steps = {{.output = 1, .time = 1.0, .value = 1.0}}},
      {.duration = 20.0, .noise_variance = 0.0});
  EXPECT_NEAR(record.outputs.rightCols<1>()[1], 1.0 / 3.0, 1e-3);
  EXPECT_LE(record.outputs.row(0).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(record.inputs.row(1).cwiseAbs().maxCoeff(), 0.05);
}

TEST(ClosedLoopTest, WithoutSetPointsAndNoiseARunIsPossible) {
  const Record record = Simulate(
      SingleLoop(TransferFunction::FirstOrder(1.0, 2.0, 0.5)),
      Proportional(0.5), {}, {.duration = 20.0, .noise_variance = 0.0});
  EXPECT_EQ(record.outputs.norm(), 0.0);
}

TEST(ClosedLoopTest, ArgumentsAreChecked) {
  const auto message = [](const ClosedLoopOptions& options,
                          const SetPointProfile& set_points) {
    const absl::Status status =
        SimulateClosedLoop(MixedModel(), LeaveAlone, set_points, options)
            .status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message({.sample_time = -0.2}, {}),
              HasSubstr("sample_time is -0.2"));
  EXPECT_THAT(message({.control_period = 0.5}, {}),
              HasSubstr("whole multiple of sample_time = 0.2"));
  EXPECT_THAT(message({.control_period = 0.0}, {}),
              HasSubstr("control_period = 0"));
  EXPECT_THAT(message({.duration = 0.0}, {}), HasSubstr("duration = 0"));
  EXPECT_THAT(message({.noise_variance = -1.0}, {}),
              HasSubstr("noise_variance = -1"));
  EXPECT_THAT(message({}, {.steps = {{.output = 2}}}), HasSubstr("output = 2"));
}

}  // namespace
}  // namespace mle::sim
