// The noise of each output from the quiet stretches of records: its white part
// and its drift, a random walk,
//
//   n_k = w_k + e_k,  w_{k+1} = w_k + ξ_k,  Var e = r,  Var ξ = q per sample,
//
// by restricted maximum likelihood (innovations_filter.h), each stretch with a
// level of its own. In closed loop the inputs move in answer to the noise; what
// they do to the outputs is taken off by the model's response, with gains, time
// scales and dead times free in first order, so that what has aged is not taken
// for noise; large changes of dead times and time constants are, in part, and
// the noise that CorrectStructure() estimates beside the parameters is the
// better one once there is a correction. Outliers are left out, gaps are gaps.
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::vector<QuietNoise> noise,
//       EstimateQuietNoise(records, FindChanges(records, {}), model, {}));
//   noise[0].variance;            // r
//   noise[0].increment_variance;  // q

#ifndef MLE_NONLINEAR_QUIET_NOISE_H_
#define MLE_NONLINEAR_QUIET_NOISE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {

struct QuietNoiseOptions {
  // After a change of set point until a stretch is quiet, in the model's time
  // unit, ≥ 0; 0: the model's settling time.
  double settling = 0.0;
  // A stretch has at least this many samples, ≥ 20.
  int min_samples = 60;
  // Of all stretches together, ≥ min_samples: each is cut for its share.
  int max_samples = 20000;
  // Takes off the model's response to the inputs.
  bool use_model = true;
  // Lets the elements change.
  bool free_elements = true;

  absl::Status Validate() const;
};

struct QuietNoise {
  double variance = 0.0;                  // r
  double variance_error = 0.0;            // its standard error
  double increment_variance = 0.0;        // q
  double increment_variance_error = 0.0;  // 0 where q is
  // That q does not exceed with a probability of 97.5 % (profile likelihood).
  double increment_variance_upper = 0.0;
  double drift_p_value = 1.0;  // of q = 0: likelihood ratio
  int samples = 0;             // used
  int stretches = 0;
  int outliers = 0;  // left out

  // As StructuredFit has it.
  NoiseEstimate ToNoiseEstimate() const;
  std::string Report() const;  // one line
};

// One for each output. `changes` are those of each record (FindChanges()).
// FailedPrecondition where an output has no stretch that is long enough; the
// message says how long one has to be. InvalidArgument for options, and records
// that are not valid or not of these channels.
absl::StatusOr<std::vector<QuietNoise>> EstimateQuietNoise(
    const std::vector<Record>& records,
    const std::vector<std::vector<SetPointChange>>& changes,
    const ProcessModel& model, const QuietNoiseOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_QUIET_NOISE_H_
