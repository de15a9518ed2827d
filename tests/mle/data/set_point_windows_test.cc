#include "mle/data/set_point_windows.h"

#include <random>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Verdict = SteadyOperation::Verdict;

// Settles in 2 + 5·10 = 52.
ProcessModel WindowModel() {
  ProcessModel model("tank", "min", {{"u1", ""}, {"u2", ""}},
                     {{"y1", ""}, {"y2", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 10.0, 2.0);
  model.element(1, 1) = TransferFunction::FirstOrder(2.0, 3.0, 5.0);
  return model;
}

// Noise about 7 and 8; inputs at 20 and 30; set points change where given.
Record Noise(int samples, unsigned seed,
             const std::vector<SetPointChange>& changes) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Record record;
  record.start_time = 1000.0;
  record.sample_time = 0.5;
  record.outputs.resize(2, samples);
  record.inputs.resize(2, samples);
  record.set_points.resize(2, samples);
  record.set_points.row(0).setConstant(7.0);
  record.set_points.row(1).setConstant(8.0);
  for (int k = 0; k < samples; ++k) {
    record.outputs.col(k) << 7.0 + 0.1 * normal(engine),
        8.0 + 0.2 * normal(engine);
    record.inputs.col(k) << 20.0, 30.0;
  }
  for (const SetPointChange& change : changes) {
    record.set_points.row(change.output)
        .tail(samples - change.sample)
        .setConstant(change.to);
  }
  return record;
}

WindowSet Found(const std::vector<Record>& records,
                const WindowOptions& options = {}) {
  const absl::StatusOr<WindowSet> set =
      FindWindows(records, WindowModel(), options);
  EXPECT_TRUE(set.ok()) << set.status();
  return set.ok() ? *set : WindowSet();
}

// A drift or a disturbance.
bool IsReported(const SetPointWindow& window) {
  for (const auto& parts : {window.before, window.after}) {
    for (const SteadyOperation& part : parts) {
      if (part.verdict == Verdict::kDrifting ||
          part.verdict == Verdict::kDisturbed) {
        return true;
      }
    }
  }
  return false;
}

TEST(SettlingTimeTest, IsThatOfTheSlowestElement) {
  EXPECT_DOUBLE_EQ(SettlingTime(WindowModel()), 52.0);
}

TEST(FindWindowsTest, AreAroundEachChangeWithTheModelsSettlingTime) {
  const Record record = Noise(2000, 1, {{500, 0, 7, 9}, {1200, 1, 8, 6}});
  const WindowSet set = Found({record});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_EQ(set.before, 52.0);
  EXPECT_EQ(set.after, 78.0);
  EXPECT_EQ(set.changes, 2);
  const SetPointWindow& window = set.windows[0];
  EXPECT_EQ(window.first_sample, 500 - 104);
  EXPECT_EQ(window.record.samples(), 104 + 156 + 1);
  EXPECT_EQ(window.record.time(window.changes.front().sample), 1250.0);
  EXPECT_EQ(window.changes[0].sample, 104);
  EXPECT_FALSE(window.clipped_before || window.clipped_after);
  EXPECT_FALSE(IsReported(window));
  EXPECT_TRUE(set.warnings.empty());
  EXPECT_EQ(window.record.outputs, record.outputs.middleCols(500 - 104, 261));
  EXPECT_EQ(window.changes[0].output, 0);
  EXPECT_EQ(window.changes[0].from, 7.0);
  EXPECT_EQ(window.changes[0].to, 9.0);
}

TEST(FindWindowsTest, ChangesTooCloseTogetherShareAWindow) {
  // 50 min and 25 min apart, then 100 min.
  const WindowSet set = Found({Noise(
      2000, 3,
      {{500, 0, 7, 9}, {600, 1, 8, 6}, {650, 0, 9, 7}, {850, 1, 6, 8}})});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_EQ(set.windows[0].changes.size(), 3u);
  EXPECT_EQ(set.windows[1].changes.size(), 1u);
  // The time between is shared; windows do not overlap.
  const SetPointWindow& first = set.windows[0];
  const SetPointWindow& second = set.windows[1];
  EXPECT_TRUE(first.clipped_after);
  EXPECT_TRUE(second.clipped_before);
  EXPECT_EQ(first.first_sample + first.record.samples(), second.first_sample);
  EXPECT_GE(first.first_sample + first.record.samples() - 1, 650 + 104);
}

// Whatever the changes, windows are disjoint, in order, hold their changes, and
// every change with enough samples after it is in one.
TEST(FindWindowsTest, AnyChangesGiveDisjointWindows) {
  std::mt19937_64 engine(4);
  for (int trial = 0; trial < 200; ++trial) {
    const int samples = 200 + static_cast<int>(engine() % 2000);
    std::vector<SetPointChange> changes;
    int at = 1 + static_cast<int>(engine() % 300);
    double value = 7.0;
    while (at < samples - 20) {
      changes.push_back({at, 0, value, value + 1.0});
      value += 1.0;
      at += 1 + static_cast<int>(engine() % 500);
    }
    const WindowSet set = Found({Noise(samples, trial, changes)});
    int end = 0;
    std::size_t held = 0;
    for (const SetPointWindow& window : set.windows) {
      EXPECT_GE(window.first_sample, end);
      end = window.first_sample + window.record.samples();
      EXPECT_LE(end, samples);
      held += window.changes.size();
      for (const SetPointChange& change : window.changes) {
        EXPECT_GE(change.sample, 0);
        EXPECT_LT(change.sample + 20, window.record.samples());
      }
    }
    EXPECT_EQ(held, changes.size());
  }
}

TEST(FindWindowsTest, AreClippedWhereTheRecordEnds) {
  const WindowSet set = Found({Noise(700, 5, {{30, 0, 7, 9}, {690, 0, 9, 7}})});
  ASSERT_EQ(set.windows.size(), 1u);
  EXPECT_TRUE(set.windows[0].clipped_before);
  // The last ends too soon after its change.
  ASSERT_EQ(set.warnings.size(), 2u);
  EXPECT_THAT(set.warnings[0], HasSubstr("has 9 samples after it"));
  EXPECT_THAT(set.warnings[1], HasSubstr("one window only"));
}

// A settling time of eleven samples: windows have what a fit needs.
TEST(FindWindowsTest, SlowSamplesHaveWindowsThatAreLongEnough) {
  Record slow = Noise(200, 5, {{60, 0, 7, 9}, {100, 0, 9, 7}, {112, 0, 7, 8}});
  slow.sample_time = 10.0;
  const WindowSet set = Found({slow});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_TRUE(set.warnings.empty()) << set.warnings.front();
  for (const SetPointWindow& window : set.windows) {
    EXPECT_GE(window.record.samples() - 1 - window.changes.back().sample, 20);
  }
  EXPECT_EQ(set.windows[1].changes.size(), 2u);
}

TEST(FindWindowsTest, ShortWindowsAreCountedAndSaidOnce) {
  std::vector<Record> records;
  for (const int at : {185, 190, 195}) {
    records.push_back(Noise(200, 5, {{at, 0, 7, 9}}));
  }
  const WindowSet set = Found(records);
  EXPECT_TRUE(set.windows.empty());
  ASSERT_EQ(set.warnings.size(), 1u);
  EXPECT_THAT(set.warnings[0],
              HasSubstr("has 14 samples after it, 2 more are like it: at least "
                        "20 are needed; they are left out"));
}

TEST(FindWindowsTest, OfChangesThatShareAWindowTheLastMayComeLate) {
  const WindowSet set =
      Found({Noise(700, 5, {{30, 0, 7, 9}, {600, 1, 8, 6}, {690, 0, 9, 7}})});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_EQ(set.windows[1].changes.size(), 2u);
  EXPECT_THAT(set.warnings, IsEmpty());
}

TEST(FindWindowsTest, WithoutSetPointsAreAroundMovesOfInputsByHand) {
  Record record = Noise(2000, 7, {});
  record.inputs.row(1).tail(1400).setConstant(31.0);
  record.inputs.row(0).segment(1300, 300).setConstant(19.0);
  const WindowSet set = Found({record});
  ASSERT_EQ(set.windows.size(), 3u);
  EXPECT_EQ(set.changes, 3);
  for (const SetPointWindow& window : set.windows) {
    EXPECT_EQ(window.changes.front().output, -1);
  }
  EXPECT_EQ(set.windows[0].first_sample + set.windows[0].changes[0].sample,
            600);
  EXPECT_THAT(set.warnings, ElementsAre(HasSubstr("no set point changes")));
  // Set points say more.
  record.set_points.row(0).tail(1000).setConstant(7.5);
  EXPECT_EQ(Found({record}).changes, 1);
  // And what a controller moves all the time says nothing.
  record.set_points.row(0).setConstant(7.0);
  for (int k = 0; k < record.samples(); k += 9) {
    record.inputs(0, k) += 0.1 * (k % 7);
  }
  EXPECT_THAT(Found({record}).windows, IsEmpty());
}

TEST(FindWindowsTest, TimesMayBeGiven) {
  Record record = Noise(2000, 6, {});
  record.set_points.resize(0, 0);
  EXPECT_THAT(Found({record}).windows, IsEmpty());
  const WindowSet set = Found({record}, {.change_times = {1300.1, 1700, 9000}});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_EQ(set.windows[0].record.time(set.windows[0].changes.front().sample),
            1300.0);
  EXPECT_EQ(set.windows[0].changes[0].output, -1);
  ASSERT_FALSE(set.warnings.empty());
  EXPECT_THAT(set.warnings[0], HasSubstr("1 of the given times"));
  EXPECT_FALSE(
      FindWindows({record}, WindowModel(), {.change_times = {2, 1}}).ok());
  EXPECT_FALSE(FindWindows({record}, WindowModel(), {.before = kNaN}).ok());
}

TEST(FindWindowsTest, SmallChangesAreNone) {
  const Record record = Noise(2000, 7, {{500, 0, 7, 7.01}, {1200, 0, 7.01, 9}});
  EXPECT_EQ(Found({record}).changes, 2);
  const WindowSet set = Found({record}, {.min_change = 0.1});
  ASSERT_EQ(set.changes, 1);
  EXPECT_EQ(set.windows[0].changes[0].from, 7.0);
  // A slow ramp of small steps is seen in the end.
  Record ramp = Noise(2000, 8, {});
  for (int k = 500; k < 600; ++k)
    ramp.set_points(0, k) = 7.0 + 0.02 * (k - 500);
  ramp.set_points.row(0).tail(1400).setConstant(9.0);
  const WindowSet ramped = Found({ramp}, {.min_change = 0.1});
  ASSERT_EQ(ramped.windows.size(), 1u);
  EXPECT_GT(ramped.changes, 10);
}

TEST(FindWindowsTest, DriftAndDisturbancesAreReported) {
  Record record = Noise(3000, 9, {{1000, 0, 7, 7}, {2000, 1, 8, 8.5}});
  record.set_points.row(0).tail(2000).setConstant(7.5);
  // A trend before the first change, a step before the second.
  record.outputs.row(0).segment(896, 104) +=
      Eigen::RowVectorXd::LinSpaced(104, 0.0, 0.4);
  record.outputs.row(1).segment(1950, 1050).array() += 0.5;
  const WindowSet set = Found({record});
  ASSERT_EQ(set.windows.size(), 2u);
  EXPECT_EQ(set.windows[0].before[0].verdict, Verdict::kDrifting);
  EXPECT_NEAR(set.windows[0].before[0].size, 0.4, 0.12);
  EXPECT_EQ(set.windows[0].before[1].verdict, Verdict::kSteady);
  EXPECT_EQ(set.windows[1].before[1].verdict, Verdict::kDisturbed);
  EXPECT_NEAR(set.windows[1].before[1].size, 0.5, 0.15);
  EXPECT_NEAR(set.windows[1].before[1].time, 1975.0, 3.0);
}

// In closed loop the control takes a disturbance away: it shows in what the
// model leaves of the output. What the inputs do by themselves is none.
TEST(FindWindowsTest, TheModelTellsDisturbancesFromMoves) {
  Record record = Noise(2000, 11, {{1000, 1, 8, 6}});
  const Eigen::VectorXd step =
      WindowModel().element(0, 0).StepResponse(0.5, 2000);
  record.inputs.row(0).tail(1050).array() += 1.0;  // a move, and its response
  record.outputs.row(0).tail(1050) += step.head(1050).transpose();
  WindowSet set = Found({record});
  EXPECT_EQ(set.windows[0].before[0].verdict, Verdict::kSteady);
  // The move answers a disturbance of the opposite sign, so that the output
  // ends where it was.
  record.outputs.row(0).tail(1050).array() -= 1.0;
  set = Found({record});
  EXPECT_EQ(set.windows[0].before[0].verdict, Verdict::kDisturbed);
  EXPECT_NEAR(set.windows[0].before[0].size, -1.0, 0.1);
  EXPECT_NEAR(set.windows[0].before[0].time, 1475.0, 1.0);
}

// The probability that is promised: less than 1 in 10⁴ parts.
TEST(FindWindowsTest, WhiteNoiseIsQuiet) {
  int reported = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    const WindowSet set = Found({Noise(600, seed, {{300, 0, 7, 9}})});
    reported += IsReported(set.windows[0]);
  }
  EXPECT_LE(reported, 2);  // of 2000 parts
}

}  // namespace
}  // namespace mle
