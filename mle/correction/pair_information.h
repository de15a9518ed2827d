// The information of records about each pair of output and input, before a
// correction: the standard error that the best estimate of its gain would have,
// relative to the gain, by Fisher's information (ComputeOutputErrorLimit()) at
// the model's values, under the outputs' noise and drift, with gain, time scale
// and dead time of every element free and an offset for each window.
//
// An input that hardly moves, or only together with another one, leaves that
// error large; the second shows in `inflation`. Pairs that are not informed
// keep the initial model's values.
//
//   MLE_ASSIGN_OR_RETURN(
//       const PairInformation information,
//       AssessInformation(model, windows.Records(), noise, {}));
//   information.pair(0, 0).state;
//   if (information.pair(0, 1).state == PairState::kNotInformed) …

#ifndef MLE_CORRECTION_PAIR_INFORMATION_H_
#define MLE_CORRECTION_PAIR_INFORMATION_H_

#include <limits>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct InformationOptions {
  // Relative standard errors of a gain, 0 < informed ≤ weak: up to the first
  // the pair is informed (a change of a third of the gain is three standard
  // errors), up to the second weakly, above not.
  double informed = 0.1;
  double weak = 0.5;
  // Bounds of dead times and scales are as in the correction.
  OutputErrorOptions output_error = {};

  absl::Status Validate() const;
};

enum class PairState {
  kAbsent,       // zero in the model
  kNotInformed,  // not determined by these records
  kWeak,         // large changes can
  kInformed,
};

// Standard errors to be expected; infinite where the records do not determine
// it.
struct PairErrors {
  PairState state = PairState::kAbsent;
  double gain = std::numeric_limits<double>::infinity();        // relative
  double time_scale = std::numeric_limits<double>::infinity();  // relative
  double delay = std::numeric_limits<double>::infinity();       // in time units
  // `gain` over what it would be if all other elements of the output were
  // known: 1 where inputs move independently of each other.
  double inflation = 1.0;
};

struct InputExcitation {
  double deviation = 0.0;  // standard deviation within the windows
  double range = 0.0;      // largest less smallest, of the widest window
  int moves = 0;           // samples at which it changes
};

struct PairInformation {
  int num_inputs = 0;
  std::vector<PairErrors> pairs;        // row by row: p × m
  std::vector<InputExcitation> inputs;  // m
  // m × m: correlation of the inputs within the windows; 0 with one that does
  // not move.
  Eigen::MatrixXd input_correlation;

  const PairErrors& pair(int output, int input) const {
    return pairs[output * num_inputs + input];
  }
  // Inputs that some present pair is not, or weakly, informed by: those that a
  // step test would have to move.
  std::vector<int> inputs_to_test() const;
  // A line for each pair and input.
};

// InvalidArgument as of ComputeOutputErrorLimit().
absl::StatusOr<PairInformation> AssessInformation(
    const ProcessModel& model, const std::vector<Record>& windows,
    const std::vector<NoiseEstimate>& noise, const InformationOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_PAIR_INFORMATION_H_
