// Windows whose inputs are all known.

#ifndef MLE_MAINTAIN_WHOLE_WINDOWS_H_
#define MLE_MAINTAIN_WHOLE_WINDOWS_H_

#include <cstddef>
#include <vector>

#include "mle/data/record.h"
#include "mle/data/set_point_windows.h"

namespace mle {

// Samples first … last.
struct SampleRange {
  int first = 0;
  int last = -1;

  int samples() const { return last - first + 1; }
};

// Parts in which every input is known, this long at least.
std::vector<SampleRange> WholeParts(const Record& record, int samples);

// The longest part in which every input is known.
SampleRange WholeInputs(const Record& record);

// Leaves of a window what is in `range`.
void Cut(SampleRange range, SetPointWindow& window);

// A record, number `source`, as a window.
SetPointWindow WholeWindow(const Record& record, std::size_t source);

}  // namespace mle

#endif  // MLE_MAINTAIN_WHOLE_WINDOWS_H_
