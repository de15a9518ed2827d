// A trial: a proposed model runs in the shadow of the model in use on all
// records that come, until it is known which of them is better.
//
// With the residuals e⁰ = y − M⁰u of the model in use, e¹ = y − M¹u of the
// proposed one and x = e⁰ − e¹ = (M¹ − M⁰)u, the losses of their predictions
// several steps ahead (change_window.h) differ by
//
//   L(e⁰) − L(e¹) = 2 xᵀW (e⁰ + e¹)/2.
//
// In closed loop inputs answer disturbances, so that x and the disturbance in e
// are correlated, and a wrong model can have the smaller loss. Set points
// answer nothing: with z, what set points drive of x,
//
//   D = zᵀW (e⁰ + e¹)/2,
//
// is linear in the disturbance, which z does not depend on; where the true
// change is a x, its mean is (a − ½) zᵀW z: half of the difference of the
// losses in what set points drive. z comes from the rows before this response:
// x is regressed on shapes of set points (set_point_shapes.h). Each change of a
// set point, with what follows it until the plant has settled, gives one D of
// each output whose model would change, and
//
//   X = Σ D / Σ σ(D),   σ²(D) = zᵀW z
//
// over these outputs, σ larger for a short rest before, and where the response
// shows more noise than the rest did. The evidence for the proposed model is
// that of X (trial_evidence.h), against it the mean of that of −X and those of
// the outputs alone:
//
//   adopt  where E for it ≥ 1/α, and it leaves at most κ of what set points
//          drive of e⁰ (what shapes of set points explain, without the eighth
//          of the responses in which it leaves most), but for a standard error
//          (of 2 κ at most), also in the records that it was made from, where
//          more set points may have moved;
//   drop   where E against it ≥ 1/α, or after most_changes;
//   wait   otherwise.
//
// After the proposed model was adopted the same goes on with the models
// exchanged and evidence from zero: the advice is to roll back where E for the
// former model ≥ 1/α, whatever it leaves, and to keep the new one otherwise.
//
// In records without set points the inputs stand for them, where operators move
// them by hand: these must not answer the outputs.
//
// The level rests on this: the plant is linear, disturbances do not come with
// set points and are independent from response to response, and D has no
// heavier tails than trial_evidence.h allows. Noise is that of rows at rest, a
// settling time and more after the last change; where set points never rest,
// that of all rows, in which errors of the models count as noise. A record's
// first settling time is used up by what inputs did before.
//
//   MLE_ASSIGN_OR_RETURN(ModelTrial trial,
//                        ModelTrial::Create(in_use, proposed, 1.0, {}));
//   trial.Learn(records_of_the_correction);
//   for (const Record& day : days) {
//     trial.Look(day);
//     if (trial.verdict().advice == TrialAdvice::kAdopt) …
//   }

#ifndef MLE_TRIAL_MODEL_TRIAL_H_
#define MLE_TRIAL_MODEL_TRIAL_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/trial/trial_state.h"
#include "mle/trial/trial_verdict.h"

namespace mle {

struct TrialRows;  // trial_rows.h

// How far the step responses of two models of the same channels differ over the
// longer of their settling times (p × m): ResponseDistance::elements of
// mle/maintain/correct.h.
Eigen::MatrixXd CompareElements(const ProcessModel& from,
                                const ProcessModel& to);

// Two models of the outputs that differ, r of p.
struct TrialModels {
  ProcessModel in_use;
  ProcessModel proposed;
  std::vector<int> outputs;
  std::vector<int> inputs;  // that move these outputs
};

// The rows of several samples that a trial works on (trial_rows.h).
struct RowPlan {
  int samples = 1;     // of a row
  int forgetting = 0;  // samples in which former inputs act
  double pole = 0.5;   // of the shapes, for each row
};

class ModelTrial {
 public:
  // InvalidArgument for options, models that differ in channels or not at all,
  // outputs that integrate and would change, and a sample time that is not > 0
  // or does not fit the models.
  static absl::StatusOr<ModelTrial> Create(const ProcessModel& in_use,
                                           const ProcessModel& proposed,
                                           double sample_time,
                                           const TrialOptions& options);
  // With the state of a trial of the same models. DataLoss where its sizes are
  // others.
  static absl::StatusOr<ModelTrial> Resume(const ProcessModel& in_use,
                                           const ProcessModel& proposed,
                                           double sample_time,
                                           const TrialOptions& options,
                                           TrialState state);

  // Operation before the trial, from sample `first` on: how the loop answers
  // set points, and the noise. InvalidArgument for a record of other channels
  // or sample time.
  absl::Status Learn(const Record& record, int first = 0);
  // Operation in the trial, in order of time. Samples before `first` say what
  // inputs did; Lead() of them are of use.
  absl::Status Look(const Record& record, int first = 0);
  // The proposed model is in use from here on.
  void Adopt();

  TrialVerdict verdict() const { return JudgeTrial(state_, options_); }
  const TrialState& state() const { return state_; }
  int Lead() const { return plan_.forgetting; }

 private:
  ModelTrial() = default;
  void PlanRows(double settling);
  // After a gap, or at the begin.
  void BeginAnew(const TrialRows& rows);
  absl::Status Use(const Record& record, int first, bool judge);
  void AddRow(const TrialRows& rows, Eigen::Index k, bool judge);
  void AddNoise();
  void AddLosses();
  void EndResponse(bool judge);
  // The evidence of the last response in rows [begin, end of the buffer).
  TrialResponse Compare(Eigen::Index begin, Eigen::Index length) const;
  // Of a column of the last rows.
  void LearnFrom(Eigen::Index column);

  TrialModels models_;
  int num_outputs_ = 0;
  double sample_time_ = 0.0;
  TrialOptions options_;
  RowPlan plan_;
  int before_ = 0;  // rows of a response before the change, and after it
  int after_ = 0;
  std::vector<int> horizons_;  // rows
  TrialState state_;
};

}  // namespace mle

#endif  // MLE_TRIAL_MODEL_TRIAL_H_
