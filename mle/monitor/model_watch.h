// The evidence that batches of records hold about changes of a model's
// elements: noise and operating range from a reference period, then for each
// batch (a day) the scores of each output.
//
//   score        S = V W⁻¹ Σ_k J_k ψ(ν_k)   (n)
//   information      V W⁻¹ V                (n × n),   V = Σ_k J_k J_kᵀ
//
// with ν the innovations of the model as it is, whitened by the noise of the
// reference, J their sensitivities to the changes of the output's parameters
// (relative changes of gain and time constant, dead time), and ψ clipping.
// Where nothing has changed Σ J ψ has mean 0 and, with the autocovariances γ_h
// of the clipped innovations of the reference, the variance
//
//   W = f Σ_kl (1 − |k − l|/(H + 1)) γ_|k−l| J_k J_lᵀ
//
// (Newey and West, Econometrica 55, 1987), which is taken to be V at least; f
// is the square of the robust deviation of what the best change does not
// explain, over that in the reference, 1 at least. After a change δ the mean of
// S is its information times δ.
//
// Samples count from before a set-point change until the plant has settled
// (without set points, moves of inputs that rest otherwise): what inputs answer
// between changes is the disturbance itself. Changes between which the plant
// settles have scores of their own, with an offset each, which are added up;
// that of the largest is kept beside the sum where they agree, so that others
// of the same batch can confirm it (ConfirmedEvidenceOf() in
// change_evidence.h). A batch whose records forbid a correction
// (examine_records.h), that have changed themselves (record_jump.h), whose
// operation has left the range of the reference, or that is disturbed says
// nothing, with the reason.
//
//   MLE_ASSIGN_OR_RETURN(const ModelWatch watch,
//                        ModelWatch::Create(model, 1.0, WatchOptions()));
//   MLE_ASSIGN_OR_RETURN(const WatchReference reference,
//                        watch.MakeReference(first_days));
//   MLE_ASSIGN_OR_RETURN(const BatchScores scores,
//                        watch.Score(reference, day, first_sample));
//
// docs/watch.md has the derivation, what the level rests on, and measurements.

#ifndef MLE_MONITOR_MODEL_WATCH_H_
#define MLE_MONITOR_MODEL_WATCH_H_

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/monitor/change_evidence.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

struct OutputReference {
  NoiseEstimate noise;
  double deviation = 1.0;           // s₀, in √r
  std::vector<double> covariances;  // γ_0 … γ_H, in r
};

// How the plant ran in the reference: what the cost of operation depends on.
struct OutputOperation {
  double changes = 0.0;      // of the set point, in a batch
  double change_size = 0.0;  // root mean square of them
  // Mean of (y − r)² away from changes; nothing where that is not known.
  std::optional<double> squared_error = {};
};

struct WatchReference {
  std::vector<OutputReference> outputs;  // p
  // p; none where records have no set points.
  std::vector<OutputOperation> operation;
  // p + m: usual range of each output and input.
  Eigen::VectorXd low;
  Eigen::VectorXd high;
};

// A batch: a record that begins ModelWatch::lead() samples before it, where it
// can.
struct WatchBatch {
  Record record;
  int first = 0;  // sample of the record that the batch begins with
};

enum class BatchState {
  kUsed,
  kNothingMoved,  // no set-point change (or step of a resting input)
  kCannotTell,    // see the reason
};

// "used", "nothing_moved", "cannot_tell".
std::string_view NameOf(BatchState state);

struct BatchOutput {
  BatchState state = BatchState::kNothingMoved;
  std::string reason;           // of kCannotTell: a whole sentence
  Eigen::VectorXd score;        // n, or empty
  Eigen::MatrixXd information;  // n × n, or empty
  // Score and information of the set-point change in the batch whose score is
  // the largest, by SᵀV⁺S. Empty unless noise in one change exceeds that with a
  // probability below 1 %, there are other changes, and all agree: that one
  // change of the parameters explains them is not rejected at 5 %.
  std::optional<ScorePart> largest = {};
};

struct BatchScores {
  BatchState state = BatchState::kNothingMoved;  // the best of the outputs'
  std::vector<BatchOutput> outputs;              // p

  // The reasons, each once.
  std::vector<std::string> Reasons() const;
};

class RowResponse;

class ModelWatch {
 public:
  // InvalidArgument for options, models and elements that cannot be watched
  // (feedthrough), and for a sample time that is not > 0.
  static absl::StatusOr<ModelWatch> Create(const ProcessModel& model,
                                           double sample_time,
                                           const WatchOptions& options);

  const ProcessModel& model() const { return model_; }
  const WatchOptions& options() const { return options_; }
  // Inputs of the elements of the output that are present, which have three
  // parameters each, and the units of these (n): 1, 1, s.
  const std::vector<int>& inputs(int output) const;
  const Eigen::VectorXd& units(int output) const;
  int lead() const { return skip_ + after_; }
  // n: changes of the output's parameters not worth an alarm.
  Eigen::VectorXd LeastChanges(int output) const;

  // From what the plant does while nothing is asked of it. FailedPrecondition
  // where an output has fewer than 200 usable samples.
  absl::StatusOr<WatchReference> MakeReference(
      const std::vector<WatchBatch>& given) const;

  // Errors as of ExamineRecords().
  absl::StatusOr<BatchScores> Score(const WatchReference& reference,
                                    WatchBatch batch) const;

  // p, n × n each: the informations that the outputs' scores are expected to
  // have in a batch in which the inputs go up by `step` (m) from rest, stay
  // until the plant has settled, and come back, with the noise of the
  // reference. Empty where Score() would find too little.
  absl::StatusOr<std::vector<Eigen::MatrixXd>> ExpectedInformation(
      const WatchReference& reference, const Eigen::VectorXd& step) const;

 private:
  ModelWatch() = default;

  // For each sample: whether it is around a change.
  absl::StatusOr<std::vector<bool>> AroundChanges(const Record& record) const;
  absl::StatusOr<std::vector<WatchBatch>> Examined(
      const std::vector<WatchBatch>& batches) const;
  absl::StatusOr<std::vector<Record>> AtRest(
      const std::vector<WatchBatch>& batches) const;
  std::string OutOfRange(const WatchReference& reference,
                         const WatchBatch& batch) const;
  absl::StatusOr<std::string> RecordChange(const WatchReference& reference,
                                           const Record& record) const;
  // `changes`: of each sample, the number of the change it is around.
  BatchOutput ScoreOutput(const OutputReference& reference,
                          const Record& record, const std::vector<int>& changes,
                          int output) const;

  ProcessModel model_;
  WatchOptions options_;
  double sample_time_ = 0.0;
  std::shared_ptr<const std::vector<RowResponse>> rows_;  // p
  // In samples.
  int skip_ = 0;    // in which former inputs act
  int before_ = 0;  // used before a change, and after it
  int after_ = 0;
};

}  // namespace mle

#endif  // MLE_MONITOR_MODEL_WATCH_H_
