#include "mle/plan/plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "Eigen/Cholesky"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/plan/plan_cases.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Plan PlanFor(const PlanProblem& problem, const PlanOptions& options) {
  const absl::StatusOr<Plan> plan = FindPlan(problem, options);
  EXPECT_TRUE(plan.ok()) << plan.status();
  return plan.ok() ? *plan : Plan();
}

// The standard error of the gain of a first-order element from one record under
// white noise of variance 1, with time constant, dead time and an offset free:
// by differences of the response.
double ErrorByDifferences(const Plan& plan) {
  const MatrixXd inputs = plan.expected.inputs.array() -
                          plan.expected.inputs(0, plan.expected.samples() - 1);
  constexpr int kBefore = 58;  // samples, a settling time
  MatrixXd all = MatrixXd::Zero(1, kBefore + inputs.cols());
  all.rightCols(inputs.cols()) = inputs;
  const auto response = [&](double gain, double lag, double delay) {
    ProcessModel model("one", "min", {{"valve", ""}}, {{"level", ""}});
    model.element(0, 0) = TransferFunction::FirstOrder(gain, lag, delay);
    return VectorXd(SimulateResponse(model, 1.0, all)->row(0).transpose());
  };
  constexpr double kStep = 1e-4;
  MatrixXd columns(all.cols(), 4);
  columns.col(0) =
      (response(2.0 + kStep, 10.0, 3.0) - response(2.0 - kStep, 10.0, 3.0)) /
      (2.0 * kStep);
  columns.col(1) =
      (response(2.0, 10.0 + kStep, 3.0) - response(2.0, 10.0 - kStep, 3.0)) /
      (2.0 * kStep);
  columns.col(2) =
      (response(2.0, 10.0, 3.0 + kStep) - response(2.0, 10.0, 3.0 - kStep)) /
      (2.0 * kStep);
  columns.col(3).setOnes();
  const MatrixXd information = columns.transpose() * columns;
  return std::sqrt(information.ldlt().solve(VectorXd::Unit(4, 0))(0)) / 2.0;
}

TEST(PlanTest, BringsTheErrorWantedAndNoMore) {
  for (const double wanted : {0.02, 0.05, 0.1}) {
    PlanProblem problem = OneElement();
    problem.questions[0].error = wanted;
    PlanOptions options = Longest(300.0);
    options.ageing = 1e-4;  // one plant
    const Plan plan = PlanFor(problem, options);
    ASSERT_EQ(plan.state, Plan::State::kFound);
    ASSERT_EQ(plan.answers.size(), 1U);
    // Sizes are rounded up to three digits, by 1 % at most.
    EXPECT_LE(plan.answers[0].after, 1.01 * wanted);
    EXPECT_GE(plan.answers[0].after, 0.98 * wanted);
    // No plan is cheaper than one that tells of nothing but the gain K: its
    // error is then 1/√Σ y², and Σ y² the cost.
    const double least = 1.0 / (plan.answers[0].after * plan.answers[0].after);
    EXPECT_GE(plan.cost, 0.999 * least);
    EXPECT_LE(plan.cost, 1.3 * least);
    // The bound has a window whose first samples are not used, and the state
    // at its start free: some per cent.
    EXPECT_NEAR(ErrorByDifferences(plan), plan.answers[0].after, 0.06 * wanted);
    EXPECT_TRUE(std::isinf(plan.answers[0].before));
    EXPECT_EQ(plan.steps.back().set_points, problem.set_points);
    EXPECT_LE(plan.duration, 300.0);
  }
}

TEST(PlanTest, LessCertaintyNeverCostsMore) {
  double cost = 0.0;
  for (const double wanted : {0.3, 0.2, 0.1, 0.05, 0.025}) {
    PlanProblem problem = TwoByTwo();
    problem.questions[0].error = wanted;
    const Plan plan = PlanFor(problem, Longest(400.0));
    ASSERT_EQ(plan.state, Plan::State::kFound);
    EXPECT_GT(plan.cost, cost);
    cost = plan.cost;
  }
}

TEST(PlanTest, OneGainOfTwoCostsLessThanBoth) {
  PlanProblem problem = TwoByTwo();
  const Plan one = PlanFor(problem, Longest(400.0));
  problem.questions.push_back({.output = 0, .input = 0, .error = 0.02});
  const Plan both = PlanFor(problem, Longest(400.0));
  // Both searches stop near an optimum: by 10 %.
  EXPECT_LT(one.cost, 1.1 * both.cost);
  ASSERT_EQ(both.answers.size(), 2U);
  for (const PlanAnswer& answer : both.answers) {
    EXPECT_LE(answer.after, 1.01 * answer.question.error);
  }
}

TEST(PlanTest, KeepsLimitsInTheWholeBand) {
  PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(600.0);
  options.max_output = Eigen::Vector2d(85.0, 82.0);
  options.min_output = Eigen::Vector2d(60.0, 50.0);
  options.max_input = Eigen::Vector2d(34.0, 33.0);
  options.min_input = Eigen::Vector2d(27.0, 26.0);
  const Plan plan = PlanFor(problem, options);
  ASSERT_EQ(plan.state, Plan::State::kFound);
  EXPECT_EQ(plan.left_out, 0);
  for (int c = 0; c < 2; ++c) {
    EXPECT_LE(plan.high_outputs.row(c).maxCoeff(),
              options.max_output(c) + 1e-9);
    EXPECT_GE(plan.low_outputs.row(c).minCoeff(), options.min_output(c) - 1e-9);
    EXPECT_LE(plan.high_inputs.row(c).maxCoeff(), options.max_input(c) + 1e-9);
    EXPECT_GE(plan.low_inputs.row(c).minCoeff(), options.min_input(c) - 1e-9);
    EXPECT_TRUE((plan.high_outputs.row(c).array() >=
                 plan.expected.outputs.row(c).array())
                    .all());
  }
  // Without limits moves are larger, and the cost not: it is that of squares.
  const Plan free = PlanFor(problem, Longest(600.0));
  EXPECT_LE(free.cost, 1.05 * plan.cost);
}

TEST(PlanTest, SaysWhatHinders) {
  PlanProblem problem = OneElement();
  problem.questions[0].error = 0.005;
  PlanOptions options = Longest(100.0);
  options.max_output = Eigen::VectorXd::Constant(1, 76.0);
  options.min_output = Eigen::VectorXd::Constant(1, 64.0);
  const Plan plan = PlanFor(problem, options);
  EXPECT_EQ(plan.state, Plan::State::kOutOfReach);
  EXPECT_THAT(plan.hindrance, testing::HasSubstr("limit of level"));
  EXPECT_GT(plan.answers[0].after, 0.005);
  EXPECT_LE(plan.high_outputs.maxCoeff(), 76.0 + 1e-9);
  EXPECT_GE(plan.low_outputs.minCoeff(), 64.0 - 1e-9);
}

TEST(PlanTest, NothingIsNeededWhereAllIsKnown) {
  PlanProblem problem = OneElement();
  problem.questions[0].error = 0.02;
  const Plan first = PlanFor(problem, Longest(300.0));
  ASSERT_EQ(first.state, Plan::State::kFound);
  Record window = first.expected;
  problem.windows = {window, window};
  problem.questions[0].error = 0.1;
  const Plan plan = PlanFor(problem, Longest(300.0));
  EXPECT_EQ(plan.state, Plan::State::kNothingNeeded);
  EXPECT_TRUE(plan.steps.empty());
  EXPECT_LE(plan.answers[0].before, 0.1);
  // What is in doubt does not count.
  problem.questions[0].alone = true;
  EXPECT_EQ(PlanFor(problem, Longest(300.0)).state, Plan::State::kFound);
}

TEST(PlanTest, RecordsMakeAPlanCheaper) {
  PlanProblem problem = TwoByTwo();
  const Plan alone = PlanFor(problem, Longest(400.0));
  problem.questions[0].error = 0.08;
  const Plan weaker = PlanFor(problem, Longest(400.0));
  ASSERT_EQ(weaker.state, Plan::State::kFound);
  problem.questions[0].error = 0.05;
  problem.windows = {weaker.expected};
  const Plan with = PlanFor(problem, Longest(400.0));
  ASSERT_EQ(with.state, Plan::State::kFound);
  EXPECT_LT(with.cost, 0.9 * alone.cost);
}

TEST(PlanTest, CostsAreThoseOfThePrices) {
  PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(400.0);
  options.squared_price = Eigen::Vector2d(3.0, 0.5);
  options.absolute_price = Eigen::Vector2d(0.0, 0.0);
  const Plan squared = PlanFor(problem, options);
  const auto deviations = [&](const Plan& plan) {
    return MatrixXd(plan.expected.outputs.colwise() - problem.set_points);
  };
  const VectorXd squares = deviations(squared).rowwise().squaredNorm();
  // Its grid is not finer than a sample here: the sum is the integral.
  EXPECT_NEAR(squared.cost, 3.0 * squares(0) + 0.5 * squares(1),
              1e-9 * squared.cost);
  options.squared_price = Eigen::Vector2d(0.0, 0.0);
  options.absolute_price = Eigen::Vector2d(2.0, 0.0);
  const Plan absolute = PlanFor(problem, options);
  const VectorXd sums = deviations(absolute).cwiseAbs().rowwise().sum();
  // Beside noise deviations cost less than by themselves.
  EXPECT_LT(absolute.cost, 2.0 * sums(0));
  EXPECT_GT(absolute.cost, 0.0);
}

TEST(PlanTest, ShapesAndUnitsOfPricesDoNotMatter) {
  PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(400.0);
  options.squared_price = Eigen::Vector2d(1.0, 1.0);
  const Plan plan = PlanFor(problem, options);
  options.squared_price *= 1000.0;
  const Plan dear = PlanFor(problem, options);
  EXPECT_NEAR(dear.cost, 1000.0 * plan.cost, 1e-6 * dear.cost);
  ASSERT_EQ(dear.steps.size(), plan.steps.size());
  for (std::size_t s = 0; s < plan.steps.size(); ++s) {
    EXPECT_EQ(dear.steps[s].time, plan.steps[s].time);
    EXPECT_EQ(dear.steps[s].set_points, plan.steps[s].set_points);
  }
}

TEST(PlanTest, StaysWhereItMayNotMoveAndKeepsQuietTime) {
  PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(400.0);
  options.movable = {true, false};
  options.shortest_hold = 40.0;
  const Plan plan = PlanFor(problem, options);
  // Both inputs move together, which hardly tells their gains apart.
  ASSERT_GE(plan.steps.size(), 2U);
  for (std::size_t s = 0; s + 1 < plan.steps.size(); ++s) {
    EXPECT_EQ(plan.steps[s].set_points(1), problem.set_points(1));
    EXPECT_GE(plan.steps[s + 1].time - plan.steps[s].time, 40.0);
  }
}

TEST(PlanTest, IsTheSameWithAnyNumberOfThreads) {
  const PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(400.0);
  const Plan one = PlanFor(problem, options);
  options.threads = 3;
  const Plan three = PlanFor(problem, options);
  EXPECT_EQ(one.cost, three.cost);
  EXPECT_EQ(one.high_outputs, three.high_outputs);
  EXPECT_EQ(one.low_inputs, three.low_inputs);
}

TEST(PlanTest, DrawsPlantsAsAgeingIsExpected) {
  PlanProblem problem = OneElement();
  PlanOptions options = Longest(300.0);
  options.draws = 4000;
  const absl::StatusOr<std::vector<ProcessModel>> plants =
      DrawPlants(problem, options);
  ASSERT_TRUE(plants.ok()) << plants.status();
  double sum = 0.0;
  double squares = 0.0;
  for (const ProcessModel& plant : *plants) {
    const double change = std::log(plant.element(0, 0).StaticGain() / 2.0);
    sum += change;
    squares += change * change;
  }
  const auto count = static_cast<double>(plants->size());
  // Four standard errors.
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 0.25 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.25,
              4.0 * 0.25 / std::sqrt(2.0 * count));
}

}  // namespace
}  // namespace mle
