#include "sim/actuator.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using ::testing::HasSubstr;

// A random walk with pauses.
std::vector<double> Commands() {
  std::mt19937_64 engine = SeededEngine(5, 0, 0);
  std::vector<double> commands(3000, 0.0);
  for (std::size_t k = 1; k < commands.size(); ++k) {
    const double move = 0.4 * (DrawUniform(engine) - 0.5);
    commands[k] = commands[k - 1] + (DrawUniform(engine) < 0.2 ? 0.0 : move);
  }
  return commands;
}

TEST(ActuatorTest, WithoutFrictionTheInputActs) {
  Actuator actuator({});
  for (const double command : Commands()) {
    EXPECT_EQ(actuator.Move(command), command);
  }
}

// The play operator: the stem is dragged by the ends of a gap of width S.
TEST(ActuatorTest, WithoutAJumpItIsBacklash) {
  Actuator actuator({.stiction = 0.5});
  double stem = 0.0;
  for (const double command : Commands()) {
    stem = std::clamp(stem, command - 0.25, command + 0.25);
    ASSERT_NEAR(actuator.Move(command), stem, 1e-12);
  }
}

// Kano's flow chart: u_S is the input where the valve stopped, d the direction
// in which it moved. It moves on after more than J, back after more than S.
TEST(ActuatorTest, ItSticksAsInKanosModel) {
  for (const double jump : {0.1, 0.3, 0.5, 0.7}) {
    const double stiction = 0.5;
    Actuator actuator({.stiction = stiction, .slip_jump = jump});
    const std::vector<double> commands = Commands();
    double direction = 1.0;
    double stopped = direction * (stiction - jump) / 2.0;  // at rest at 0
    double stem = 0.0;
    bool stuck = true;
    double before = 0.0;
    double change_before = 0.0;
    for (const double command : commands) {
      const double change = command - before;
      if (!stuck && change * change_before <= 0.0) {
        stuck = true;
        stopped = before;
      }
      if (stuck && -direction * (command - stopped) > stiction) {
        direction = -direction;
        stuck = false;
      } else if (stuck && direction * (command - stopped) > jump) {
        stuck = false;
      }
      if (!stuck) stem = command - direction * (stiction - jump) / 2.0;
      change_before = change;
      before = command;
      ASSERT_NEAR(actuator.Move(command), stem, 1e-12) << jump;
    }
  }
}

TEST(ActuatorTest, ItSlipsByTheJump) {
  Actuator actuator({.stiction = 0.4, .slip_jump = 0.2});
  EXPECT_EQ(actuator.Move(0.3), 0.0);  // f_S = 0.3
  EXPECT_NEAR(actuator.Move(0.301), 0.201, 1e-12);
  EXPECT_NEAR(actuator.Move(0.5), 0.4, 1e-12);   // it moves: f_D = 0.1
  EXPECT_NEAR(actuator.Move(0.5), 0.4, 1e-12);   // it stops
  EXPECT_NEAR(actuator.Move(0.65), 0.4, 1e-12);  // and sticks
  EXPECT_NEAR(actuator.Move(0.2), 0.4, 1e-12);
  EXPECT_NEAR(actuator.Move(0.09), 0.19, 1e-12);
}

TEST(ActuatorTest, EqualStepsOfTheStemAreEqualPercentagesOfTheFlow) {
  const double span = 4.0;
  const double rangeability = 50.0;
  const auto flow = [&](double stem) {
    Actuator actuator(
        {.rangeability = rangeability, .span = span, .position = 0.5});
    return actuator.Move(stem) + span / std::log(rangeability);
  };
  for (const double stem : {-1.5, -0.3, 0.9}) {
    EXPECT_NEAR(flow(stem + 0.5) / flow(stem),
                std::pow(rangeability, 0.5 / span), 1e-12);
  }
  EXPECT_NEAR((flow(1e-6) - flow(-1e-6)) / 2e-6, 1.0, 1e-6);
  EXPECT_NEAR(flow(2.0) / flow(-2.0), rangeability, 1e-10);
  EXPECT_EQ(flow(9.0), flow(2.0));
  EXPECT_EQ(flow(-9.0), flow(-2.0));
}

TEST(ActuatorTest, BeyondTheKinkTheSlopeIsAnother) {
  Actuator actuator({.kink = 0.5, .kink_slope = 3.0});
  EXPECT_EQ(actuator.Move(-2.0), -2.0);
  EXPECT_EQ(actuator.Move(0.5), 0.5);
  EXPECT_NEAR(actuator.Move(0.7) - actuator.Move(0.6), 0.3, 1e-12);
  // Of a bent characteristic too, whose slope before the kink is its own.
  Actuator bent({.rangeability = 30.0, .span = 4.0, .kink = 0.5});
  Actuator kinked(
      {.rangeability = 30.0, .span = 4.0, .kink = 0.5, .kink_slope = 3.0});
  EXPECT_EQ(kinked.Move(0.4), bent.Move(0.4));
  EXPECT_NEAR(kinked.Move(0.9) - kinked.Move(0.8),
              3.0 * (bent.Move(0.9) - bent.Move(0.8)), 1e-12);
}

TEST(ActuatorTest, TheStemStaysBetweenItsEndsAndLeavesThemAtOnce) {
  Actuator actuator({.min = -0.2, .max = 0.7});
  for (const double command : Commands()) {
    EXPECT_EQ(actuator.Move(command), std::clamp(command, -0.2, 0.7));
  }
}

TEST(ActuatorTest, ItFollowsByNoMoreThanItsRate) {
  const double rate = 0.3;
  const double sample_time = 0.2;
  Actuator actuator({.rate = rate});
  Actuator free({});
  double before = 0.0;
  for (const double command : Commands()) {
    actuator.Move(command);
    free.Move(command);
    EXPECT_EQ(free.Act(sample_time), command);
    for (int k = 0; k < 2; ++k) {
      const double acting = actuator.Act(sample_time);
      const double move = acting - before;
      ASSERT_LE(std::abs(move), rate * sample_time + 1e-12);
      // It is there, or under way at the full rate.
      if (acting != command) {
        ASSERT_NEAR(move, std::copysign(rate * sample_time, command - before),
                    1e-12);
      }
      before = acting;
    }
  }
}

TEST(ActuatorTest, OptionsAreChecked) {
  ProcessModel model(
      "d", "min", {{"u", ""}, {"d", "", InputRole::kDisturbance}}, {{"y", ""}});
  const auto message = [&](const ActuatorOptions& options) {
    return std::string(options.Validate(model).message());
  };
  EXPECT_TRUE(ActuatorOptions{}.Validate(model).ok());
  EXPECT_THAT(message({.input = 2}), HasSubstr("input = 2"));
  EXPECT_THAT(message({.input = 1}), HasSubstr("'d'"));
  EXPECT_THAT(message({.stiction = -1.0}), HasSubstr("stiction = -1"));
  EXPECT_THAT(message({.slip_jump = NAN}), HasSubstr("jump = nan"));
  EXPECT_THAT(message({.rangeability = 0.5}), HasSubstr("rangeability = 0.5"));
  EXPECT_THAT(message({.span = 0.0}), HasSubstr("span = 0"));
  EXPECT_THAT(message({.position = 1.5}), HasSubstr("position = 1.5"));
  EXPECT_THAT(message({.kink = -1.0}), HasSubstr("kink = -1"));
  EXPECT_THAT(message({.kink_slope = NAN}), HasSubstr("kink_slope = nan"));
  EXPECT_THAT(message({.min = 0.5}), HasSubstr("min = 0.5"));
  EXPECT_THAT(message({.max = NAN}), HasSubstr("max = nan"));
  EXPECT_THAT(message({.rate = 0.0}), HasSubstr("rate = 0"));
}

}  // namespace
}  // namespace mle::sim
