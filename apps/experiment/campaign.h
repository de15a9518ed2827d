// A campaign: runs of the experiment over a grid of seeds, plants, mismatches,
// noise, controllers, set-point changes and ways to estimate (docs/studies.md,
// docs/formats.md).
//
//   run = (scenario, method, seed),
//   scenario = (model, noise, ablation, drift, effects, controller, windows,
//               mismatch),
//   method = (estimator, selection rule, solver).
//
// Every axis of the grid is a list; the campaign is their product. All runs of
// a seed see the same draws of noise.

#ifndef APPS_EXPERIMENT_CAMPAIGN_H_
#define APPS_EXPERIMENT_CAMPAIGN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "apps/common/option_table.h"
#include "apps/experiment/options.h"
#include "control/mpc_options.h"
#include "mle/correction/selection.h"
#include "mle/maintain/estimation.h"
#include "mle/model/process_model.h"
#include "mle/regression/lasso_solver.h"
#include "sim/effects_json.h"

namespace mle::experiment {

// The experiment with one decision taken differently, to show what each is
// worth (docs/method.md): an axis of a campaign.

// One decision, by its name. `apply` changes options whose selection rule and
// solver are those of the method.
struct Ablation {
  const char* name;
  const char* what;  // in a few words
  void (*apply)(ExperimentOptions& options);
  bool left_open;  // the paper does not say how it was decided
};

absl::Span<const Ablation> Ablations();

// Null if there is none of that name.
const Ablation* FindAblation(const std::string& name);

// One way to estimate: an axis of a campaign.
//
// Its name is ESTIMATOR or ESTIMATOR:TEST, with the estimators and tests of no
// change of the library (mle/maintain/estimation.h), the library's own test
// where none is named; `ceres` is arx with ΔR solved by Ceres at the λ of the
// exact path, and `none` leaves the model as it is:
//
//   arx:none           the paper's method
//   arx:adequacy       the same, if the inputs explain part of the residuals
//   output_error:none  every element free
//   output_error       as of mle_correct, without its explanations

struct Method {
  // None: the model stays as it is.
  std::optional<Estimator> estimator;
  ChangeTest change_test = EstimationOptions().change_test;
  bool solve_by_ceres = false;
  // Indices into the campaign's lists, −1 where it chooses no λ.
  int selection = -1;
  int solver = -1;

  // Whether selection rules and solvers make a difference.
  bool UsesLambda() const {
    return estimator.has_value() && *estimator != Estimator::kOutputError;
  }
  std::string estimator_name() const;  // without the test
  std::string name() const;
};

// arx:none.
Method PaperMethod();

// InvalidArgument lists what is known.
absl::StatusOr<Method> ParseMethod(std::string_view name);

struct Interval {
  double from = 0.0;
  double to = 0.0;
};

// Plants of first-order elements with dead time, one for each seed, named
// y1 … yp and u1 … um. Gains have either sign and are drawn uniformly in the
// logarithm of their size, time constants and dead times uniformly.
struct RandomPlants {
  int outputs = 2;
  int inputs = 2;
  Interval gain = {1.0, 20.0};           // > 0
  Interval time_constant = {5.0, 20.0};  // > 0
  Interval delay = {0.0, 8.0};           // ≥ 0
  // Largest condition number of the static gains, ≥ 1: others are drawn again.
  double max_condition_number = 20.0;
  // And draws whose loop, with the model true, is unstable or has a larger peak
  // of sensitivity (loop_analysis.h), > 1.
  double max_sensitivity = 2.0;
};

// The model that the controller believes.
struct ModelSpec {
  std::string name;
  ProcessModel model;  // unless `random`
  std::optional<RandomPlants> random;
};

// Elements that have aged: those of `output` and `input` ("*": any) that are
// not zero, or `elements` > 0 of them, drawn. Values are drawn for each element
// and seed, uniformly, factors in the logarithm; from = to is no draw.
struct Change {
  std::string output = "*";
  std::string input = "*";
  int elements = 0;
  Interval gain_factor = {1.0, 1.0};           // > 0
  Interval time_constant_factor = {1.0, 1.0};  // > 0
  Interval delay_shift = {0.0, 0.0};
};

// How the plant differs from the model: as another model, or by changes of
// size s: factors are taken to the power s, shifts times s. Neither: not at
// all.
struct Mismatch {
  std::string name;
  double size = 1.0;
  std::optional<ProcessModel> plant;
  std::vector<Change> changes;
};

// A controller's tuning. A weight of 1 × 1 is that of every channel.
struct ControllerSpec {
  ControllerSpec();  // the paper's

  // For so many channels. InvalidArgument if the numbers of weights do not fit.
  absl::StatusOr<control::MpcOptions> For(int outputs, int inputs) const;

  std::string name;
  control::MpcOptions mpc;
};

// The effects of a plant and its historian on records (sim/effects_json.h).
// Times count from the begin of each run.
struct EffectsSpec {
  std::string name = "none";
  // Those of each of the campaign's models; empty: none.
  std::vector<sim::Effects> of_models;
};

struct SelectionSpec {
  std::string name;
  SelectionOptions options;
};

struct SolverSpec {
  std::string name;
  LassoSolverOptions options;
  bool exact = true;  // its gap certifies the optimum
};

struct Campaign {
  Campaign();  // the paper's: one controller, its windows, no drift, ΔR

  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<ModelSpec> models;
  std::vector<double> noise_variances = {0.001};
  std::vector<double> drift_variances = {0.0};
  std::vector<const Ablation*> ablations = {nullptr};  // null: none
  std::vector<EffectsSpec> effects = {EffectsSpec()};
  std::vector<ControllerSpec> controllers;
  std::vector<WindowSpec> windows;
  std::vector<Mismatch> mismatches;
  std::vector<SelectionSpec> selections;
  std::vector<SolverSpec> solvers;
  std::vector<Method> methods;

  // The options that all runs share. Controller, noise, drift, windows,
  // selection and solver are taken from the lists instead.
  ExperimentOptions settings;
};

// Adds a method, with every solver and selection rule of the campaign where it
// uses them.
void AddMethods(Method method, Campaign& campaign);

// The rules for λ, blocks and paper first, and the solvers, by the names that
// campaigns and mle_reproduce have for them.
const std::vector<SelectionSpec>& NamedSelections();
const std::vector<SolverSpec>& NamedSolvers();

// One scenario of the grid; indices into the campaign's lists.
struct Scenario {
  int model = 0;
  int noise = 0;
  int ablation = 0;
  int drift = 0;
  int effects = 0;
  int controller = 0;
  int windows = 0;
  int mismatch = 0;

  bool operator==(const Scenario&) const = default;
};

// For a model of so many channels, before its ablation. InvalidArgument if
// weights do not fit.
absl::StatusOr<ExperimentOptions> OptionsOf(const Campaign& campaign,
                                            const Scenario& scenario,
                                            int outputs, int inputs);

// The channels of plants drawn at random.
ProcessModel ChannelsOf(const RandomPlants& plants);

// Checks before anything is run that the options of every model, controller and
// windows fit together.
absl::Status CheckScenarios(const Campaign& campaign);

// The options of the experiment: flags of mle_reproduce and keys of campaigns
// (docs/formats.md), which are called the same. The fields must outlive the
// options.

// Sample time, order, response horizon and scaling.
std::vector<Option> OptionsOf(ExperimentOptions& settings);
// Duration, penalty and noise variance of the conversion.
std::vector<Option> ConversionOptionsOf(ExperimentOptions& settings);
std::vector<Option> OptionsOf(WindowSpec& windows);
std::vector<Option> OptionsOf(SelectionSpec& selection);
std::vector<Option> OptionsOf(RandomPlants& plants);
std::vector<Option> OptionsOf(Change& change);

// `count` ≥ 1 seeds from `first` on: --seeds and --first_seed.
absl::StatusOr<std::vector<std::uint64_t>> ConsecutiveSeeds(std::uint64_t first,
                                                            int count);

// A rule for λ, or a solver, and its name.
TextValue RuleOf(SelectionSpec* selection);
TextValue SolverOf(SolverSpec* solver);

// The options with `prefix` before their names.
std::vector<Option> Prefixed(const std::string& prefix,
                             std::vector<Option> options);

// The plants of a campaign: models drawn at random, and models that have aged.

// The plant of a seed: the first draw that is within the bounds for every
// controller. FailedPrecondition if there is none among a thousand.
absl::StatusOr<ProcessModel> DrawModel(
    const RandomPlants& plants, std::uint64_t seed,
    const std::vector<ControllerSpec>& controllers);

// Whether the changes are possible for every draw: the elements are there, and
// no dead time can fall below zero.
absl::Status CheckAgeing(const ProcessModel& model, const Mismatch& mismatch);

// The plant under a mismatch; what is drawn belongs to the seed.
// InvalidArgument where a change is not possible.
absl::StatusOr<ProcessModel> AgeModel(const ProcessModel& model,
                                      const Mismatch& mismatch,
                                      std::uint64_t seed);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_CAMPAIGN_H_
