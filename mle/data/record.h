// A record of routine operation, sampled every Δt.
//
// Column k holds the sample at start_time + kΔt. The inputs are what acts from
// that sample to the next (zero-order hold); the outputs are measured just
// before the inputs change. Rows follow the process model's channels.

#ifndef MLE_DATA_RECORD_H_
#define MLE_DATA_RECORD_H_

#include <span>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/base/double_limits.h"

namespace mle {

struct Record {
  double start_time = 0.0;
  double sample_time = 0.0;    // Δt
  Eigen::MatrixXd outputs;     // p × N, y_k
  Eigen::MatrixXd inputs;      // m × N, u_k
  Eigen::MatrixXd set_points;  // p × N, or 0 × 0 without set points

  // Shapes agree, Δt > 0, finite values are within ± kLargestSample. Values may
  // be NaN: bad samples.
  absl::Status Validate() const;

  int samples() const { return static_cast<int>(outputs.cols()); }
  int num_outputs() const { return static_cast<int>(outputs.rows()); }
  int num_inputs() const { return static_cast<int>(inputs.rows()); }
  double time(int k) const { return start_time + k * sample_time; }
  // Samples at the begin in which no output is measured, though one is later:
  // they only say what the inputs did before.
  int lead() const;
};

// A change of set point: output `output` from sample `sample` on.
struct SetPointChange {
  int sample = 0;
  int output = 0;
  double from = 0.0;
  double to = 0.0;
};

// In order of time.
std::vector<SetPointChange> FindSetPointChanges(const Record& record);

// Samples `first` to `first` + `samples` − 1.
Record PartOf(const Record& record, int first, int samples);

// A signal without gaps: a value that is not finite becomes the last finite one
// before it, at the start the first one; all become 0 where none is finite.
Eigen::VectorXd Filled(const Eigen::Ref<const Eigen::VectorXd>& values);

// Records of the same channels side by side, as if no time were between them;
// at least one.
Record JoinRecords(std::span<const Record> records);

// The part of `record` from `before` to `after` (both ≥ 0, in time units, ends
// included) around sample `center`. OutOfRange where the record does not hold
// it whole; the message gives the times wanted and present.
absl::StatusOr<Record> CutWindow(const Record& record, int center,
                                 double before, double after);

}  // namespace mle

#endif  // MLE_DATA_RECORD_H_
