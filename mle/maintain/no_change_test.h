// The test of no change, calibrated.
//
// The likelihood ratio of the output-error correction is χ² with ν degrees of
// freedom in long records. Where outputs drift, or inputs hardly move, it is
// larger: dead times are searched among many local minima, and the drift's size
// is estimated along with the model. So, where χ² rejects the initial model but
// not beyond doubt, records are simulated from that model: the inputs as they
// were, noise and drift as they were estimated, gaps where they were. The same
// test of each gives the mean statistic without any change, and Bartlett's
// factor
//
//   c = max(1, mean / ν),   p = P(χ²_ν > statistic / c).
//
// (Bartlett, Proc. R. Soc. A 160, 1937.)

#ifndef MLE_MAINTAIN_NO_CHANGE_TEST_H_
#define MLE_MAINTAIN_NO_CHANGE_TEST_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/message.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// `test` is what CorrectByOutputError() said of `windows` with `options`. The
// result does not depend on options.threads.
absl::StatusOr<NullCalibration> CalibrateTest(
    const ProcessModel& initial, const std::vector<Record>& windows,
    const OutputErrorCorrection& test, const OutputErrorOptions& options,
    const NullCalibrationOptions& calibration,
    const ProgressCallback& progress = {});

}  // namespace mle

#endif  // MLE_MAINTAIN_NO_CHANGE_TEST_H_
