// What is planned or read before anything is simulated: set-point changes, step
// tests, policies, lengths of time.

#include <cmath>
#include <set>

#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/scenario.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using ::testing::HasSubstr;

SetPointOptions TwoOutputs() {
  SetPointOptions options;
  options.duration = 5e5;
  options.change_every = 1000.0;
  options.grid = 5.0;
  options.range = Eigen::Vector2d(1.0, 20.0);
  return options;
}

TEST(SetPointEventsTest, KeepWhatTheirOptionsPromise) {
  const SetPointOptions options = TwoOutputs();
  const std::vector<SetPointEvent> events = DrawSetPointEvents(options, 3);
  ASSERT_GT(events.size(), 300u);
  double last = 0.0;
  Eigen::VectorXd set_points = Eigen::Vector2d::Zero();
  std::set<int> outputs;
  for (const SetPointEvent& event : events) {
    const bool end = &event == &events.back();
    EXPECT_EQ(event.output < 0, end);
    EXPECT_EQ(event.before, set_points);
    EXPECT_EQ(std::fmod(event.time, options.grid), 0.0);
    EXPECT_GE(event.time - last, 500.0 - options.grid);
    if (!end) {
      EXPECT_LE(event.time - last, 1500.0 + options.grid);
      const double range = options.range[event.output];
      EXPECT_LE(std::abs(event.after[event.output]), range);
      EXPECT_GE(
          std::abs(event.after[event.output] - event.before[event.output]),
          0.5 * range);
      outputs.insert(event.output);
    }
    last = event.time;
    set_points = event.after;
  }
  EXPECT_EQ(last, options.duration);
  EXPECT_EQ(outputs.size(), 2u);
  // 500 changes are expected; their number has a deviation of 500 √(1/12/500).
  EXPECT_NEAR(static_cast<double>(events.size()), 500.0, 30.0);
}

TEST(SetPointEventsTest, DependOnTheSeedAlone) {
  const std::vector<SetPointEvent> a = DrawSetPointEvents(TwoOutputs(), 3);
  const std::vector<SetPointEvent> b = DrawSetPointEvents(TwoOutputs(), 3);
  const std::vector<SetPointEvent> c = DrawSetPointEvents(TwoOutputs(), 4);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].time, b[i].time);
  EXPECT_NE(a[0].time, c[0].time);
}

TEST(SetPointOptionsTest, MistakesAreNamed) {
  SetPointOptions options = TwoOutputs();
  options.change_every = 1e6;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("there would be no change"));
  options.change_every = -1.0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("change_every = -1"));
  options = TwoOutputs();
  options.range[1] = 0.0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("range = 0"));
}

TEST(StepTestTest, NoOutputIsExpectedToMoveFartherThanAllowed) {
  ProcessModel model("m", "min", {{"a", ""}, {"b", ""}, {"idle", ""}},
                     {{"y", ""}, {"z", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(4.0, 5.0, 1.0);
  model.element(1, 0) = TransferFunction::FirstOrder(-50.0, 5.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(0.5, 5.0, 1.0);
  const StepTestPlan plan =
      PlanStepTest(model, {.hold = 30.0, .move = Eigen::Vector2d(1.0, 10.0)});
  ASSERT_EQ(plan.inputs, (std::vector<int>{0, 1}));  // "idle" reaches nothing
  EXPECT_DOUBLE_EQ(plan.steps[0], 0.2);              // 50 · 0.2 = 10
  EXPECT_DOUBLE_EQ(plan.steps[1], 2.0);              // 0.5 · 2 = 1
  EXPECT_EQ(plan.duration(), 120.0);
  EXPECT_EQ(plan.InputsAt(0.0, 3), Eigen::Vector3d(0.2, 0.0, 0.0));
  EXPECT_EQ(plan.InputsAt(29.9, 3), Eigen::Vector3d(0.2, 0.0, 0.0));
  EXPECT_EQ(plan.InputsAt(30.0, 3), Eigen::Vector3d::Zero());
  EXPECT_EQ(plan.InputsAt(60.0, 3), Eigen::Vector3d(0.0, 2.0, 0.0));
  EXPECT_EQ(plan.InputsAt(90.0, 3), Eigen::Vector3d::Zero());
  EXPECT_EQ(plan.InputsAt(500.0, 3), Eigen::Vector3d::Zero());
}

TEST(StepTestTest, CyclesRepeatEachInput) {
  StepTestPlan plan = PlanStepTest(
      testing::Tank(),
      {.hold = 10.0, .cycles = 3, .move = Eigen::VectorXd::Ones(1)});
  EXPECT_EQ(plan.duration(), 60.0);
  for (const double begin : {0.0, 20.0, 40.0}) {
    EXPECT_EQ(plan.InputsAt(begin, 1)[0], 0.5);
    EXPECT_EQ(plan.InputsAt(begin + 10.0, 1)[0], 0.0);
  }
  EXPECT_EQ(plan.InputsAt(60.0, 1)[0], 0.0);
}

TEST(PolicyTest, ListsAreRead) {
  const absl::StatusOr<std::vector<Policy>> policies = ParsePolicies(
      "never, output_error:3,output_error,arx:2,test:6,on_demand:0.5,"
      "perfect");
  ASSERT_TRUE(policies.ok()) << policies.status();
  ASSERT_EQ(policies->size(), 7u);
  EXPECT_EQ((*policies)[1].every, 3);
  EXPECT_EQ((*policies)[1].estimator, Estimator::kOutputError);
  EXPECT_EQ((*policies)[2].name, "output_error:1");
  EXPECT_EQ((*policies)[3].family(), "arx");
  EXPECT_EQ((*policies)[4].months, 6.0);
  EXPECT_TRUE((*policies)[5].tests());
  EXPECT_EQ((*policies)[6].kind, Policy::Kind::kPerfect);
}

TEST(PolicyTest, MistakesAreNamed) {
  const auto message = [](const char* text) {
    return std::string(ParsePolicies(text).status().message());
  };
  EXPECT_THAT(message("never,yearly"),
              HasSubstr("'yearly': choose from never"));
  EXPECT_THAT(message("output_error:0"), HasSubstr("'output_error:0'"));
  EXPECT_THAT(message("output_error:1.5"), HasSubstr("whole number"));
  EXPECT_THAT(message("output_error,output_error:1"),
              HasSubstr("is duplicated"));
  EXPECT_THAT(message("test"), HasSubstr("test:12"));
  EXPECT_THAT(message("test:x"), HasSubstr("'x' is not a number"));
  EXPECT_THAT(message("on_demand:1.2"), HasSubstr("between 0 and 1"));
  EXPECT_THAT(message("never:2"), HasSubstr("takes no number"));
  EXPECT_THAT(message(""), HasSubstr("names no policy"));
}

TEST(DurationTest, UnitsAreRead) {
  EXPECT_EQ(*ParseHours("30d"), 720.0);
  EXPECT_EQ(*ParseHours("90min"), 1.5);
  EXPECT_EQ(*ParseHours("7200s"), 2.0);
  EXPECT_EQ(*ParseHours("2w"), 336.0);
  EXPECT_EQ(*ParseHours("0.5y"), 4383.0);
  EXPECT_EQ(*ParseHours("1e2h"), 100.0);
  for (const char* wrong :
       {"", "30", "d", "-1d", "0d", "nand", "3 d", "1mon"}) {
    EXPECT_FALSE(ParseHours(wrong).ok()) << wrong;
  }
}

}  // namespace
}  // namespace mle::lifecycle
