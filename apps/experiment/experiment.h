// One scenario of a campaign with one seed: its plant, its records, and what
// each estimator makes of them, held against the plant. What estimators have in
// common is computed once.
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::unique_ptr<Experiment> experiment,
//       Experiment::Create(campaign, scenario, seed, initial, conversion));
//   MLE_ASSIGN_OR_RETURN(const Estimate estimate, experiment->Run(method));

#ifndef APPS_EXPERIMENT_EXPERIMENT_H_
#define APPS_EXPERIMENT_EXPERIMENT_H_

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/options.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/correction/judgement.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle::experiment {

// Seconds of processor time of this thread.
double ThreadSeconds();

// A result that is made when first asked for, and how long that took.
template <typename T>
class Shared {
 public:
  // Adds the time to `seconds`, whoever asked first.
  template <typename Make>
  absl::StatusOr<T*> Get(const Make& make, double& seconds) {
    if (!result_.has_value()) {
      const double start = ThreadSeconds();
      result_ = make();
      seconds_ = ThreadSeconds() - start;
    }
    seconds += seconds_;
    if (!result_->ok()) return result_->status();
    return &**result_;
  }

 private:
  std::optional<absl::StatusOr<T>> result_;
  double seconds_ = 0.0;
};

// R of the initial model, for all scenarios of a unit (grid.h): not every
// estimator needs it.
class SharedConversion {
 public:
  SharedConversion(const ProcessModel& initial, std::uint64_t seed)
      : initial_(initial), seed_(seed) {}

  absl::StatusOr<const ConversionSummary*> Get(
      const ExperimentOptions& options);

 private:
  const ProcessModel& initial_;
  const std::uint64_t seed_;
  Shared<ConversionSummary> conversion_;
};

// ΔR for every λ by one solver, with λ chosen by every rule asked for.
struct Path {
  double conversion_gap = 0.0;
  Correction correction;
  double correction_seconds = 0.0;
  Eigen::VectorXd lambdas;                     // the grid
  std::map<int, SelectionSummary> selections;  // by rule
  // In hindsight, one λ for all outputs: the best of the grid, and the
  // smallest.
  double best_lambda = 0.0;
  double best_E = 0.0;
  double zero_E = 0.0;
};

// What a method made of the records. Pointers belong to the experiment.
struct Estimate {
  StepResponse response;  // of the model estimated
  Judgement judgement;    // against the plant's
  // Of the test that guards the estimator; without one the model is changed.
  bool change_proposed = true;
  std::optional<double> p_value;  // of the initial model being right
  // Of ΔR, where the method has one, whether or not it is proposed.
  const Path* path = nullptr;
  Eigen::VectorXd lambda;  // chosen, p
  double max_relative_gap = std::numeric_limits<double>::quiet_NaN();
  // Of the estimators structured and combined.
  const StructuredCorrection* structured = nullptr;
  // Of processor time, tests included; the conversion of the initial model is
  // not.
  double seconds = 0.0;

  double E() const { return judgement.squared_distance; }
};

class Experiment {
 public:
  // What is given must outlive the object.
  static absl::StatusOr<std::unique_ptr<Experiment>> Create(
      const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
      const ProcessModel& initial, SharedConversion& conversion);

  absl::StatusOr<Estimate> Run(const Method& method);

  std::uint64_t seed() const { return seed_; }
  const ProcessModel& initial() const { return initial_; }
  const ProcessModel& plant() const { return plant_; }
  // With the ablation; selection and solver are those of no method.
  const ExperimentOptions& options() const { return options_; }
  const std::vector<Record>& windows() const { return windows_; }
  const StepResponse& truth() const { return truth_; }
  StepResponse InitialResponse() const;
  // Of the plant's own responses.
  const Judgement& truth_judged() const { return truth_judged_; }
  // The Cramér–Rao limit of E: what no unbiased estimate can beat on average
  // that knows the structure and the noise. 0 where there is no noise, or the
  // plant cannot be fitted.
  double Limit();

 private:
  Experiment(const Campaign& campaign, const Scenario& scenario,
             std::uint64_t seed, const ProcessModel& initial,
             SharedConversion& conversion)
      : campaign_(campaign),
        scenario_(scenario),
        seed_(seed),
        initial_(initial),
        conversion_(conversion) {}

  absl::Status Arx(const Method& method, Estimate& estimate);
  absl::Status Guard(Estimate& estimate);
  absl::Status Ceres(const Method& method, Estimate& estimate);
  absl::Status Structured(bool all_free, Estimate& estimate);
  absl::Status Combined(const Method& method, Estimate& estimate);
  absl::Status Dispatch(const Method& method, Estimate& estimate);
  absl::StatusOr<StructuredCorrection*> StructuredFitOf(double& seconds);
  absl::StatusOr<std::vector<Record>> WindowsOfArx();
  absl::StatusOr<Path> SolvePath(const Method& method);
  absl::StatusOr<Path*> PathOf(const Method& method);
  CorrectionOptions CorrectionOf(const Method& method) const;
  double ComputeLimit() const;

  const Campaign& campaign_;
  const Scenario scenario_;
  const std::uint64_t seed_;
  const ProcessModel& initial_;
  SharedConversion& conversion_;
  ExperimentOptions base_;     // without the ablation
  ExperimentOptions options_;  // with it
  ProcessModel plant_;
  StepResponse truth_;
  Judgement truth_judged_;
  std::vector<Record> windows_;
  std::map<int, Shared<Path>> paths_;  // by solver
  Shared<ModelAdequacy> adequacy_;
  Shared<StructuredCorrection> structured_;
  std::optional<double> limit_;
};

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_EXPERIMENT_H_
