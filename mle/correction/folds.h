// Rows of windows dealt into folds.

#ifndef MLE_CORRECTION_FOLDS_H_
#define MLE_CORRECTION_FOLDS_H_

#include <vector>

#include "mle/correction/regression_data.h"

namespace mle {

using Fold = std::vector<RegressionRows>;

// A fold for each window.
std::vector<Fold> FoldsByWindow(const RegressionData& data);

// The windows' runs of rows, cut into blocks of `block_length` ≥ 1 rows that go
// to `count` ≥ 1 folds in turn. Folds that get none are left out.
std::vector<Fold> FoldsByBlock(const RegressionData& data, int count,
                               int block_length);

// The first `length` rows of `rows`, the next, and so on; the last block may be
// longer by less than `length`.
std::vector<RegressionRows> SplitIntoBlocks(const RegressionRows& rows,
                                            int length);

}  // namespace mle

#endif  // MLE_CORRECTION_FOLDS_H_
