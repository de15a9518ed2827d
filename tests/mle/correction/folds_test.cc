#include "mle/correction/folds.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

TEST(SplitIntoBlocksTest, CoversEveryRowOnce) {
  const ArxModel model = SparseArx();
  const auto data = RegressionData::Create({SimulateArx(model, 104, 0.1, 1)},
                                           model, Scaling::kRaw);
  ASSERT_TRUE(data.ok());
  const RegressionRows& rows = data->window(0)[0];
  ASSERT_EQ(rows.rows.rows(), 100);
  for (const int length :
       {1, 7, 30, 50, 51, 99, 100, 101, 1000, 2'147'483'647}) {
    const std::vector<RegressionRows> blocks = SplitIntoBlocks(rows, length);
    int next = rows.rows.first;
    for (const RegressionRows& block : blocks) {
      EXPECT_EQ(block.series, rows.series);
      EXPECT_EQ(block.rows.first, next);
      next = block.rows.last + 1;
      ASSERT_EQ(block.responses.cols(), block.rows.rows());
      for (int k = block.rows.first; k <= block.rows.last; ++k) {
        EXPECT_EQ(block.responses.col(block.rows.last - k),
                  rows.responses.col(rows.rows.last - k));
      }
      const bool last = &block == &blocks.back();
      EXPECT_GE(block.rows.rows(), std::min(length, 100));
      EXPECT_LT(block.rows.rows(), last ? 2.0 * length : length + 1.0);
    }
    EXPECT_EQ(next, rows.rows.last + 1);
  }
}

TEST(SplitIntoBlocksTest, ShiftedCutsLieLater) {
  const ArxModel model = SparseArx();
  const auto data = RegressionData::Create({SimulateArx(model, 104, 0.1, 1)},
                                           model, Scaling::kRaw);
  ASSERT_TRUE(data.ok());
  const RegressionRows& rows = data->window(0)[0];
  const auto ends = [&](int length, int shift) {
    std::vector<int> last;
    for (const RegressionRows& block : SplitIntoBlocks(rows, length, shift)) {
      last.push_back(block.rows.last - 3);
      EXPECT_EQ(block.responses.col(0),
                rows.responses.col(rows.rows.last - block.rows.last));
    }
    return last;
  };
  EXPECT_EQ(ends(30, 15), (std::vector<int>{15, 45, 100}));
  EXPECT_EQ(ends(30, 0), (std::vector<int>{30, 60, 100}));
  EXPECT_EQ(ends(100, 50), (std::vector<int>{50, 100}));
  // No room for a block of 60 and as many rows besides.
  EXPECT_EQ(ends(120, 60), (std::vector<int>{100}));
  EXPECT_EQ(ends(2'147'483'647, 1'073'741'824), (std::vector<int>{100}));
}

// Three windows, one of them in two runs: 100, 46 and 66, 30 rows.
RegressionData ThreeWindows() {
  const ArxModel model = SparseArx();
  std::vector<Record> windows = {SimulateArx(model, 104, 0.1, 1),
                                 SimulateArx(model, 120, 0.1, 2),
                                 SimulateArx(model, 34, 0.1, 3)};
  windows[1].outputs(0, 50) = std::numeric_limits<double>::quiet_NaN();
  auto data = RegressionData::Create(windows, model, Scaling::kRaw);
  EXPECT_TRUE(data.ok()) << data.status();
  return *std::move(data);
}

TEST(FoldsTest, ByWindow) {
  const RegressionData data = ThreeWindows();
  const std::vector<Fold> folds = FoldsByWindow(data);
  ASSERT_EQ(folds.size(), 3U);
  EXPECT_EQ(folds[0].size(), 1U);
  EXPECT_EQ(folds[1].size(), 2U);
  EXPECT_EQ(folds[1][1].rows.first, data.window(1)[1].rows.first);
}

TEST(FoldsTest, ByBlockDealsEveryRowOnceInTurn) {
  const RegressionData data = ThreeWindows();
  std::vector<RegressionRows> blocks;
  for (int i = 0; i < 3; ++i) {
    for (const RegressionRows& run : data.window(i)) {
      for (const RegressionRows& block : SplitIntoBlocks(run, 20)) {
        blocks.push_back(block);
      }
    }
  }
  const std::vector<Fold> folds = FoldsByBlock(data, 4, 20);
  ASSERT_EQ(folds.size(), 4U);
  std::size_t dealt = 0;
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t i = 0; i < folds[f].size(); ++i, ++dealt) {
      const RegressionRows& expected = blocks[4 * i + f];
      EXPECT_EQ(folds[f][i].series, expected.series);
      EXPECT_EQ(folds[f][i].rows.first, expected.rows.first);
      EXPECT_EQ(folds[f][i].rows.last, expected.rows.last);
    }
  }
  EXPECT_EQ(dealt, blocks.size());
  // One block each for the windows' runs, and none for the last folds.
  EXPECT_EQ(FoldsByBlock(data, 9, 1000).size(), 4U);
}

}  // namespace
}  // namespace mle
