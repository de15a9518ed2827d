// One scenario of a campaign with one seed: its plant, its records, and what
// each estimator makes of them, held against the plant. What estimators have in
// common is computed once.
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::unique_ptr<Experiment> experiment,
//       Experiment::Create(campaign, scenario, seed, initial, conversion));
//   MLE_ASSIGN_OR_RETURN(const Evaluation evaluation, experiment->Run(method));

#ifndef APPS_EXPERIMENT_EXPERIMENT_H_
#define APPS_EXPERIMENT_EXPERIMENT_H_

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/options.h"
#include "control/mpc.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/correction/judgement.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/maintain/shared_fits.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "sim/set_point_profile.h"

namespace mle::experiment {

// The closed loop that leaves records around its set-point changes.

// The set points of the run in which that of `output` steps (WindowSpec without
// `changes`).
sim::SetPointProfile StepOf(int output, const WindowSpec& windows);

// The plant under `mpc`, for the duration of a run, with options.effects beside
// the conditions. Noise is that of the seed's `stream`, of this variance.
absl::StatusOr<Record> SimulateLoop(control::Mpc mpc, const ProcessModel& plant,
                                    const sim::SetPointProfile& set_points,
                                    double noise_variance, std::uint64_t seed,
                                    std::uint64_t stream,
                                    const sim::PlantConditions& conditions,
                                    const ExperimentOptions& options);

// E of ΔR for the whole model, with one λ for all outputs, which only a
// simulation can know: at the best λ of the grid, and at the smallest.
struct Hindsight {
  double best_lambda = 0.0;
  double best_E = 0.0;
  double zero_E = 0.0;
};

// The result of a method on the records. Pointers belong to the experiment.
struct Evaluation {
  StepResponse response;  // of the model estimated
  Judgement judgement;    // against the plant's
  // None where the model stays as it is.
  std::optional<Estimate> estimate;
  // By the method's test; always without one.
  bool change_proposed = false;
  std::optional<double> p_value;  // of the initial model being right
  Eigen::VectorXd lambda;         // of ΔR where there is one, p
  double max_relative_gap = std::numeric_limits<double>::quiet_NaN();
  const Hindsight* hindsight = nullptr;  // of ΔR of the whole model
  double seconds = 0.0;                  // EstimateFit::seconds

  double E() const { return judgement.squared_distance; }
};

class Experiment {
 public:
  // The arguments must outlive the object. `conversion`: R of the initial
  // model, which not every estimator needs, for all scenarios of a unit
  // (grid.h).
  static absl::StatusOr<std::unique_ptr<Experiment>> Create(
      const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
      const ProcessModel& initial, Shared<ConversionSummary>& conversion);

  absl::StatusOr<Evaluation> Run(const Method& method);

  std::uint64_t seed() const { return seed_; }
  const ProcessModel& initial() const { return initial_; }
  const ProcessModel& plant() const { return plant_; }
  // With the ablation; selection and solver are those of no method.
  const ExperimentOptions& options() const { return options_; }
  const std::vector<Record>& windows() const { return windows_; }
  const StepResponse& truth() const { return truth_; }
  StepResponse InitialResponse() const;
  // The plant's own responses, judged.
  const Judgement& truth_judged() const { return truth_judged_; }
  // The information bound of E: what no unbiased estimate can beat on average
  // that knows the structure and the noise. 0 where there is no noise, or the
  // plant cannot be fitted.
  double Limit();

 private:
  Experiment(const Campaign& campaign, const Scenario& scenario,
             std::uint64_t seed, const ProcessModel& initial,
             Shared<ConversionSummary>& conversion)
      : campaign_(campaign),
        scenario_(scenario),
        seed_(seed),
        initial_(initial),
        conversion_(conversion) {}

  absl::Status RunEstimator(const Method& method, Evaluation& evaluation);
  EstimationOptions EstimationOf(const Method& method);
  const Hindsight& HindsightOf(int solver, const Correction& correction);
  double ComputeLimit() const;

  const Campaign& campaign_;
  const Scenario scenario_;
  const std::uint64_t seed_;
  const ProcessModel& initial_;
  Shared<ConversionSummary>& conversion_;
  ExperimentOptions base_;     // without the ablation
  ExperimentOptions options_;  // with it
  ProcessModel plant_;
  StepResponse truth_;
  Judgement truth_judged_;
  std::vector<Record> windows_;
  // By solver.
  std::map<int, SharedFits> fits_;
  std::map<int, Hindsight> hindsights_;
  std::optional<double> limit_;
};

// E(M, R̂_λ) over the penalty λ, and the λ that is best in hindsight: what only
// a simulation can know.

// E, infinite for an unstable model whose response leaves the range of numbers.
double DistanceOrInfinity(const StepResponse& truth,
                          const StepResponse& response);

class DistanceCurve {
 public:
  // All three must outlive the curve; `lambdas` ascend.
  DistanceCurve(const Correction& correction, const Eigen::VectorXd& lambdas,
                const StepResponse& truth);

  // At λ of the grid, by number, one for all outputs.
  double operator()(Eigen::Index i);
  // At every λ of the grid.
  Eigen::VectorXd Whole();
  // The number of the smallest E: among λ that grow by 1 %, then among all
  // between the best one's neighbours.
  Eigen::Index Best();

 private:
  const Correction& correction_;
  const Eigen::VectorXd& lambdas_;
  const StepResponse& truth_;
  ArxModel model_;
};

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_EXPERIMENT_H_
