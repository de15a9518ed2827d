// Samples that a historian made up: between the values that it archived it
// interpolates, and only the archived values are evidence.
//
//   linear   swinging door, or an export denser than the archive: samples lie
//            on straight lines between archived ones, to the last digit
//   held     exception reporting, or an analyser: a value is repeated until the
//            next one is archived
//
// Linear: |y_{k−1} − 2y_k + y_{k+1}| is no more than rounding in at least 30 %
// of the samples of a signal that moves, and is far more at single samples, the
// archived ones. A smooth signal bends a little everywhere; where the digits
// printed could hide that, the slopes must also alternate, as noise has it.
//
// Held: at least 40 % of the samples repeat the one before, in many short runs
// between steps of many sizes. The steps of a rounded signal have few sizes: it
// is held where they come at multiples of a period, as of a laboratory or an
// analyser, which slopes and noise do not.

#ifndef MLE_DATA_COMPRESSION_H_
#define MLE_DATA_COMPRESSION_H_

#include <vector>

#include "mle/data/robust_statistics.h"

namespace mle {

struct Compression {
  enum class Kind { kNone, kLinear, kHeld };
  Kind kind = Kind::kNone;
  int samples = 0;   // that are good
  int archived = 0;  // of these
  // Held, and what is archived comes at multiples of a period: all that was
  // measured, and not a choice of it.
  bool is_sampled = false;
  // For each row and sample: interpolated; empty for kNone.
  std::vector<std::vector<bool>> interpolated;

  double ArchivedShare() const;
};

// Whether a channel holds its values by itself, as inputs and set points do;
// only lines are looked for then.
enum class Holding { kNever, kByItself };

// Finds how one channel was compressed; `rows`: its samples in each record.
Compression FindCompression(const std::vector<SampleRow>& rows, Holding own);

// Of a channel that is known to be measured every `period` samples and held.
Compression HeldBetween(const std::vector<SampleRow>& rows, double period);

}  // namespace mle

#endif  // MLE_DATA_COMPRESSION_H_
