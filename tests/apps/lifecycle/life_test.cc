#include "apps/lifecycle/life.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using testing::Fouling;
using testing::NoisyTank;
using testing::QuietTank;
using testing::TankLife;
using testing::TankScenario;

bool Never() { return false; }

Policy Named(const std::string& name) { return ParsePolicies(name)->front(); }

Life LiveBy(const std::string& policy, const Scenario& scenario,
            const LifeOptions& options) {
  absl::StatusOr<Life> life =
      LiveThrough(scenario, Named(policy), options, Never);
  EXPECT_TRUE(life.ok()) << life.status();
  return *std::move(life);
}

int Count(const Life& life, Outcome outcome) {
  int count = 0;
  for (const ChangeRow& row : life.rows) count += row.outcome == outcome;
  return count;
}

TEST(LifeTest, WithoutAgeingNeverIsAsGoodAsPerfect) {
  const Scenario scenario = TankScenario(10, {});
  const LifeOptions options = TankLife(NoisyTank());
  const Life never = LiveBy("never", scenario, options);
  const Life perfect = LiveBy("perfect", scenario, options);
  ASSERT_EQ(never.rows.size(), scenario.events.size());
  for (std::size_t k = 0; k < never.rows.size(); ++k) {
    EXPECT_EQ(never.rows[k].error.distance, 0.0);
    EXPECT_EQ(never.rows[k].Total().squared_error,
              perfect.rows[k].Total().squared_error);
  }
}

TEST(LifeTest, WhatIsKnownOfAnAgedPlantIsWhatItsScheduleSays) {
  const Scenario scenario = TankScenario(10, Fouling(0.5, 20000.0));
  const Life life = LiveBy("never", scenario, TankLife(QuietTank()));
  for (const ChangeRow& row : life.rows) {
    const double factor = 1.0 - 0.5 * row.event.time / 20000.0;
    EXPECT_NEAR(row.error.gain, 1.0 / factor - 1.0, 1e-12);
    EXPECT_EQ(row.error.delay, 0.0);
  }
}

TEST(LifeTest, CorrectionsFollowAPlantThatAges) {
  const Scenario scenario = TankScenario(12, Fouling(0.4, 24000.0));
  const LifeOptions options = TankLife(NoisyTank());
  const Life never = LiveBy("never", scenario, options);
  for (const char* policy :
       {"output_error:1", "arx:4", "test:0.2", "on_demand:0.8"}) {
    const Life life = LiveBy(policy, scenario, options);
    EXPECT_GT(Count(life, Outcome::kUpdated), 0) << policy;
    // At the end, where a gain of 0.4 has been reached.
    EXPECT_LT(life.rows.back().error.gain, 0.3 * never.rows.back().error.gain)
        << policy;
  }
}

TEST(LifeTest, CorrectionsComeAsOftenAsThePolicySays) {
  const Scenario scenario = TankScenario(12, Fouling(0.4, 24000.0));
  const Life life = LiveBy("output_error:3", scenario, TankLife(NoisyTank()));
  for (std::size_t k = 0; k + 1 < life.rows.size(); ++k) {
    EXPECT_EQ(life.rows[k].outcome != Outcome::kNone, k % 3 == 2) << k;
    EXPECT_FALSE(life.rows[k].tested());
  }
}

TEST(LifeTest, StepTestsComeWhenTheyAreDue) {
  const Scenario scenario = TankScenario(14, {});
  LifeOptions options = TankLife(NoisyTank());
  options.month = 5000.0;
  const Life life = LiveBy("test:1", scenario, options);
  ASSERT_FALSE(life.rows.empty());
  double due = 5000.0;
  int tests = 0;
  for (const ChangeRow& row : life.rows) {
    if (row.event.output < 0) break;
    const double end = row.event.time + options.operation.after;
    EXPECT_EQ(row.tested(), end >= due) << row.event.time;
    if (row.tested()) {
      ++tests;
      EXPECT_EQ(row.test.time, 100.0);
      due = 5000.0 * (1.0 + std::floor(end / 5000.0));
    }
  }
  EXPECT_GE(tests, 1);
}

TEST(LifeTest, APerformanceIndexIsAboutOneWhileTheModelIsRight) {
  const Scenario scenario = TankScenario(10, {});
  // Without noise it is one but for rounding.
  const Life quiet = LiveBy("on_demand:0.9", scenario, TankLife(QuietTank()));
  ASSERT_FALSE(quiet.rows.empty());
  for (const ChangeRow& row : quiet.rows) {
    EXPECT_FALSE(row.tested());
    if (row.event.output >= 0) {
      EXPECT_NEAR(row.index, 1.0, 1e-6);
    }
  }
}

TEST(LifeTest, FewerWindowsOfOlderChangesAreUsed) {
  const Scenario scenario = TankScenario(12, Fouling(0.4, 24000.0));
  LifeOptions options = TankLife(NoisyTank());
  const Life all = LiveBy("output_error:1", scenario, options);
  options.windows = 1;
  const Life last = LiveBy("output_error:1", scenario, options);
  options.windows = 4;
  options.window_age = 500.0;  // the record of the last change alone
  const Life young = LiveBy("output_error:1", scenario, options);
  ASSERT_EQ(last.rows.size(), young.rows.size());
  for (std::size_t k = 0; k < last.rows.size(); ++k) {
    EXPECT_EQ(last.rows[k].error.distance, young.rows[k].error.distance);
  }
  EXPECT_NE(all.rows.back().error.distance, last.rows.back().error.distance);
}

TEST(LifeTest, AModelWithWhichTheLoopRunsWorseIsTakenBack) {
  // With a limit just above one a new model is often thought worse, by noise
  // alone; without a watch none is.
  const Scenario scenario = TankScenario(12, Fouling(0.4, 24000.0));
  LifeOptions options = TankLife(NoisyTank());
  options.watch_limit = 1.000001;
  const Life watched = LiveBy("output_error:1", scenario, options);
  ASSERT_GT(Count(watched, Outcome::kReverted), 0);
  for (std::size_t k = 0; k + 1 < watched.rows.size(); ++k) {
    const ChangeRow& row = watched.rows[k];
    const bool proposed =
        row.outcome == Outcome::kUpdated || row.outcome == Outcome::kReverted;
    EXPECT_EQ(row.watch.time, proposed ? 200.0 : 0.0);
    if (row.outcome == Outcome::kReverted) {
      // The plant ages on and the model stays: no nearer than before.
      EXPECT_GE(watched.rows[k + 1].error.gain, row.error.gain);
    }
  }
  options.watch_limit = std::numeric_limits<double>::infinity();
  const Life unwatched = LiveBy("output_error:1", scenario, options);
  EXPECT_EQ(Count(unwatched, Outcome::kReverted), 0);
}

TEST(LifeTest, AStopIsHeard) {
  const absl::StatusOr<Life> life =
      LiveThrough(TankScenario(3, {}), Named("never"), TankLife(QuietTank()),
                  [] { return true; });
  EXPECT_EQ(life.status().code(), absl::StatusCode::kCancelled);
}

// It is asked within corrections too, and then once more before the change is
// kept.
TEST(LifeTest, AStopIsHeardWithinACorrection) {
  const Scenario scenario = TankScenario(3, Fouling(0.5, 4000.0));
  const LifeOptions options = TankLife(NoisyTank());
  const auto asked = [&](const std::string& policy, int stop_at) {
    int times = 0;
    const absl::StatusOr<Life> life = LiveThrough(
        scenario, Named(policy), options, [&] { return ++times >= stop_at; });
    EXPECT_EQ(life.ok(), times < stop_at) << life.status();
    return times;
  };
  constexpr int kNever = 1'000'000;
  const int changes = asked("never", kNever);
  EXPECT_EQ(changes, static_cast<int>(scenario.events.size()));
  EXPECT_GT(asked("output_error:1", kNever), 2 * changes);
  EXPECT_EQ(asked("output_error:1", 1), 2);
}

TEST(LifeTest, ALoopThatRunsAwayEndsTheLifeAndSaysSo) {
  // Thirty times the gain, without limits: unstable.
  Scenario scenario = TankScenario(30, Fouling(30.0, 6e4));
  LifeOptions options = TankLife(NoisyTank());
  options.operation.quiet_stretch = 800.0;
  const Life life = LiveBy("never", scenario, options);
  EXPECT_LT(life.rows.size(), scenario.events.size());
  EXPECT_THAT(life.ended, ::testing::HasSubstr("the closed loop diverges"));
}

}  // namespace
}  // namespace mle::lifecycle
