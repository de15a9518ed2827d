// Takes records while they are read, piece by piece, and keeps what it wants of
// them, so that they need not all be in memory at once.

#ifndef MLE_DATA_RECORD_SINK_H_
#define MLE_DATA_RECORD_SINK_H_

#include <vector>

#include "absl/status/status.h"
#include "mle/data/record.h"

namespace mle {

class RecordSink {
 public:
  virtual ~RecordSink() = default;

  // Samples of a piece, ≥ 2. A piece ends behind a sample whose inputs and set
  // points are known, so that no gap lies across its end, but at twice as many
  // samples at the latest; and where its record ends, perhaps sooner.
  virtual int PieceSamples(double sample_time) const = 0;
  // A piece of a record, gaps bridged, in order of time. `continues`: it
  // follows the piece before without a gap. An error ends the import.
  virtual absl::Status Take(Record piece, bool continues) = 0;
  // The records that are kept, in order of time, after the last piece.
  virtual std::vector<Record> Finish() = 0;
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_SINK_H_
