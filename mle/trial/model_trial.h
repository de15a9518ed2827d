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
// are correlated, and a wrong model can have the smaller loss. Set points answer
// nothing: with z, what set points drive of x,
//
//   D = zᵀW (e⁰ + e¹)/2,
//
// is linear in the disturbance, which z does not depend on; where the true
// change is a x, its mean is (a − ½) zᵀW z: half of the difference of the losses
// in what set points drive. z comes from the rows before this response: x is
// regressed on shapes of set points (set_point_shapes.h). Each change of a set
// point, with what follows it until the plant has settled, gives one D of each
// output whose model would change, and
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
//          of the responses in which it leaves most), but for a standard error;
//   drop   where E against it ≥ 1/α, or after most_changes;
//   wait   otherwise.
//
// After the proposed model was adopted the same goes on with the models
// exchanged and evidence from zero: the advice is to roll back where E for the
// former model ≥ 1/α, whatever it leaves, and to keep the new one otherwise.
//
// The level rests on this: the plant is linear, disturbances do not come with
// set points and are independent from response to response, and D has no heavier
// tails than trial_evidence.h allows. Noise is that of rows at rest, a settling
// time and more after the last change; where set points never rest, that of all
// rows, in which errors of the models count as noise. A record's first settling
// time is used up by what inputs did before.
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

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/trial/change_window.h"
#include "mle/trial/trial_options.h"
#include "mle/trial/trial_rows.h"

namespace mle {

// A response to a change of set points, or to several that came in it.
struct TrialResponse {
  double time = 0.0;  // of its end
  int changes = 1;    // of set points
  // Of each output whose model changes: D, zᵀWz, σ(D); what set points drive of
  // the residuals of the model in use and of the proposed one.
  std::vector<double> gains = {};
  std::vector<double> sizes = {};
  std::vector<double> deviations = {};
  std::vector<double> in_use = {};
  std::vector<double> proposed = {};
  int shapes = 0;  // of set points, in all outputs that are judged

  // Whether there was noise at rest to compare it with, and z.
  bool judged() const;
  double difference() const;  // X; 0 where it is not judged
  double size() const;        // Σ zᵀWz / Σ σ(D)
  bool operator==(const TrialResponse&) const = default;
};

// Squares of e_k − e_{k−h} of an output over each horizon, summed.
struct StepLosses {
  std::vector<double> in_use = {};
  std::vector<double> proposed = {};
  std::vector<double> counts = {};
};

// All that a trial remembers; the models and options apart.
struct TrialState {
  static constexpr std::int64_t kLongAgo = -1'000'000'000;

  bool adopted = false;
  // Of the end of the last row, in the unit of the records; and rows since the
  // last gap.
  double end = 0.0;
  std::int64_t rows = 0;
  std::int64_t last_move = kLongAgo;  // row
  std::int64_t response = kLongAgo;   // row that the present one began with
  int changes = 0;              // of set points in it
  // The last rows (newest last): shapes (q × n), x, e⁰ and e¹ (r × n).
  Eigen::MatrixXd shapes;
  Eigen::MatrixXd differences;
  Eigen::MatrixXd in_use;
  Eigen::MatrixXd proposed;
  // The regression of x on shapes: q × q and q × r.
  Eigen::MatrixXd normal;
  Eigen::MatrixXd moments;
  // r each.
  std::vector<Variogram> noise;   // at rest
  std::vector<Variogram> always;  // of all rows
  std::vector<StepLosses> losses;
  // Those of the trial, and since the adoption.
  std::vector<TrialResponse> before;
  std::vector<TrialResponse> responses;
};

enum class TrialAdvice { kWait, kAdopt, kDrop, kKeep, kRollBack };

// "wait", "adopt", "drop", "keep", "roll_back".
std::string_view NameOf(TrialAdvice advice);

// After a response.
struct TrialEvidencePoint {
  double time = 0.0;
  double log_for = 0.0;      // ln E for the proposed model
  double log_against = 0.0;  // ln E against it
};

struct TrialVerdict {
  TrialAdvice advice = TrialAdvice::kWait;
  std::vector<TrialEvidencePoint> evidence;
  int changes = 0;     // of set points with their whole response
  int responses = 0;   // that they are
  int not_judged = 0;  // of these
  // The share of what set points drive of the residuals of the model in use
  // that the proposed one leaves, and its standard error by noise; 1 where they
  // drive nothing.
  double left_share = 1.0;
  double left_error = 0.0;
  // The root of the ratio of losses, proposed over in use, on all rows.
  double loss_ratio = 1.0;
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
  // set points, and the noise. InvalidArgument for a record of other channels or
  // sample time, or without set points.
  absl::Status Learn(const Record& record, int first = 0);
  // Operation in the trial, in order of time. Samples before `first` say what
  // inputs did; Lead() of them are of use.
  absl::Status Look(const Record& record, int first = 0);
  // The proposed model is in use from here on.
  void Adopt();

  TrialVerdict verdict() const;
  const TrialState& state() const { return state_; }
  int Lead() const { return plan_.forgetting; }
  // Outputs whose model changes (r).
  const std::vector<int>& outputs() const { return models_.outputs; }

 private:
  ModelTrial() = default;
  absl::Status Use(const Record& record, int first, bool judge);
  void AddRow(const TrialRows& rows, Eigen::Index k, bool judge);
  void AddNoise();
  void AddLosses();
  void EndResponse(bool judge);
  TrialAdvice Advise(const TrialVerdict& verdict) const;
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
