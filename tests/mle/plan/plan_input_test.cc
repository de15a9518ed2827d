#include <cmath>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/plan/plan.h"
#include "tests/mle/plan/plan_cases.h"

namespace mle {
namespace {

using testing::HasSubstr;

std::string Refusal(const PlanProblem& problem, const PlanOptions& options) {
  const absl::StatusOr<Plan> plan = FindPlan(problem, options);
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kInvalidArgument)
      << plan.status();
  const std::string message(plan.status().message());
  EXPECT_THAT(message, testing::Not(HasSubstr("\n")));
  return message;
}

TEST(PlanInputTest, RefusesAHorizonOfZero) {
  EXPECT_EQ(Refusal(OneElement(), Longest(0.0)),
            "plan: longest is 0; it must be > 0 and finite");
}

TEST(PlanInputTest, RefusesLimitsThatUsualOperationDoesNotKeep) {
  PlanOptions options = Longest(300.0);
  options.max_output = Eigen::VectorXd::Constant(1, 74.0);
  EXPECT_EQ(Refusal(OneElement(), options),
            "plan: max_output of level is 74, which usual operation does not "
            "keep: it is at 70 with a standard deviation of 1; the limit must "
            "be above 75");
  options.max_output = {};
  options.min_input = Eigen::VectorXd::Constant(1, 31.0);
  EXPECT_THAT(Refusal(OneElement(), options),
              HasSubstr("min_input of valve is 31"));
}

TEST(PlanInputTest, RefusesAnOutputThatIsNotMeasured) {
  PlanProblem problem = OneElement();
  problem.noise[0].variance = 0.0;
  EXPECT_EQ(Refusal(problem, Longest(300.0)),
            "plan: level is not measured: its noise is not known");
  problem.noise[0].variance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Refusal(problem, Longest(300.0)), HasSubstr("not measured"));
}

TEST(PlanInputTest, RefusesQuestionsThatNoSetPointAnswers) {
  PlanProblem problem = TwoByTwo();
  problem.plant.element(0, 1) = TransferFunction();
  EXPECT_EQ(Refusal(problem, Longest(300.0)),
            "plan: top ← steam is zero in the model");
  problem = TwoByTwo();
  problem.questions[0].input = 2;
  EXPECT_THAT(Refusal(problem, Longest(300.0)),
              HasSubstr("output 0 and input 2"));
  problem.questions[0] = {.output = 0, .input = 1, .error = 0.0};
  EXPECT_EQ(Refusal(problem, Longest(300.0)),
            "plan: error is 0; it must be in (0, 1]");
}

TEST(PlanInputTest, RefusesOptionsThatDoNotFit) {
  const PlanProblem problem = TwoByTwo();
  PlanOptions options = Longest(300.0);
  options.max_output = Eigen::VectorXd::Constant(3, 100.0);
  EXPECT_EQ(Refusal(problem, options),
            "plan: max_output has 3 values; it must have 2");
  options = Longest(300.0);
  options.movable = {false, false};
  EXPECT_THAT(Refusal(problem, options), HasSubstr("no set point is movable"));
  options = Longest(300.0);
  options.shortest_hold = 301.0;
  EXPECT_THAT(Refusal(problem, options), HasSubstr("shortest_hold is 301"));
  options = Longest(300.0);
  options.squared_price = Eigen::Vector2d(-1.0, 0.0);
  EXPECT_THAT(Refusal(problem, options), HasSubstr("squared_price is -1"));
}

TEST(PlanInputTest, RefusesLevels) {
  PlanProblem problem = OneElement();
  problem.plant.element(0, 0) = TransferFunction::Integrator(0.1, 2.0, 1.0);
  EXPECT_THAT(Refusal(problem, Longest(300.0)), HasSubstr("level ← valve"));
}

TEST(PlanInputTest, HandsOnWhatTheLoopSays) {
  PlanProblem problem = OneElement();
  problem.loop = [](const ProcessModel&,
                    const Eigen::MatrixXd&) -> absl::StatusOr<Record> {
    return absl::FailedPreconditionError("the loop is not stable");
  };
  EXPECT_EQ(FindPlan(problem, Longest(300.0)).status().message(),
            "the loop is not stable");
}

}  // namespace
}  // namespace mle
