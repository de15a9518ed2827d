// Mpc of a model whose channels have transforms.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "control/mpc.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "sim/plant.h"
#include "sim/transformed_plant.h"
#include "tests/mle/model/transforms.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPeriod = 1.0;

ProcessModel Valve(bool transformed) {
  ProcessModel model("heater", "min", {{"valve", "%"}}, {{"flow", "m3/h"}});
  model.element(0, 0) = TransferFunction::FirstOrder(0.5, 5.0, 2.0);
  if (transformed) model.set_input_transform(0, EqualPercentage(40.0, 30.0));
  return model;
}

MpcOptions Tuning() {
  MpcOptions options;
  options.control_period = kPeriod;
  options.prediction_horizon = 20;
  options.control_horizon = 4;
  options.output_weight = MatrixXd::Identity(1, 1);
  options.move_weight = MatrixXd::Constant(1, 1, 0.01);
  return options;
}

// The set point is followed on the bent plant from valve = 30 %, for 40
// periods; the sum of squared errors and, if wanted, all inputs.
double Follow(Mpc& mpc, double set_point, VectorXd* inputs = nullptr) {
  auto linear = sim::Plant::Create(Valve(true), {.sample_time = kPeriod});
  EXPECT_TRUE(linear.ok());
  sim::TransformedPlant plant(std::make_unique<sim::Plant>(*std::move(linear)),
                              Valve(true));
  double sum = 0.0;
  VectorXd next = VectorXd::Constant(1, 30.0);
  if (inputs != nullptr) inputs->resize(40);
  for (int k = 0; k < 40; ++k) {
    const VectorXd acting = next;
    const VectorXd measured = plant.outputs();
    sum += std::pow(measured[0] - set_point, 2);
    mpc.Step(measured, VectorXd::Constant(1, set_point), next);
    if (inputs != nullptr) (*inputs)[k] = next[0];
    plant.Advance(VectorXd::Constant(1, acting[0] - 30.0));
  }
  return sum;
}

Mpc MpcOf(const ProcessModel& model, const MpcOptions& options) {
  auto mpc = Mpc::Create(model, options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

// Where the valve is wide open its gain is many times that at the operating
// point: a controller that knows the curve follows as anywhere, one that does
// not swings.
TEST(TransformedMpcTest, FollowsWhereverItsGainIsAnother) {
  for (const double set_point : {-6.0, 60.0}) {
    Mpc knows = MpcOf(Valve(true), Tuning());
    // The dead time of two periods and little more.
    EXPECT_LT(Follow(knows, set_point), 6.0 * set_point * set_point);
  }
  Mpc knows = MpcOf(Valve(true), Tuning());
  Mpc linear = MpcOf(Valve(false), Tuning());
  linear.Restart(VectorXd::Constant(1, 30.0), VectorXd::Zero(1));
  EXPECT_LT(Follow(knows, 60.0), 0.8 * Follow(linear, 60.0));
}

// Limits of inputs and moves hold in engineering values.
TEST(TransformedMpcTest, LimitsAreOfEngineeringValues) {
  MpcOptions options = Tuning();
  options.limits.min_input = VectorXd::Constant(1, 10.0);
  options.limits.max_input = VectorXd::Constant(1, 60.0);
  options.limits.max_move = VectorXd::Constant(1, 4.0);
  Mpc mpc = MpcOf(Valve(true), options);
  VectorXd inputs;
  Follow(mpc, 500.0, &inputs);
  EXPECT_NEAR(inputs.maxCoeff(), 60.0, 1e-6);
  double before = 30.0;
  for (const double input : inputs) {
    EXPECT_LE(std::abs(input - before), 4.0 + 1e-9);
    before = input;
  }
}

TEST(TransformedMpcTest, ALimitThatNoTransformHoldsIsNamed) {
  MpcOptions options = Tuning();
  options.limits.max_move = VectorXd::Constant(1, 4.0);
  const auto fault = [&] {
    return std::string(Mpc::Create(Valve(true), options).status().message());
  };
  EXPECT_NE(fault().find("max_move of valve = 4"), std::string::npos);
  ProcessModel model = Valve(true);
  model.set_input_transform(0, Root(30.0));
  options.limits.max_move.resize(0);
  options.limits.min_input = VectorXd::Constant(1, -5.0);
  EXPECT_NE(std::string(Mpc::Create(model, options).status().message())
                .find("min_input of valve = -5: its transform"),
            std::string::npos);
}

// A sample without a transform is missing, as one that is not a number.
TEST(TransformedMpcTest, AValueWithoutATransformIsMissing) {
  ProcessModel model = Valve(false);
  model.set_output_transform(0, Logarithm(2.0));
  Mpc one = MpcOf(model, Tuning());
  Mpc other = MpcOf(model, Tuning());
  VectorXd next(1);
  VectorXd next_other(1);
  const VectorXd set_point = VectorXd::Constant(1, 2.5);
  one.Step(VectorXd::Constant(1, -1.0), set_point, next);
  other.Step(VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN()),
             set_point, next_other);
  EXPECT_EQ(next[0], next_other[0]);
  EXPECT_TRUE(std::isfinite(next[0]));
  EXPECT_NEAR(one.PredictedOutputs()[0], 2.0, 1e-9);
}

}  // namespace
}  // namespace mle::control
