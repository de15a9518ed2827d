// Levels under the controller: step responses that end in a ramp.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/LU"
#include "control/loop_analysis.h"
#include "control/mpc.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_model.h"
#include "sim/plant.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::SingleLoop;

ProcessModel ReadConfig(const std::string& name) {
  absl::StatusOr<ProcessModel> model =
      ReadProcessModel(MLE_CONFIG_DIR "/" + name);
  EXPECT_TRUE(model.ok()) << model.status();
  return *std::move(model);
}

MpcOptions Options(int num_outputs, int num_inputs) {
  MpcOptions options;
  options.output_weight = MatrixXd::Identity(num_outputs, num_outputs);
  options.move_weight = MatrixXd::Identity(num_inputs, num_inputs) * 0.5;
  return options;
}

struct Loop {
  Mpc mpc;
  sim::Plant plant;
  VectorXd next;

  // One control period, with `load` at the inputs.
  VectorXd Advance(const VectorXd& set_points, const VectorXd& load) {
    const VectorXd acting = next + load;
    const VectorXd measured = plant.outputs();
    mpc.Step(measured, set_points, next);
    plant.Advance(acting);
    return measured;
  }
};

Loop MakeLoop(const ProcessModel& believed, const ProcessModel& truth) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(
      believed, Options(believed.num_outputs(), believed.num_inputs()));
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  absl::StatusOr<sim::Plant> plant =
      sim::Plant::Create(truth, {.sample_time = 1.0});
  EXPECT_TRUE(plant.ok()) << plant.status();
  return {*std::move(mpc), *std::move(plant),
          VectorXd::Zero(believed.num_inputs())};
}

TEST(IntegratingPredictionTest, GoesOnWithItsSlope) {
  const ProcessModel model =
      SingleLoop(TransferFunction::Integrator(0.5, 2.0, 1.4));
  auto prediction = PredictFromProcess(model, 0.7);
  ASSERT_TRUE(prediction.ok()) << prediction.status();
  EXPECT_TRUE(prediction->IsIntegrating());
  EXPECT_EQ(prediction->slopes(0, 0), 0.35);
  const int n = prediction->periods();
  prediction->ReachTo(3 * n);
  const VectorXd expected = model.element(0, 0).StepResponse(0.7, 3 * n + 1);
  // 1e-11 of the gain is left at n.
  EXPECT_LE((prediction->responses.col(0) - expected).cwiseAbs().maxCoeff(),
            1e-9);
  EXPECT_FALSE(PredictFromProcess(testing::MixedModel(), 0.7)->IsIntegrating());
  prediction->slopes.resize(2, 1);
  EXPECT_FALSE(prediction->Validate().ok());
}

// One move of a pure integrator, S_k = K k: the minimiser of the cost with the
// slope at the end, in closed form.
TEST(IntegratingMpcTest, FirstMoveBalancesTheSlopeAtTheEnd) {
  const double K = 0.4, R = 3.0;
  const int H = 12;
  MpcOptions options = Options(1, 1);
  options.prediction_horizon = H;
  options.control_horizon = 1;
  options.move_weight(0, 0) = R;
  const auto mpc = Mpc::Create(
      SingleLoop(TransferFunction::Integrator(K, 0.0, 0.0)), options);
  ASSERT_TRUE(mpc.ok()) << mpc.status();
  const VectorXd e = GaussianNoise(1, 0).DrawMatrix(H, 1, 1.0);
  const double W = H * (H + 1.0) * (2.0 * H + 1.0) / 6.0;
  double numerator = W * K * (e(H - 1) - e(H - 2));
  double denominator = R + W * K * K;
  for (int i = 1; i <= H; ++i) {
    numerator += e(i - 1) * K * (i - 1);
    denominator += K * K * (i - 1) * (i - 1);
  }
  EXPECT_NEAR((mpc->gain() * e)(0), numerator / denominator, 1e-12);
}

// Several moves, some of them held, of two outputs of which one integrates,
// under a weight that couples them: the normal equations of the header.
TEST(IntegratingMpcTest, FirstMoveSolvesTheNormalEquations) {
  ProcessModel model = testing::MixedModel();
  model.element(0, 1) = TransferFunction::Integrator(0.3, 2.0, 1.0);
  MpcOptions options = Options(2, model.num_inputs());
  options.control_period = 0.7;
  options.prediction_horizon = 15;
  options.block_lengths = {1, 1, 3, 2, 4};
  options.output_weight << 1.0, 0.3, 0.3, 2.0;
  const auto mpc = Mpc::Create(model, options);
  ASSERT_TRUE(mpc.ok()) << mpc.status();
  const auto prediction = PredictFromProcess(model, 0.7);
  const std::vector<int> instants = options.MoveInstants();
  const int H = options.prediction_horizon;
  const int m = model.num_inputs();
  MatrixXd G = MatrixXd::Zero(2 * H, 5 * m);
  MatrixXd Q = MatrixXd::Zero(2 * H, 2 * H);
  for (int i = 1; i <= H; ++i) {
    Q.block(2 * (i - 1), 2 * (i - 1), 2, 2) = options.output_weight;
    for (int b = 0; b < 5; ++b) {
      if (i < instants[b]) continue;
      G.block(2 * (i - 1), m * b, 2, m) =
          prediction->responses.middleRows(2 * (i - instants[b]), 2);
    }
  }
  MatrixXd slope = MatrixXd::Zero(2, 2 * H);  // of the first output alone
  slope(0, 2 * H - 2) = 1.0;
  slope(0, 2 * H - 4) = -1.0;
  Q += H * (H + 1.0) * (2.0 * H + 1.0) / 6.0 * slope.transpose() *
       options.output_weight * slope;
  const MatrixXd hessian =
      G.transpose() * Q * G + 0.5 * MatrixXd::Identity(5 * m, 5 * m);
  const MatrixXd gain = hessian.inverse() * G.transpose() * Q;
  EXPECT_LE((mpc->gain() - gain.topRows(m)).cwiseAbs().maxCoeff(),
            1e-10 * gain.cwiseAbs().maxCoeff());
}

TEST(IntegratingObserverTest, FollowsARampWithoutError) {
  DisturbanceObserver observer(VectorXd::Constant(2, 0.1), {true, false});
  const double theta = std::sqrt(1.0 - observer.gains()(0));
  VectorXd errors(60);
  for (int l = 0; l < 60; ++l) {
    const double w = 2.0 + 0.3 * l;
    errors(l) = w - observer.disturbance()(0);
    observer.Update(VectorXd::Constant(2, w), VectorXd::Zero(2));
    observer.Advance();
  }
  EXPECT_NEAR(observer.slope()(0), 0.3, 1e-2);
  EXPECT_EQ(observer.slope()(1), 0.0);
  // A double pole at θ: (1 − θB)² e is 0 from the third sample on.
  for (int l = 2; l < 60; ++l) {
    EXPECT_NEAR(errors(l),
                2.0 * theta * errors(l - 1) - theta * theta * errors(l - 2),
                1e-12);
  }
}

TEST(IntegratingLoopTest, ConstantLoadsLeaveNoOffset) {
  for (const std::string name : {"level", "column_level"}) {
    const ProcessModel model = ReadConfig(name + ".json");
    // The controller's model, and a plant that is not its model.
    for (const ProcessModel& plant : {model, ReadConfig(name + "_aged.json")}) {
      Loop loop = MakeLoop(model, plant);
      VectorXd r = VectorXd::Ones(model.num_outputs());
      const VectorXd load = VectorXd::Constant(model.num_inputs(), 0.7);
      VectorXd y;
      for (int l = 0; l < 1500; ++l) {
        if (l == 700) r *= -2.0;
        y = loop.Advance(r, load);
        if (l == 699) {
          EXPECT_LE((y - r).cwiseAbs().maxCoeff(), 1e-6) << name;
        }
      }
      EXPECT_LE((y - r).cwiseAbs().maxCoeff(), 1e-6) << name;
    }
  }
}

TEST(IntegratingLoopTest, AtRestAnExchangeMovesNothing) {
  const ProcessModel model = ReadConfig("column_level.json");
  const ProcessModel other = ReadConfig("column_level_aged.json");
  Loop loop = MakeLoop(model, other);
  const VectorXd r = VectorXd::Ones(3);
  const VectorXd load = VectorXd::Constant(3, 0.7);
  for (int l = 0; l < 2500; ++l) loop.Advance(r, load);
  const VectorXd before = loop.next;
  const auto prediction = PredictFromProcess(other, 1.0);
  ASSERT_TRUE(prediction.ok());
  ASSERT_TRUE(loop.mpc.ExchangeModel(*prediction, Options(3, 3)).ok());
  for (int l = 0; l < 60; ++l) {
    loop.Advance(r, load);
    EXPECT_LE((loop.next - before).cwiseAbs().maxCoeff(), 1e-6) << l;
  }
}

TEST(IntegratingLoopTest, RestartStandsStill) {
  const ProcessModel model = ReadConfig("level.json");
  auto mpc = Mpc::Create(model, Options(1, 2));
  ASSERT_TRUE(mpc.ok());
  VectorXd inputs(2);
  inputs << 5.0, 3.0;
  const VectorXd level = VectorXd::Constant(1, 40.0);
  mpc->Restart(inputs, level);
  VectorXd next(2);
  for (int l = 0; l < 30; ++l) {
    mpc->Step(level, level, next);
    EXPECT_NEAR(next(0), 5.0, 1e-10);
  }
}

TEST(IntegratingLoopTest, MeasuredInflowIsFedForward) {
  const ProcessModel model = ReadConfig("level.json");
  const auto largest = [&](bool feed_forward) {
    Loop loop = MakeLoop(model, model);
    double deviation = 0.0;
    for (int l = 0; l < 200; ++l) {
      VectorXd inflow = VectorXd::Zero(2);
      inflow(1) = l < 20 ? 0.0 : 1.0;
      if (feed_forward) loop.mpc.MeasureDisturbances(inflow.tail(1));
      const VectorXd y = loop.Advance(VectorXd::Zero(1), inflow);
      deviation = std::max(deviation, std::abs(y(0)));
    }
    return deviation;
  };
  EXPECT_LT(largest(true), 0.5 * largest(false));
}

// Where the simulated loop stops to settle as the level's gain grows, the
// analysis says so too.
TEST(IntegratingLoopTest, TheAnalysisAgreesWithTheSimulation) {
  const ProcessModel believed = ReadConfig("column_level.json");
  const Loop nominal = MakeLoop(believed, believed);
  int stable = 0;
  int unstable = 0;
  for (const double factor : {1.0, 1.6, 2.2, 3.0, 4.0}) {
    ProcessModel truth = believed;
    for (int i = 0; i < truth.num_outputs(); ++i) {
      for (int j = 0; j < truth.num_inputs(); ++j) {
        const TransferFunction g = truth.element(i, j);
        if (!g.IsIntegrating()) continue;
        std::vector<double> numerator = g.numerator();
        for (double& b : numerator) b *= factor;
        truth.element(i, j) =
            TransferFunction(numerator, g.denominator(), g.delay());
      }
    }
    const auto analysis =
        AnalyseLoop(nominal.mpc, *PredictFromProcess(truth, 1.0));
    ASSERT_TRUE(analysis.ok()) << analysis.status();
    Loop loop = MakeLoop(believed, truth);
    const VectorXd load = VectorXd::Constant(believed.num_inputs(), 0.1);
    double early = 0.0;
    double late = 0.0;
    for (int l = 0; l < 1200; ++l) {
      const double size =
          loop.Advance(VectorXd::Zero(believed.num_outputs()), load).norm();
      if (l < 400) early = std::max(early, size);
      if (l >= 800) late = std::max(late, size);
    }
    EXPECT_EQ(analysis->stable, late < early) << factor;
    ++(analysis->stable ? stable : unstable);
  }
  EXPECT_GT(stable, 0);
  EXPECT_GT(unstable, 0);
}

}  // namespace
}  // namespace mle::control
