#include "mle/correction/folds.h"

#include <algorithm>
#include <utility>

namespace mle {

std::vector<Fold> FoldsByWindow(const RegressionData& data) {
  std::vector<Fold> folds;
  for (int i = 0; i < data.num_windows(); ++i) folds.push_back(data.window(i));
  return folds;
}

std::vector<Fold> FoldsByBlock(const RegressionData& data, int count,
                               int block_length) {
  std::vector<Fold> folds(count);
  std::size_t next = 0;
  for (int i = 0; i < data.num_windows(); ++i) {
    for (const RegressionRows& rows : data.window(i)) {
      for (RegressionRows& block : SplitIntoBlocks(rows, block_length)) {
        folds[next++ % folds.size()].push_back(std::move(block));
      }
    }
  }
  std::erase_if(folds, [](const Fold& fold) { return fold.empty(); });
  return folds;
}

std::vector<RegressionRows> SplitIntoBlocks(const RegressionRows& rows,
                                            int length) {
  std::vector<RegressionRows> blocks;
  const int count = std::max(rows.rows.rows() / length, 1);
  for (int i = 0; i < count; ++i) {
    const int first = rows.rows.first + i * length;
    const int last = i + 1 < count ? first + length - 1 : rows.rows.last;
    // Responses run backwards in time.
    blocks.push_back(
        {rows.series,
         {first, last},
         rows.responses.middleCols(rows.rows.last - last, last - first + 1),
         rows.group});
  }
  return blocks;
}

}  // namespace mle
