// Folds of the rows of windows.

#ifndef MLE_CORRECTION_FOLDS_H_
#define MLE_CORRECTION_FOLDS_H_

#include <vector>

#include "mle/correction/regression_data.h"

namespace mle {

using Fold = std::vector<RegressionRows>;

// A fold for each window.
std::vector<Fold> FoldsByWindow(const RegressionData& data);

// The windows' runs of rows, cut into blocks of `block_length` ≥ 1 rows that
// are assigned to `count` ≥ 1 folds in turn. Empty folds are left out. Cuts lie
// `shift` ≥ 0 rows later.
std::vector<Fold> FoldsByBlock(const RegressionData& data, int count,
                               int block_length, int shift = 0);

// The first `length` rows of `rows`, the next, and so on; the last block may be
// longer by less than `length`. With a `shift` > 0 a block of so many rows
// comes first, if as many are left for others.
std::vector<RegressionRows> SplitIntoBlocks(const RegressionRows& rows,
                                            int length, int shift = 0);

}  // namespace mle

#endif  // MLE_CORRECTION_FOLDS_H_
