// The controller on plants that its model knows exactly or nearly.

#include <utility>

#include "control/mpc.h"
#include "gtest/gtest.h"
#include "sim/plant.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::EmptyModel;
using testing::SecondOrder;

ProcessModel TwoByTwoPlant() {
  ProcessModel model = EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  model.element(0, 1) = SecondOrder(-0.5, 0.0, 3.0, 1.0, 0.4);
  model.element(1, 0) = TransferFunction::FirstOrder(0.4, 8.0, 2.3);
  model.element(1, 1) = SecondOrder(1.5, -0.7, 4.0, 2.0, 0.0);
  return model;
}

MpcOptions ClosedOptions(double ratio = 0.1) {
  MpcOptions options;
  options.output_weight = MatrixXd::Identity(2, 2);
  options.move_weight = MatrixXd::Identity(2, 2) * 0.1;
  options.disturbance_variance_ratio = ratio;
  return options;
}

struct ClosedLoop {
  Mpc mpc;
  sim::Plant plant;
  VectorXd input = VectorXd::Zero(2);
  VectorXd next = VectorXd::Zero(2);

  // One control period with `disturbance` on the outputs. Returns what is
  // measured at its beginning.
  VectorXd Advance(const VectorXd& set_points, const VectorXd& disturbance) {
    input = next;
    const VectorXd measured = plant.outputs() + disturbance;
    mpc.Step(measured, set_points, next);
    plant.Advance(input);
    return measured;
  }
};

ClosedLoop MakeClosedLoop(const ProcessModel& plant_model,
                          const MpcOptions& options) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(TwoByTwoPlant(), options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  absl::StatusOr<sim::Plant> plant =
      sim::Plant::Create(plant_model, {.sample_time = options.control_period});
  EXPECT_TRUE(plant.ok()) << plant.status();
  return {*std::move(mpc), *std::move(plant)};
}

TEST(MpcClosedLoopTest, PerfectModelReachesTheSetPoint) {
  ClosedLoop loop = MakeClosedLoop(TwoByTwoPlant(), ClosedOptions());
  const VectorXd r = (VectorXd(2) << 1.0, -2.0).finished();
  VectorXd y;
  for (int l = 0; l < 200; ++l) y = loop.Advance(r, VectorXd::Zero(2));
  // The plant's integration error, 1e-8 of the response, is the only mismatch.
  EXPECT_LE((y - r).cwiseAbs().maxCoeff(), 1e-8);
}

// With a perfect model nothing is ever observed, so that the observer cannot
// matter.
TEST(MpcClosedLoopTest, PerfectModelMakesTheObserverIdle) {
  ClosedLoop slow = MakeClosedLoop(TwoByTwoPlant(), ClosedOptions(0.001));
  ClosedLoop quick = MakeClosedLoop(TwoByTwoPlant(), ClosedOptions(10.0));
  const VectorXd r = (VectorXd(2) << 1.0, -2.0).finished();
  for (int l = 0; l < 60; ++l) {
    const VectorXd a = slow.Advance(r, VectorXd::Zero(2));
    const VectorXd b = quick.Advance(r, VectorXd::Zero(2));
    ASSERT_LE((a - b).cwiseAbs().maxCoeff(), 1e-7) << l;
  }
}

TEST(MpcClosedLoopTest, NoOffsetUnderAConstantOutputDisturbance) {
  ClosedLoop loop = MakeClosedLoop(TwoByTwoPlant(), ClosedOptions());
  const VectorXd r = (VectorXd(2) << 1.0, 0.5).finished();
  const VectorXd w = (VectorXd(2) << -0.7, 0.4).finished();
  VectorXd y;
  for (int l = 0; l < 300; ++l) {
    y = loop.Advance(r, l < 50 ? VectorXd::Zero(2) : w);
  }
  EXPECT_LE((y - r).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(MpcClosedLoopTest, NoOffsetWithAWrongGainAndDeadTime) {
  ProcessModel plant = TwoByTwoPlant();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.6, 5.0, 1.5);
  plant.element(1, 1) = SecondOrder(1.9, -0.7, 4.0, 2.0, 0.0);
  ClosedLoop loop = MakeClosedLoop(plant, ClosedOptions());
  const VectorXd r = (VectorXd(2) << 1.0, 0.5).finished();
  VectorXd y;
  for (int l = 0; l < 400; ++l) y = loop.Advance(r, VectorXd::Zero(2));
  EXPECT_LE((y - r).cwiseAbs().maxCoeff(), 1e-8);
}

// Without an observer (ρ = 0) a disturbance is not noticed at all.
TEST(MpcClosedLoopTest, WithoutObserverADisturbanceStays) {
  ClosedLoop loop = MakeClosedLoop(TwoByTwoPlant(), ClosedOptions(0.0));
  const VectorXd r = VectorXd::Ones(2);
  const VectorXd w = (VectorXd(2) << -0.7, 0.4).finished();
  VectorXd y;
  for (int l = 0; l < 300; ++l) y = loop.Advance(r, w);
  EXPECT_LE((y - (r + w)).cwiseAbs().maxCoeff(), 1e-8);
}

}  // namespace
}  // namespace mle::control
