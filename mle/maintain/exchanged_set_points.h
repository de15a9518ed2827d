// Set points under each other's tag.
//
// Control brings an output to its set point. Between two changes of set points
// the mean of the last third of the samples says where each output came to;
// with squares S of the distances from a constant plus its own set point, plus
// the other's, and from a constant alone, the set points of two outputs are
// exchanged if, for both, S of the other's is below a tenth of the two others.
// Both have to move, and control has to be without offset, or nearly.

#ifndef MLE_MAINTAIN_EXCHANGED_SET_POINTS_H_
#define MLE_MAINTAIN_EXCHANGED_SET_POINTS_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

struct ExchangedSetPoints {
  int first = 0;  // outputs
  int second = 0;
  // The ratio of S, own over other's: the smaller of both outputs.
  double ratio = 0.0;
};

// An output is in one pair at most. Records without set points have none.
std::vector<ExchangedSetPoints> FindExchangedSetPoints(
    const std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_MAINTAIN_EXCHANGED_SET_POINTS_H_
