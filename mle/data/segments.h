// Windows that follow each other without a gap, as one.
//
// A window alone does not say what the inputs did before it. Where the window
// before ends a sample earlier, they are known: a model's response goes on from
// one to the next, and nothing has to be estimated, or left out, at its begin.

#ifndef MLE_DATA_SEGMENTS_H_
#define MLE_DATA_SEGMENTS_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

// Where a window lies in the segments, without its lead.
struct SegmentPart {
  int segment = 0;
  int first = 0;  // sample
  int samples = 0;
};

// `after` begins with the sample after the last one of `before`.
bool Adjoin(const SegmentPart& before, const SegmentPart& after);

struct Segments {
  std::vector<Record> records;
  std::vector<SegmentPart> windows;  // one for each window

  // The window of a segment that holds `time`.
  int WindowAt(int segment, double time) const;
};

// In order of the windows. Windows are joined where the next one begins one
// sample after the last ends and both have set points or neither has.
Segments JoinAdjoining(const std::vector<Record>& windows);

}  // namespace mle

#endif  // MLE_DATA_SEGMENTS_H_
