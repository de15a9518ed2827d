#include "sim/delayed_inputs.h"

#include <cmath>
#include <functional>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::sim {
namespace {

using ::testing::HasSubstr;

constexpr double kInputSampleTime = 0.5;

DelayedInputs MakeDelayed(const Schedule& delay) {
  absl::StatusOr<DelayedInputs> inputs =
      DelayedInputs::Create(1, {{0, delay}}, kInputSampleTime);
  EXPECT_TRUE(inputs.ok()) << inputs.status();
  return *std::move(inputs);
}

Schedule DelayAt(std::vector<Schedule::Point> points) {
  return *Schedule::Create(std::move(points));
}

// w(t), t = 0 … samples · Δt, under u_k = k + 1 (so that 0 is the time before
// the record). `visit(from, to, w)` for every piece.
void ForEachPiece(
    const Schedule& delay, int samples,
    const std::function<void(double from, double to, double w)>& visit) {
  DelayedInputs inputs = MakeDelayed(delay);
  for (int k = 0; k < samples; ++k) {
    const double time = k * kInputSampleTime;
    inputs.Hold(time, Eigen::VectorXd::Constant(1, k + 1.0));
    const auto& events = inputs.events();
    ASSERT_FALSE(events.empty());
    ASSERT_EQ(events[0].at, 0.0);
    for (std::size_t e = 0; e < events.size(); ++e) {
      const double end = e + 1 < events.size() ? events[e + 1].at : 1.0;
      visit(time + events[e].at * kInputSampleTime,
            time + end * kInputSampleTime, inputs.Value(events[e]));
    }
  }
}

// In the middle of every piece the input is the one that t − L(t) asks for.
void ExpectDelayedBy(const Schedule& delay) {
  ForEachPiece(delay, 200, [&](double from, double to, double w) {
    if (to - from < 1e-6) return;
    for (const double part : {1e-6, 0.5, 1.0 - 1e-6}) {
      const double t = from + part * (to - from);
      const double sent = (t - delay.At(t)) / kInputSampleTime;
      EXPECT_EQ(w, std::max(0.0, std::floor(sent) + 1.0)) << "at " << t;
    }
  });
}

TEST(DelayedInputsTest, ConstantDeadTimesOnAndOffTheGrid) {
  for (const double delay : {0.0, 0.5, 3.0, 0.2, 0.49, 7.77}) {
    ExpectDelayedBy(Schedule(delay));
  }
}

TEST(DelayedInputsTest, DeadTimesThatGrowShrinkAndJump) {
  ExpectDelayedBy(DelayAt({{3.1, 1.3}, {60.0, 9.0}}));
  ExpectDelayedBy(DelayAt({{0.0, 20.0}, {40.05, 0.1}}));
  ExpectDelayedBy(DelayAt({{0.0, 2.0}, {17.3, 2.0}, {17.3, 6.2}}));
  ExpectDelayedBy(DelayAt({{0.0, 2.0}, {17.3, 2.0}, {17.3, 0.3}}));
  ExpectDelayedBy(DelayAt(
      {{0.0, 2.0}, {10.1, 4.0}, {10.2, 4.0}, {10.3, 3.0}, {30.0, 12.0}}));
}

// While L grows at the rate β every sample is seen for Δt / (1 − β): longer,
// and none is lost; while it shrinks, for a shorter time.
TEST(DelayedInputsTest, ChangingDeadTimeStretchesTheInput) {
  for (const double rate : {0.25, -0.5}) {
    const double start = rate > 0.0 ? 1.0 : 40.0;
    Eigen::VectorXd seen = Eigen::VectorXd::Zero(101);
    ForEachPiece(DelayAt({{0.0, start}, {50.0, start + 50.0 * rate}}), 100,
                 [&](double from, double to, double w) {
                   seen[static_cast<int>(w)] += to - from;
                 });
    for (int k = 2; k < 10; ++k) {
      EXPECT_NEAR(seen[k], kInputSampleTime / (1.0 - rate), 1e-12)
          << "rate " << rate << ", sample " << k;
    }
  }
}

TEST(DelayedInputsTest, PathsAreChecked) {
  const auto message = [](const InputPath& path) {
    return std::string(
        DelayedInputs::Create(2, {path}, kInputSampleTime).status().message());
  };
  EXPECT_THAT(message({2, Schedule(0.0)}), HasSubstr("input = 2"));
  EXPECT_THAT(message({0, Schedule(-1.0)}), HasSubstr("must not be negative"));
  EXPECT_THAT(message({0, Schedule(1e9)}), HasSubstr("longer sample time"));
  EXPECT_THAT(message({0, DelayAt({{0.0, 0.0}, {1.0, 1.0}})}),
              HasSubstr("slower than time itself"));
}

}  // namespace
}  // namespace mle::sim
