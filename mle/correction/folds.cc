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
                               int block_length, int shift) {
  std::vector<Fold> folds(count);
  std::size_t next = 0;
  for (int i = 0; i < data.num_windows(); ++i) {
    for (const RegressionRows& rows : data.window(i)) {
      for (RegressionRows& block : SplitIntoBlocks(rows, block_length, shift)) {
        folds[next++ % folds.size()].push_back(std::move(block));
      }
    }
  }
  std::erase_if(folds, [](const Fold& fold) { return fold.empty(); });
  return folds;
}

std::vector<RegressionRows> SplitIntoBlocks(const RegressionRows& rows,
                                            int length, int shift) {
  // No binding: clang 14 takes none into the lambda.
  const int first = rows.rows.first;
  const int last = rows.rows.last;
  std::vector<RegressionRows> blocks;
  // Responses run backwards in time.
  const auto add = [&](int begin, int end) {
    blocks.push_back({rows.series,
                      {begin, end},
                      rows.responses.middleCols(last - end, end - begin + 1),
                      rows.group});
  };
  int next = first;
  if (shift > 0 && rows.rows.rows() / 2 >= shift) {
    add(first, first + shift - 1);
    next += shift;
  }
  for (; (last - next + 1) / 2 >= length; next += length) {
    add(next, next + length - 1);
  }
  add(next, last);
  return blocks;
}

}  // namespace mle
