// A campaign: runs of the experiment over a grid of seeds, plants, mismatches,
// noise, controllers, set-point changes and ways to estimate (docs/studies.md,
// docs/formats.md).
//
//   run = (scenario, method, seed),
//   scenario = (model, noise, drift, controller, windows, mismatch),
//   method = (estimator, selection rule, solver).
//
// Every axis of the grid is a list; the campaign is their product. All runs of
// a seed see the same draws of noise.

#ifndef APPS_STUDY_CAMPAIGN_H_
#define APPS_STUDY_CAMPAIGN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/correction/selection.h"
#include "mle/model/process_model.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"
#include "nlohmann/json_fwd.hpp"

namespace mle::study {

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
  // Of the matrix of static gains, ≥ 1: draws above it are drawn again.
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

struct ControllerSpec {
  std::string name;
  double control_period = 1.0;
  int prediction_horizon = 30;
  int control_horizon = 5;
  std::vector<double> output_weight = {0.2};  // one, or one for each output
  std::vector<double> move_weight = {0.1};    // one, or one for each input
  double disturbance_variance_ratio = 0.1;
};

// The set-point changes and what is kept of them. With `changes` = 0 as in the
// paper: a run for each output e, whose set point steps at `step_time`, those
// before it standing at `setpoint_step` throughout. Else one run of so many
// changes, `spacing` apart, of one output after the other, each from 0 to
// `setpoint_step` and back in turn; then `duration` and `step_time` are not
// used: the first change comes after `window`.
struct WindowSpec {
  std::string name;
  double duration = 1000.0;
  double step_time = 500.0;
  double setpoint_step = 1.0;
  double window = 200.0;  // kept before and after each change
  int changes = 0;
  double spacing = 400.0;  // ≥ 2 window
};

enum class Estimator {
  kNone,        // the model stays as it is
  kArx,         // ΔR
  kArxTested,   // ΔR if a test finds the model wrong
  kStructured,  // gains, time scales, dead times
  kCombined,    // structured, then ΔR where that is not enough
};
const char* NameOf(Estimator estimator);
// Whether it chooses a λ, so that selection rules and solvers make a
// difference.
bool UsesLambda(Estimator estimator);

struct SelectionSpec {
  std::string name;
  SelectionOptions options;
};

struct SolverSpec {
  std::string name;
  LassoSolverOptions options;
  bool exact = true;  // its gap certifies the optimum
};

// One way to estimate; indices into the campaign's lists, −1 where none.
struct Method {
  Estimator estimator = Estimator::kArx;
  int selection = -1;
  int solver = -1;
};

struct Campaign {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<ModelSpec> models;
  std::vector<double> noise_variances;
  std::vector<double> drift_variances;
  std::vector<ControllerSpec> controllers;
  std::vector<WindowSpec> windows;
  std::vector<Mismatch> mismatches;
  std::vector<SelectionSpec> selections;
  std::vector<SolverSpec> solvers;
  std::vector<Method> methods;

  double sample_time = 0.2;
  int order = 150;
  double response_horizon = 100.0;
  Eigen::VectorXd lambdas;
  Scaling scaling = Scaling::kStandardise;
  double conversion_duration = 10000.0;
  double conversion_penalty = 1e-6;
  // Of the conversion; the plant's where there is none.
  std::optional<double> conversion_noise_variance;
};

// The campaign's text with every file it names read in: it needs no other file
// from here on, and its SHA-256 stands for all of them. `source` names the file
// in errors; relative names start in `folder`.
absl::StatusOr<std::string> ResolveCampaign(std::string_view text,
                                            const std::string& source,
                                            const std::string& folder);

// What ResolveCampaign() gave. Everything that can be known before a run is
// checked; errors name the JSON path.
absl::StatusOr<Campaign> ParseCampaign(std::string_view resolved,
                                       const std::string& source);

}  // namespace mle::study

#endif  // APPS_STUDY_CAMPAIGN_H_
