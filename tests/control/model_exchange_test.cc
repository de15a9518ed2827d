// Exchanging the model of a running controller.

#include <string>
#include <utility>

#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/plant.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::EmptyModel;
using ::testing::HasSubstr;

ProcessModel TwoByTwo(double gain, double delay) {
  ProcessModel model = EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0 * gain, 5.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-0.5, 3.0, delay);
  model.element(1, 0) = TransferFunction::FirstOrder(0.4, 8.0, 2.3 + delay);
  model.element(1, 1) = TransferFunction::FirstOrder(1.5 / gain, 4.0, 0.0);
  return model;
}

MpcOptions ExchangeOptions() {
  MpcOptions options;
  options.output_weight = MatrixXd::Identity(2, 2);
  options.move_weight = MatrixXd::Identity(2, 2) * 0.1;
  return options;
}

PredictionModel Predict(const ProcessModel& model) {
  absl::StatusOr<PredictionModel> prediction = PredictFromProcess(model, 1.0);
  EXPECT_TRUE(prediction.ok()) << prediction.status();
  return *std::move(prediction);
}

struct ExchangeLoop {
  Mpc mpc;
  sim::Plant plant;
  VectorXd input = VectorXd::Zero(2);
  VectorXd next = VectorXd::Zero(2);

  void Advance(const VectorXd& set_points) {
    input = next;
    mpc.Step(plant.outputs(), set_points, next);
    plant.Advance(input);
  }
};

ExchangeLoop MakeExchangeLoop(const ProcessModel& believed,
                              const ProcessModel& truth) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(believed, ExchangeOptions());
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  absl::StatusOr<sim::Plant> plant =
      sim::Plant::Create(truth, {.sample_time = 1.0});
  EXPECT_TRUE(plant.ok()) << plant.status();
  return {*std::move(mpc), *std::move(plant)};
}

const VectorXd& SetPoint() {
  static const VectorXd r = (VectorXd(2) << 1.0, -2.0).finished();
  return r;
}

// At rest at the set point, with a model that is wrong in gains and dead times:
// exchanging it for the right one must move nothing, then or later.
TEST(ModelExchangeTest, AtRestNothingMoves) {
  ExchangeLoop loop = MakeExchangeLoop(TwoByTwo(1.0, 1.0), TwoByTwo(1.4, 2.0));
  for (int l = 0; l < 600; ++l) loop.Advance(SetPoint());
  const VectorXd before = loop.next;
  ASSERT_GT(before.norm(), 0.1);
  ASSERT_TRUE(
      loop.mpc.ExchangeModel(Predict(TwoByTwo(1.4, 2.0)), ExchangeOptions())
          .ok());
  for (int l = 0; l < 100; ++l) {
    loop.Advance(SetPoint());
    // The loop had settled to its last digits, as had the model.
    ASSERT_LE((loop.next - before).cwiseAbs().maxCoeff(), 1e-8) << l;
  }
}

TEST(ModelExchangeTest, PredictedOutputsGoOn) {
  ExchangeLoop loop = MakeExchangeLoop(TwoByTwo(1.0, 1.0), TwoByTwo(1.4, 2.0));
  for (int l = 0; l < 12; ++l) loop.Advance(SetPoint());
  const VectorXd before = loop.mpc.PredictedOutputs();
  ASSERT_TRUE(
      loop.mpc.ExchangeModel(Predict(TwoByTwo(0.8, 3.0)), ExchangeOptions())
          .ok());
  EXPECT_LE((loop.mpc.PredictedOutputs() - before).cwiseAbs().maxCoeff(),
            1e-12);
}

// In the middle of a transient, the same model again: the free response that is
// rebuilt from the inputs is the one that was carried.
TEST(ModelExchangeTest, TheSameModelChangesNothing) {
  ExchangeLoop one = MakeExchangeLoop(TwoByTwo(1.0, 1.0), TwoByTwo(1.4, 2.0));
  ExchangeLoop other = MakeExchangeLoop(TwoByTwo(1.0, 1.0), TwoByTwo(1.4, 2.0));
  for (int l = 0; l < 700; ++l) {
    // Longer than the history too.
    if (l % 37 == 5) {
      ASSERT_TRUE(
          other.mpc
              .ExchangeModel(Predict(TwoByTwo(1.0, 1.0)), ExchangeOptions())
              .ok());
    }
    const VectorXd r = (l / 40) % 2 == 0 ? SetPoint() : -SetPoint();
    one.Advance(r);
    other.Advance(r);
    ASSERT_LE((one.next - other.next).cwiseAbs().maxCoeff(), 1e-9) << l;
  }
}

// There and back again: what a short model forgets of the past is no more than
// what had settled.
TEST(ModelExchangeTest, ThereAndBackAgain) {
  const ProcessModel slow = TwoByTwo(1.0, 1.0);
  ProcessModel quick = EmptyModel(2, 2);
  quick.element(0, 0) = TransferFunction::FirstOrder(2.0, 0.5, 0.0);
  quick.element(1, 1) = TransferFunction::FirstOrder(1.0, 0.5, 0.0);
  ExchangeLoop one = MakeExchangeLoop(slow, TwoByTwo(1.4, 2.0));
  ExchangeLoop other = MakeExchangeLoop(slow, TwoByTwo(1.4, 2.0));
  for (int l = 0; l < 60; ++l) {
    if (l == 30) {
      ASSERT_TRUE(
          other.mpc.ExchangeModel(Predict(quick), ExchangeOptions()).ok());
      ASSERT_TRUE(
          other.mpc.ExchangeModel(Predict(slow), ExchangeOptions()).ok());
    }
    one.Advance(SetPoint());
    other.Advance(SetPoint());
    ASSERT_LE((one.next - other.next).cwiseAbs().maxCoeff(), 1e-9) << l;
  }
}

// What it is for: after the exchange the loop answers as one that had the right
// model all along.
TEST(ModelExchangeTest, ControlIsThatOfTheNewModel) {
  const ProcessModel truth = TwoByTwo(1.4, 2.0);
  ExchangeLoop exchanged = MakeExchangeLoop(TwoByTwo(1.0, 1.0), truth);
  ExchangeLoop right = MakeExchangeLoop(truth, truth);
  for (int l = 0; l < 600; ++l) {
    exchanged.Advance(SetPoint());
    right.Advance(SetPoint());
  }
  MpcOptions retuned = ExchangeOptions();
  retuned.prediction_horizon = 40;
  retuned.move_weight *= 2.0;
  ASSERT_TRUE(exchanged.mpc.ExchangeModel(Predict(truth), retuned).ok());
  ASSERT_TRUE(right.mpc.ExchangeModel(Predict(truth), retuned).ok());
  for (int l = 0; l < 100; ++l) {
    exchanged.Advance(-SetPoint());
    right.Advance(-SetPoint());
    ASSERT_LE((exchanged.next - right.next).cwiseAbs().maxCoeff(), 1e-7) << l;
  }
}

TEST(ModelExchangeTest, RestartStandsWhereThePlantStands) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(TwoByTwo(1.0, 1.0), ExchangeOptions());
  ASSERT_TRUE(mpc.ok());
  const VectorXd u = (VectorXd(2) << 30.0, 70.0).finished();
  const VectorXd y = (VectorXd(2) << 96.25, 0.5).finished();
  mpc->Restart(u, y);
  EXPECT_LE((mpc->PredictedOutputs() - y).cwiseAbs().maxCoeff(), 1e-12);
  VectorXd next(2);
  for (int l = 0; l < 10; ++l) {
    mpc->Step(y, y, next);
    ASSERT_LE((next - u).cwiseAbs().maxCoeff(), 1e-10);
  }
  // Also after an exchange.
  ASSERT_TRUE(
      mpc->ExchangeModel(Predict(TwoByTwo(2.0, 5.0)), ExchangeOptions()).ok());
  mpc->Step(y, y, next);
  EXPECT_LE((next - u).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(ModelExchangeTest, RefusesAnotherShapeAndStaysAsItWas) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(TwoByTwo(1.0, 1.0), ExchangeOptions());
  ASSERT_TRUE(mpc.ok());
  const absl::Status shape = mpc->ExchangeModel(
      Predict(testing::SingleLoop(TransferFunction::FirstOrder(1, 1, 0))),
      ExchangeOptions());
  EXPECT_THAT(std::string(shape.message()), HasSubstr("1 outputs"));
  MpcOptions other_period = ExchangeOptions();
  other_period.control_period = 2.0;
  const absl::Status period =
      mpc->ExchangeModel(Predict(TwoByTwo(1.0, 1.0)), other_period);
  EXPECT_THAT(std::string(period.message()), HasSubstr("keeps its period"));
  EXPECT_EQ(mpc->options().control_period, 1.0);
}

}  // namespace
}  // namespace mle::control
