// Limits of inputs, moves and outputs, blocks of moves, preview, feed-forward.

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "Eigen/LU"
#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;
using testing::MixedModel;
using testing::SingleLoop;

MpcOptions LimitedOptions() {
  MpcOptions options;
  options.control_period = 0.7;
  options.prediction_horizon = 14;
  options.control_horizon = 4;
  options.output_weight = (MatrixXd(2, 2) << 2.0, 0.3, 0.3, 1.0).finished();
  options.move_weight = MatrixXd::Identity(3, 3) * 0.05;
  return options;
}

Mpc MakeLimitedMpc(const ProcessModel& model, const MpcOptions& options) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(model, options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

MpcLimits WideLimits(int p, int m) {
  MpcLimits limits;
  limits.min_input = VectorXd::Constant(m, -1e6);
  limits.max_input = VectorXd::Constant(m, 1e6);
  limits.max_move = VectorXd::Constant(m, 1e6);
  limits.min_output = VectorXd::Constant(p, -1e6);
  limits.max_output = VectorXd::Constant(p, 1e6);
  limits.output_limit_cost = VectorXd::Constant(p, 10.0);
  return limits;
}

TEST(MpcLimitsTest, LimitsThatAreNotMetChangeNothing) {
  MpcOptions limited = LimitedOptions();
  limited.limits = WideLimits(2, 3);
  Mpc with = MakeLimitedMpc(MixedModel(), limited);
  Mpc without = MakeLimitedMpc(MixedModel(), LimitedOptions());
  VectorXd u(3), v(3);
  std::srand(1);
  for (int l = 0; l < 100; ++l) {
    const VectorXd y = VectorXd::Random(2), r = VectorXd::Random(2);
    with.Step(y, r, u);
    without.Step(y, r, v);
    ASSERT_LE((u - v).cwiseAbs().maxCoeff(), 1e-9);
    ASSERT_EQ(with.last_plan().active_limits, 0);
  }
}

// Random limits, channels without any, set points, noise, and a plant that is
// another than the model: outputs are noise and a few of the inputs.
TEST(MpcLimitsTest, LimitsOfInputsAndMovesHold) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int active = 0;
  for (int trial = 0; trial < 40; ++trial) {
    MpcOptions options = LimitedOptions();
    MpcLimits& limits = options.limits;
    limits = WideLimits(2, 3);
    for (int j = 0; j < 3; ++j) {
      limits.min_input[j] =
          uniform(engine) < 0.2 ? -kInfinity : -uniform(engine);
      limits.max_input[j] = uniform(engine) < 0.2 ? kInfinity : uniform(engine);
      limits.max_move[j] =
          uniform(engine) < 0.2 ? kInfinity : 0.3 * uniform(engine);
    }
    limits.min_output.setConstant(-uniform(engine));
    limits.max_output.setConstant(uniform(engine));
    Mpc mpc = MakeLimitedMpc(MixedModel(), options);
    VectorXd last = VectorXd::Zero(3), next(3), y(2), r(2);
    for (int l = 0; l < 50; ++l) {
      y << 2.0 * last[0] - last[1] + uniform(engine) - 0.5,
          last[1] + 0.5 * last[2] + uniform(engine) - 0.5;
      if (l % 10 == 0) r = 4.0 * VectorXd::Random(2);
      mpc.Step(y, r, next);
      ASSERT_TRUE(mpc.last_plan().optimal);
      active += mpc.last_plan().active_limits;
      for (int j = 0; j < 3; ++j) {
        ASSERT_GE(next[j], limits.min_input[j]);
        ASSERT_LE(next[j], limits.max_input[j]);
        // One rounding of u + Δu.
        ASSERT_LE(std::abs(next[j] - last[j]), limits.max_move[j] + 1e-15);
      }
      last = next;
    }
  }
  EXPECT_GT(active, 5000);
}

// The plan, not only its first move: minimiser of J among all that keep the
// limits. Feasible neighbours cost more.
TEST(MpcLimitsTest, ThePlanIsOptimalAndKeepsItsLimitsToTheEnd) {
  MpcOptions options = LimitedOptions();
  MpcLimits& limits = options.limits;
  limits.min_input = VectorXd::Constant(3, -0.5);
  limits.max_input = VectorXd::Constant(3, 0.6);
  limits.max_move = VectorXd::Constant(3, 0.4);
  const auto model = PredictFromProcess(MixedModel(), options.control_period);
  ASSERT_TRUE(model.ok());
  absl::StatusOr<MovePlanner> planner = MovePlanner::Create(*model, options);
  ASSERT_TRUE(planner.ok()) << planner.status();

  const auto cost = [&](const MatrixXd& planned, const VectorXd& start,
                        const MatrixXd& errors) {
    double J = 0.0;
    for (int i = 1; i <= options.prediction_horizon; ++i) {
      VectorXd e = errors.col(i - 1);
      VectorXd before = start;
      for (int b = 0; b < std::min(i, options.control_horizon); ++b) {
        e -= model->responses.middleRows(2 * (i - 1 - b), 2) *
             (planned.col(b) - before);
        before = planned.col(b);
      }
      J += e.dot(options.output_weight * e);
    }
    VectorXd before = start;
    for (int b = 0; b < options.control_horizon; ++b) {
      const VectorXd move = planned.col(b) - before;
      J += move.dot(options.move_weight * move);
      before = planned.col(b);
    }
    return J;
  };
  const auto feasible = [&](const MatrixXd& planned, const VectorXd& start,
                            double tolerance) {
    VectorXd before = start;
    for (int b = 0; b < options.control_horizon; ++b) {
      const VectorXd move = planned.col(b) - before;
      if (planned.col(b).maxCoeff() > 0.6 + tolerance ||
          planned.col(b).minCoeff() < -0.5 - tolerance ||
          move.cwiseAbs().maxCoeff() > 0.4 + tolerance) {
        return false;
      }
      before = planned.col(b);
    }
    return true;
  };

  std::srand(3);
  const VectorXd zero = VectorXd::Zero(2 * options.prediction_horizon);
  for (int trial = 0; trial < 20; ++trial) {
    const MatrixXd errors =
        2.0 * MatrixXd::Random(2, options.prediction_horizon);
    const VectorXd start = 0.5 * VectorXd::Random(3);
    const PlanSummary summary = planner->Plan(errors.reshaped(), zero, start);
    ASSERT_TRUE(summary.optimal);
    EXPECT_FALSE(summary.limits_widened);
    const MatrixXd plan = planner->planned_inputs();
    ASSERT_TRUE(feasible(plan, start, 1e-15));
    const double J = cost(plan, start, errors);
    // Any other feasible plan, and what lies on the way there.
    for (int n = 0; n < 50; ++n) {
      MatrixXd other(3, options.control_horizon);
      VectorXd before = start;
      for (int b = 0; b < options.control_horizon; ++b) {
        other.col(b) =
            (before + 0.4 * VectorXd::Random(3)).cwiseMax(-0.5).cwiseMin(0.6);
        before = other.col(b);
      }
      ASSERT_TRUE(feasible(other, start, 1e-15));
      for (const double way : {1e-4, 1e-2, 1.0}) {
        ASSERT_GE(cost(plan + way * (other - plan), start, errors), J);
      }
    }
  }
}

// One input and horizon 1: the optimum is the unconstrained one, cut.
TEST(MpcLimitsTest, OneMoveIsCut) {
  MpcOptions options;
  options.prediction_horizon = 5;
  options.control_horizon = 1;
  options.output_weight = options.move_weight = MatrixXd::Identity(1, 1);
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(1.0, 3.0, 0.0));
  Mpc free = MakeLimitedMpc(model, options);
  options.limits.max_move = VectorXd::Constant(1, 0.1);
  Mpc limited = MakeLimitedMpc(model, options);
  VectorXd u(1), v(1);
  free.Step(VectorXd::Zero(1), VectorXd::Constant(1, 3.0), u);
  limited.Step(VectorXd::Zero(1), VectorXd::Constant(1, 3.0), v);
  EXPECT_GT(u[0], 0.1);
  EXPECT_DOUBLE_EQ(v[0], 0.1);
}

// Inputs that stand outside come back as fast as their moves may, and the plan
// says so.
TEST(MpcLimitsTest, ComesBackIntoLimitsThatExcludeThePresentInput) {
  MpcOptions options;
  options.prediction_horizon = 10;
  options.control_horizon = 3;
  options.output_weight = options.move_weight = MatrixXd::Identity(1, 1);
  options.limits.min_input = VectorXd::Constant(1, 1.0);
  options.limits.max_input = VectorXd::Constant(1, 2.0);
  options.limits.max_move = VectorXd::Constant(1, 0.3);
  Mpc mpc = MakeLimitedMpc(
      SingleLoop(TransferFunction::FirstOrder(1.0, 3.0, 0.0)), options);
  VectorXd u(1);
  // It would rather go down.
  for (const double expected : {0.3, 0.6, 0.9, 1.0, 1.0}) {
    mpc.Step(VectorXd::Zero(1), VectorXd::Constant(1, -5.0), u);
    EXPECT_NEAR(u[0], expected, 1e-12);
    EXPECT_EQ(mpc.last_plan().limits_widened, expected < 0.95);
    EXPECT_TRUE(mpc.last_plan().optimal);
  }
}

// A set point beyond an output's limit: the output stops near the limit, the
// nearer the dearer.
TEST(MpcLimitsTest, SoftLimitsHoldOutputsTheBetterTheDearer) {
  double last = 3.0;
  for (const double cost : {0.1, 10.0, 1000.0}) {
    MpcOptions options;
    options.prediction_horizon = 20;
    options.control_horizon = 5;
    options.output_weight = MatrixXd::Identity(1, 1);
    options.move_weight = MatrixXd::Identity(1, 1) * 0.1;
    options.limits.max_output = VectorXd::Constant(1, 1.0);
    options.limits.output_limit_cost = VectorXd::Constant(1, cost);
    Mpc mpc = MakeLimitedMpc(
        SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 1.0)), options);
    VectorXd u(1), y = VectorXd::Zero(1);
    double violation = 0.0;
    for (int l = 0; l < 300; ++l) {
      mpc.Step(y, VectorXd::Constant(1, 3.0), u);
      y = mpc.PredictedOutputs();
      violation = mpc.last_plan().output_violation;
    }
    // At rest (r − y)² + c (y − 1)² is smallest at y = (r + c)/(1 + c).
    EXPECT_NEAR(y[0], (3.0 + cost) / (1.0 + cost), 1e-6);
    EXPECT_NEAR(violation, y[0] - 1.0, 1e-6);
    EXPECT_LT(y[0], last);
    last = y[0];
  }
}

TEST(MpcLimitsTest, BlocksOfOneAreThePapersHorizon) {
  MpcOptions blocks = LimitedOptions();
  blocks.control_horizon = 1;
  blocks.block_lengths = {1, 1, 1, 1};
  EXPECT_EQ(MakeLimitedMpc(MixedModel(), blocks).gain(),
            MakeLimitedMpc(MixedModel(), LimitedOptions()).gain());
}

// Blocks of 2 and 3: moves at instants 1 and 3 only. The best of those is the
// paper's problem with the moves between them made infinitely dear.
TEST(MpcLimitsTest, BlocksHoldTheInputs) {
  MpcOptions blocks = LimitedOptions();
  blocks.block_lengths = {2, 3};
  EXPECT_EQ(blocks.MoveInstants(), (std::vector<int>{1, 3}));
  MpcOptions limited = LimitedOptions();
  limited.control_horizon = 3;
  Mpc mpc = MakeLimitedMpc(MixedModel(), blocks);

  const auto model = PredictFromProcess(MixedModel(), 0.7);
  ASSERT_TRUE(model.ok());
  const int H_p = blocks.prediction_horizon;
  MatrixXd G = MatrixXd::Zero(2 * H_p, 6);
  MatrixXd Q = MatrixXd::Zero(2 * H_p, 2 * H_p);
  for (int i = 1; i <= H_p; ++i) {
    G.block(2 * (i - 1), 0, 2, 3) = model->responses.middleRows(2 * (i - 1), 2);
    if (i >= 3) {
      G.block(2 * (i - 1), 3, 2, 3) =
          model->responses.middleRows(2 * (i - 3), 2);
    }
    Q.block(2 * (i - 1), 2 * (i - 1), 2, 2) = blocks.output_weight;
  }
  MatrixXd H = G.transpose() * Q * G;
  H += MatrixXd::Identity(6, 6) * 0.05;
  const MatrixXd gain = H.inverse() * G.transpose() * Q;
  EXPECT_LE((mpc.gain() - gain.topRows(3)).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(MpcLimitsTest, PreviewOfASetPointThatStaysIsNoPreview) {
  Mpc one = MakeLimitedMpc(MixedModel(), LimitedOptions());
  Mpc other = MakeLimitedMpc(MixedModel(), LimitedOptions());
  VectorXd u(3), v(3);
  std::srand(8);
  for (int l = 0; l < 20; ++l) {
    const VectorXd y = VectorXd::Random(2), r = VectorXd::Random(2);
    one.Step(y, r, u);
    other.StepWithPreview(
        y, r.replicate(1, LimitedOptions().prediction_horizon), v);
    ASSERT_EQ(u, v);
  }
}

// A change that is known ahead costs less: with a dead time of 4 it is
// answered before it comes.
TEST(MpcLimitsTest, PreviewAnswersAChangeBeforeItComes) {
  MpcOptions options;
  options.prediction_horizon = 15;
  options.control_horizon = 5;
  options.output_weight = MatrixXd::Identity(1, 1);
  options.move_weight = MatrixXd::Identity(1, 1) * 0.1;
  const ProcessModel model =
      SingleLoop(TransferFunction::FirstOrder(1.0, 3.0, 4.0));
  double cost[2] = {0.0, 0.0};
  for (const bool preview : {false, true}) {
    Mpc mpc = MakeLimitedMpc(model, options);
    VectorXd u(1), y = VectorXd::Zero(1);
    const auto set_point = [](int l) { return l >= 20 ? 1.0 : 0.0; };
    for (int l = 0; l < 60; ++l) {
      if (preview) {
        MatrixXd ahead(1, 15);
        for (int i = 1; i <= 15; ++i) ahead(0, i - 1) = set_point(l + i);
        mpc.StepWithPreview(y, ahead, u);
      } else {
        mpc.Step(y, VectorXd::Constant(1, set_point(l)), u);
      }
      cost[preview] += std::pow(y[0] - set_point(l), 2);
      y = mpc.PredictedOutputs();
    }
  }
  EXPECT_LT(cost[1], 0.25 * cost[0]);
}

ProcessModel WithDisturbance() {
  ProcessModel model(
      "test", "min",
      {{.name = "d", .unit = "1", .role = InputRole::kDisturbance},
       {.name = "u", .unit = "1"}},
      {{.name = "y", .unit = "1"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 6.0, 5.0);
  model.element(0, 1) = TransferFunction::FirstOrder(1.0, 3.0, 1.0);
  return model;
}

// The disturbance comes later than the controller can act: fed forward it does
// next to nothing.
TEST(MpcLimitsTest, FeedsMeasuredDisturbancesForward) {
  MpcOptions options;
  options.prediction_horizon = 20;
  options.control_horizon = 8;
  options.output_weight = MatrixXd::Identity(1, 1);
  options.move_weight = MatrixXd::Identity(2, 2) * 1e-4;
  const Eigen::VectorXd response =
      WithDisturbance().element(0, 0).StepResponse(1.0, 200);
  double worst[2] = {0.0, 0.0};
  for (const bool measured : {false, true}) {
    Mpc mpc = MakeLimitedMpc(WithDisturbance(), options);
    // The plant's own part from the input is what the controller predicts
    // without a disturbance.
    Mpc shadow = MakeLimitedMpc(WithDisturbance(), options);
    std::vector<double> inputs = {0.0};
    const Eigen::VectorXd s =
        WithDisturbance().element(0, 1).StepResponse(1.0, 200);
    VectorXd u(2);
    for (int l = 0; l < 100; ++l) {
      VectorXd y = VectorXd::Zero(1);
      for (int k = 1; k < static_cast<int>(inputs.size()); ++k) {
        y[0] += s[l - k] * (inputs[k] - inputs[k - 1]);
      }
      if (l >= 10) y[0] += response[l - 10];
      if (measured) {
        mpc.MeasureDisturbances(VectorXd::Constant(1, l >= 10 ? 1.0 : 0.0));
      }
      mpc.Step(y, VectorXd::Zero(1), u);
      EXPECT_EQ(u[0], 0.0);
      inputs.push_back(u[1]);
      worst[measured] = std::max(worst[measured], std::abs(y[0]));
    }
  }
  EXPECT_GT(worst[0], 0.5);
  EXPECT_LT(worst[1], 0.02);
}

TEST(MpcLimitsTest, MissingMeasurementsLeaveThePredictionStanding) {
  MpcOptions options = LimitedOptions();
  options.limits = WideLimits(2, 3);
  Mpc mpc = MakeLimitedMpc(MixedModel(), options);
  const VectorXd r = VectorXd::Ones(2);
  const VectorXd missing = VectorXd::Constant(2, std::nan(""));
  VectorXd u(3);
  mpc.Step(VectorXd::Constant(2, 0.1), r, u);
  const VectorXd disturbance = mpc.observer().disturbance();
  for (int l = 0; l < 50; ++l) {
    mpc.Step(missing, missing, u);
    ASSERT_TRUE(u.allFinite());
  }
  EXPECT_EQ(mpc.observer().disturbance(), disturbance);
  EXPECT_LE((mpc.PredictedOutputs() - r).cwiseAbs().maxCoeff(), 1e-2);
}

TEST(MpcLimitsTest, LimitsAreChecked) {
  const auto error = [](auto change) {
    MpcOptions options = LimitedOptions();
    change(options);
    const auto mpc = Mpc::Create(MixedModel(), options);
    EXPECT_EQ(mpc.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(mpc.status().message());
  };
  EXPECT_THAT(
      error([](MpcOptions& o) { o.limits.min_input = VectorXd::Zero(2); }),
      HasSubstr("min_input has 2 values, but it must have 3"));
  EXPECT_THAT(error([](MpcOptions& o) {
                o.limits.min_input = VectorXd::Constant(3, 1.0);
                o.limits.max_input = VectorXd::Zero(3);
              }),
              HasSubstr("min_input[0] = 1 and max_input[0] = 0"));
  EXPECT_THAT(error([](MpcOptions& o) {
                o.limits.max_move = VectorXd::Constant(3, -1.0);
              }),
              HasSubstr("max_move[0] = -1"));
  EXPECT_THAT(
      error([](MpcOptions& o) { o.limits.max_output = VectorXd::Ones(2); }),
      HasSubstr("output_limit_cost[0] is 0"));
  EXPECT_THAT(error([](MpcOptions& o) {
                o.limits.max_move = VectorXd::Constant(3, std::nan(""));
              }),
              HasSubstr("max_move[0] = nan"));
  EXPECT_THAT(error([](MpcOptions& o) {
                o.block_lengths = {8, 8};
              }),
              HasSubstr("block_lengths are 16 together"));
  EXPECT_THAT(error([](MpcOptions& o) { o.block_lengths = {0}; }),
              HasSubstr("block_lengths has the value 0"));
}

}  // namespace
}  // namespace mle::control
