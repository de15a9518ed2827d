#include "mle/maintain/informative_windows.h"

#include <random>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/data/record.h"
#include "mle/maintain/whole_windows.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"
#include "tests/mle/maintain/two_input_model.h"

namespace mle {
namespace {

using testing::TwoInputModel;

// Five settling times: too short to be divided.
constexpr int kWindowSamples = 240;

// Windows of one record; in each one input steps by the size given.
RecordData DataOf(const std::vector<std::pair<int, double>>& steps) {
  RecordData data;
  data.report.sample_time = 1.0;
  Record& record = data.records.emplace_back();
  record.sample_time = 1.0;
  const auto count = static_cast<int>(steps.size());
  record.inputs.setZero(2, kWindowSamples * count);
  record.outputs.setZero(1, kWindowSamples * count);
  for (int w = 0; w < count; ++w) {
    record.inputs.row(steps[w].first)
        .segment(w * kWindowSamples + kWindowSamples / 3, kWindowSamples / 3)
        .setConstant(steps[w].second);
  }
  const SetPointWindow whole = WholeWindow(record, 0);
  for (int w = 0; w < count; ++w) {
    SetPointWindow& window = data.windows.emplace_back(whole);
    Cut({.first = w * kWindowSamples, .last = (w + 1) * kWindowSamples - 1},
        window);
  }
  return data;
}

std::vector<int> FirstSamples(const RecordData& data) {
  std::vector<int> first;
  for (const SetPointWindow& window : data.windows) {
    first.push_back(window.first_sample);
  }
  return first;
}

TEST(InformativeWindowsTest, AShortRecordIsUsedWhole) {
  for (const int most : {0, 4 * kWindowSamples}) {
    RecordData data = DataOf({{0, 1.0}, {1, 1.0}, {0, 0.1}, {1, 0.1}});
    ASSERT_TRUE(KeepInformativeWindows(TwoInputModel(), most, data).ok());
    EXPECT_EQ(data.windows.size(), 4);
    EXPECT_TRUE(data.unused.empty());
    EXPECT_TRUE(data.notes.empty());
  }
}

// Of two windows: one for each input, the one with the larger moves, though
// both of the other input have larger ones still.
TEST(InformativeWindowsTest, EveryElementIsInformedFirst) {
  RecordData data = DataOf({{0, 5.0}, {1, 0.5}, {0, 4.0}, {1, 1.0}});
  ASSERT_TRUE(
      KeepInformativeWindows(TwoInputModel(), 2 * kWindowSamples, data).ok());
  EXPECT_EQ(FirstSamples(data), (std::vector<int>{0, 3 * kWindowSamples}));
  ASSERT_EQ(data.unused.size(), 2);
  EXPECT_EQ(data.unused[0].first_sample, kWindowSamples);
  EXPECT_EQ(data.unused[1].first_sample, 2 * kWindowSamples);
  ASSERT_EQ(data.notes.size(), 1);
  EXPECT_EQ(data.notes[0].code, MessageCode::kWindowDropped);
  // Nothing is at rest where set points moved.
  EXPECT_TRUE(data.AtRest().empty());
}

// The choice does not depend on units, and a window that moves nothing is the
// last to be taken.
TEST(InformativeWindowsTest, UnitsDoNotMatter) {
  const std::vector<std::pair<int, double>> steps = {
      {0, 1.0}, {1, 0.0}, {0, 2.0}, {1, 3.0}, {0, 0.5}};
  for (const int windows : {2, 3, 4}) {
    RecordData data = DataOf(steps);
    RecordData scaled = DataOf(steps);
    scaled.windows.clear();
    scaled.records[0].inputs.row(0) *= 1000.0;
    const SetPointWindow whole = WholeWindow(scaled.records[0], 0);
    for (int w = 0; w < 5; ++w) {
      SetPointWindow& window = scaled.windows.emplace_back(whole);
      Cut({.first = w * kWindowSamples, .last = (w + 1) * kWindowSamples - 1},
          window);
    }
    ProcessModel model = TwoInputModel();
    ASSERT_TRUE(
        KeepInformativeWindows(model, windows * kWindowSamples, data).ok());
    model.element(0, 0) = TransferFunction::FirstOrder(0.002, 6.0, 1.0);
    ASSERT_TRUE(
        KeepInformativeWindows(model, windows * kWindowSamples, scaled).ok());
    EXPECT_EQ(data.windows.size(), windows);
    EXPECT_EQ(FirstSamples(data), FirstSamples(scaled));
    for (const int first : FirstSamples(data)) EXPECT_NE(first, kWindowSamples);
  }
}

// A window beyond the budget is divided, and parts that adjoin are kept in
// order of time.
TEST(InformativeWindowsTest, LongWindowsAreDivided) {
  RecordData data = DataOf(std::vector<std::pair<int, double>>(40, {0, 1.0}));
  const SetPointWindow whole = WholeWindow(data.records[0], 0);
  data.windows = {whole};
  ASSERT_TRUE(KeepInformativeWindows(TwoInputModel(), 3000, data).ok());
  int samples = 0;
  int last = -1;
  for (const SetPointWindow& window : data.windows) {
    EXPECT_GT(window.first_sample, last);
    last = window.first_sample + window.record.samples() - 1;
    samples += window.record.samples();
    EXPECT_EQ(window.record.inputs,
              whole.record.inputs.middleCols(window.first_sample,
                                             window.record.samples()));
  }
  EXPECT_LE(samples, 3000);
  EXPECT_GT(samples, 2000);
}

// Short windows are taken together with their neighbours: four of 60 samples
// make four settling times. The sixth is missing, so that the fifth has only
// those before it.
TEST(InformativeWindowsTest, ShortWindowsThatAdjoinAreTakenTogether) {
  constexpr int kShort = kWindowSamples / 4;
  RecordData data = DataOf(std::vector<std::pair<int, double>>(10, {0, 1.0}));
  const SetPointWindow whole = WholeWindow(data.records[0], 0);
  data.windows.clear();
  for (int w = 0; w < 40; ++w) {
    if (w == 5) continue;
    SetPointWindow& window = data.windows.emplace_back(whole);
    Cut({.first = w * kShort, .last = (w + 1) * kShort - 1}, window);
  }
  ASSERT_TRUE(
      KeepInformativeWindows(TwoInputModel(), 4 * kWindowSamples, data).ok());
  int samples = 0;
  int piece = 0;
  int end = -1;
  const auto check = [&] {
    EXPECT_TRUE(piece == 0 || piece >= 4 * kShort) << piece << " to " << end;
  };
  for (const SetPointWindow& window : data.windows) {
    if (window.first_sample != end) {
      check();
      piece = 0;
    }
    piece += window.record.samples();
    samples += window.record.samples();
    end = window.first_sample + window.record.samples();
  }
  check();
  EXPECT_LE(samples, 4 * kWindowSamples);
  EXPECT_GT(samples, 2 * kWindowSamples);
}

}  // namespace
}  // namespace mle
