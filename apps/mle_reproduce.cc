// mle_reproduce: the paper's experiments, or the same on another plant.

#include <cstdint>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/common/built_in_models.h"
#include "apps/common/command_line.h"
#include "apps/common/progress.h"
#include "apps/report/gnuplot.h"
#include "apps/report/number.h"
#include "apps/reproduce/experiment.h"
#include "apps/reproduce/figures.h"
#include "apps/reproduce/outputs.h"
#include "apps/reproduce/page.h"
#include "apps/reproduce/summary.h"
#include "gflags/gflags.h"
#include "mle/base/file.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

DEFINE_string(cases, "gain,delay",
              "Cases to run, of the Wood-Berry column: gain (both reflux gains "
              "halved), delay (both steam dead times 4 min longer).");
DEFINE_string(
    model, "",
    "Process model (JSON) that the controller believes; with --plants "
    "instead of --cases.");
DEFINE_string(
    plants, "",
    "NAME:FILE,… process models (JSON) of aged plants, a case each, of "
    "the same inputs and outputs as --model.");
DEFINE_int32(seeds, 1, "Noise seeds to run each case with, ≥ 1.");
DEFINE_uint64(first_seed, 1, "The first of the seeds; the others follow it.");
DEFINE_string(out, "results",
              "Folder for report.html, results.json, the curves and figures.");
DEFINE_bool(figures, true, "Draw the figures (needs gnuplot).");
DEFINE_int32(threads, 0,
             "Threads, 0: one for each processor. The results do not depend on "
             "it.");

DEFINE_double(
    sample_time, 0.2,
    "Sample time Δt of the ARX model, in the model's time unit (min).");
DEFINE_int32(order, 150, "Order d of the ARX model, in samples, ≥ 1.");
DEFINE_double(control_period, 1.0,
              "Control period Δt_c, a multiple of --sample_time (min).");
DEFINE_int32(prediction_horizon, 30,
             "Prediction horizon H_p, in control periods.");
DEFINE_int32(control_horizon, 5,
             "Control horizon H_c ≤ H_p, in control periods.");
DEFINE_string(output_weight, "0.2",
              "Weight Q_y on tracking errors, ≥ 0: one value, or one for each "
              "output, separated by commas.");
DEFINE_string(
    move_weight, "0.1",
    "Weight Q_u on input moves, ≥ 0: one value, or one for each input.");
DEFINE_double(disturbance_variance_ratio, 0.1,
              "Disturbance observer: increment variance of the output "
              "disturbance over the noise variance, ≥ 0.");
DEFINE_double(noise_variance, 0.001,
              "Variance σ² of the measurement noise of every output, ≥ 0.");
DEFINE_double(conversion_noise_variance, -1.0,
              "Variance of the noise under which the initial model is "
              "converted; 0 shows what goes wrong without it, negative takes "
              "--noise_variance.");
DEFINE_double(conversion_penalty, 1e-6, "Penalty λ₀ of the conversion, ≥ 0.");
DEFINE_double(conversion_duration, 10000.0,
              "Length of the excitation for the conversion (min).");
DEFINE_double(duration, 1000.0, "Length of each closed-loop run (min).");
DEFINE_double(step_time, 500.0, "Time of the set-point change in a run (min).");
DEFINE_double(setpoint_step, 1.0, "Size of the set-point changes.");
DEFINE_double(window, 200.0,
              "What is kept of a run before and after the change (min).");
DEFINE_double(response_horizon, 100.0,
              "Length NΔt of the step responses compared (min).");
DEFINE_double(lambda_grid_max, 1e-2, "Largest candidate for λ.");
DEFINE_double(lambda_grid_step, 1e-6,
              "Step between the candidates for λ, the first being 0.");
DEFINE_string(selection, "leave_change_out",
              "Rule for λ: leave_change_out (folds are set-point changes, the "
              "paper's) or blocks (folds are dealt blocks of every change).");
DEFINE_int32(selection_folds, 5, "Folds of --selection=blocks, ≥ 2.");
DEFINE_double(selection_block, 60.0,
              "Length of a block of --selection=blocks (min).");
DEFINE_string(solver, "homotopy",
              "Lasso solver: homotopy (exact) or coordinate_descent (slow).");
DEFINE_string(scaling, "standardise",
              "standardise (centre, unit variance, as MATLAB's lasso) or raw.");

namespace mle {
namespace {

constexpr char kUsage[] =
    "Corrects a process model from closed-loop records around set-point "
    "changes "
    "alone, in\nsimulation, where the true plant is known and the correction "
    "can "
    "be judged.\n\n"
    "  mle_reproduce --cases=gain,delay --seeds=20 --out=results\n"
    "  mle_reproduce --model=column.json --plants=aged:column_aged.json\n\n"
    "Times are in the model's time unit. Exit codes: 0 done, 1 ran but the "
    "result is not\nusable, 2 bad input or flags.";

struct Case {
  std::string name;
  ProcessModel plant;
};

struct Inputs {
  ProcessModel initial;
  std::vector<Case> cases;
  reproduce::ExperimentOptions experiment;
};

bool IsGiven(const char* flag) {
  return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default;
}

// Names go into names of files.
absl::Status CheckName(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 100 &&
                     name.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_-") == std::string::npos;
  if (plain) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "--plants: the name '", name,
      "' must be made of letters, digits, '_' and '-', at most 100"));
}

absl::StatusOr<std::vector<Case>> ReadPlants(const ProcessModel& initial) {
  std::vector<Case> cases;
  for (const std::string& part : ParseList(FLAGS_plants)) {
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) {
      return absl::InvalidArgumentError(
          absl::StrCat("--plants: '", part, "' is not of the form NAME:FILE"));
    }
    const std::string name = part.substr(0, colon);
    const std::string file = part.substr(colon + 1);
    MLE_RETURN_IF_ERROR(CheckName(name));
    MLE_ASSIGN_OR_RETURN(ProcessModel plant, ReadProcessModel(file));
    MLE_RETURN_IF_ERROR(CheckSameChannels(initial, FLAGS_model, plant, file));
    cases.push_back({name, std::move(plant)});
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--plants names no plant");
  }
  return cases;
}

absl::StatusOr<std::vector<Case>> BuiltInCases() {
  std::vector<Case> cases;
  for (const std::string& name : ParseList(FLAGS_cases)) {
    const BuiltInModel* found = nullptr;
    for (const BuiltInModel& model : kWoodBerryAged) {
      if (model.name == name) found = &model;
    }
    if (found == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--cases: there is no case '", name,
          "'; known are gain and delay, others run with --model and --plants"));
    }
    MLE_ASSIGN_OR_RETURN(ProcessModel plant,
                         ParseProcessModel(found->json, found->source));
    cases.push_back({name, std::move(plant)});
  }
  if (cases.empty()) {
    return absl::InvalidArgumentError("--cases names no case");
  }
  return cases;
}

absl::StatusOr<reproduce::ExperimentOptions> ExperimentFromFlags(
    const ProcessModel& initial) {
  reproduce::ExperimentOptions options;
  options.sample_time = FLAGS_sample_time;
  options.control_period = FLAGS_control_period;
  options.prediction_horizon = FLAGS_prediction_horizon;
  options.control_horizon = FLAGS_control_horizon;
  MLE_ASSIGN_OR_RETURN(options.output_weight,
                       ParseNumbers("output_weight", FLAGS_output_weight,
                                    initial.num_outputs()));
  MLE_ASSIGN_OR_RETURN(
      options.move_weight,
      ParseNumbers("move_weight", FLAGS_move_weight, initial.num_inputs()));
  options.disturbance_variance_ratio = FLAGS_disturbance_variance_ratio;
  options.noise_variance = FLAGS_noise_variance;
  options.duration = FLAGS_duration;
  options.step_time = FLAGS_step_time;
  options.setpoint_step = FLAGS_setpoint_step;
  options.window = FLAGS_window;
  options.conversion_duration = FLAGS_conversion_duration;
  options.conversion_noise_variance = FLAGS_conversion_noise_variance < 0.0
                                          ? FLAGS_noise_variance
                                          : FLAGS_conversion_noise_variance;
  options.conversion.order = FLAGS_order;
  options.conversion.penalty = FLAGS_conversion_penalty;
  options.response_horizon = FLAGS_response_horizon;
  MLE_ASSIGN_OR_RETURN(
      options.correction.lambdas,
      MakeLambdaGrid(FLAGS_lambda_grid_max, FLAGS_lambda_grid_step));

  SelectionOptions& selection = options.correction.selection;
  if (FLAGS_selection == "blocks") {
    selection.rule = SelectionOptions::Rule::kBlocks;
  } else if (FLAGS_selection != "leave_change_out") {
    return absl::InvalidArgumentError(
        absl::StrCat("--selection=", FLAGS_selection,
                     ": known are leave_change_out and blocks"));
  }
  selection.folds = FLAGS_selection_folds;
  selection.block_length = static_cast<int>(
      std::clamp(FLAGS_selection_block / FLAGS_sample_time, 0.0, 1e9));

  LassoSolverOptions solver;
  if (FLAGS_solver == "coordinate_descent") {
    solver.solver = LassoSolver::kCoordinateDescent;
  } else if (FLAGS_solver != "homotopy") {
    return absl::InvalidArgumentError(
        absl::StrCat("--solver=", FLAGS_solver,
                     ": known are homotopy and coordinate_descent"));
  }
  Scaling scaling = Scaling::kStandardise;
  if (FLAGS_scaling == "raw") {
    scaling = Scaling::kRaw;
  } else if (FLAGS_scaling != "standardise") {
    return absl::InvalidArgumentError(absl::StrCat(
        "--scaling=", FLAGS_scaling, ": known are standardise and raw"));
  }
  options.conversion.solver = options.correction.solver = solver;
  options.conversion.scaling = options.correction.scaling = scaling;
  MLE_RETURN_IF_ERROR(options.Validate(initial));
  return options;
}

absl::StatusOr<Inputs> ReadInputs() {
  if (FLAGS_seeds < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("--seeds=", FLAGS_seeds, ": at least 1 is needed"));
  }
  if (FLAGS_threads < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--threads=", FLAGS_threads, ": 0 (all processors) or more"));
  }
  const bool own = !FLAGS_model.empty() || !FLAGS_plants.empty();
  if (own && (FLAGS_model.empty() || FLAGS_plants.empty())) {
    return absl::InvalidArgumentError(
        "--model and --plants belong together: the model the controller "
        "believes, and the plants as they are");
  }
  if (own && IsGiven("cases")) {
    return absl::InvalidArgumentError(
        "--cases stands for plants of the Wood-Berry column; give either "
        "--cases or --model with --plants");
  }
  Inputs inputs;
  if (own) {
    MLE_ASSIGN_OR_RETURN(inputs.initial, ReadProcessModel(FLAGS_model));
    MLE_ASSIGN_OR_RETURN(inputs.cases, ReadPlants(inputs.initial));
  } else {
    MLE_ASSIGN_OR_RETURN(inputs.initial,
                         ParseProcessModel(kWoodBerry.json, kWoodBerry.source));
    MLE_ASSIGN_OR_RETURN(inputs.cases, BuiltInCases());
  }
  std::set<std::string> names;
  for (const Case& one : inputs.cases) {
    if (!names.insert(one.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("the case '", one.name, "' is named twice"));
    }
  }
  MLE_ASSIGN_OR_RETURN(inputs.experiment, ExperimentFromFlags(inputs.initial));
  return inputs;
}

// Runs every case with every seed. A conversion serves all cases of its seed.
absl::StatusOr<std::vector<reproduce::CaseResult>> RunAll(
    const Inputs& inputs) {
  const int seeds = FLAGS_seeds;
  const int cases = static_cast<int>(inputs.cases.size());
  std::vector<absl::StatusOr<ConversionSummary>> conversions(
      seeds, absl::InternalError("not run"));
  std::vector<absl::StatusOr<reproduce::RunResult>> runs(
      static_cast<std::size_t>(seeds) * cases, absl::InternalError("not run"));
  const auto seed_of = [](int number) {
    return FLAGS_first_seed + static_cast<std::uint64_t>(number);
  };
  Progress converting("conversions", seeds);
  ParallelFor(seeds, FLAGS_threads, [&](int s) {
    conversions[s] = reproduce::ConvertInitialModel(inputs.initial, seed_of(s),
                                                    inputs.experiment);
    converting.Done();
  });
  for (const auto& conversion : conversions) {
    MLE_RETURN_IF_ERROR(conversion.status());
  }
  Progress running("runs", seeds * cases);
  ParallelFor(seeds * cases, FLAGS_threads, [&](int i) {
    const int s = i / cases;
    runs[i] = reproduce::RunExperiment(
        inputs.initial, inputs.cases[i % cases].plant, *conversions[s],
        seed_of(s), inputs.experiment);
    // The curves of all seeds would fill the memory; figures show the first.
    if (s > 0 && runs[i].ok()) {
      runs[i]->squared_distance.resize(0);
      runs[i]->selection.loss.resize(0);
      runs[i]->selection.penalised_loss.resize(0);
    }
    running.Done();
  });

  std::vector<reproduce::CaseResult> results;
  for (int c = 0; c < cases; ++c) {
    reproduce::CaseResult& result = results.emplace_back();
    result.name = inputs.cases[c].name;
    result.plant = inputs.cases[c].plant;
    const int samples = inputs.experiment.response_samples();
    result.truth = result.plant.ComputeStepResponse(FLAGS_sample_time, samples);
    result.initial =
        inputs.initial.ComputeStepResponse(FLAGS_sample_time, samples);
    result.E_initial = SquaredDistance(result.truth, result.initial);
    for (int s = 0; s < seeds; ++s) {
      absl::StatusOr<reproduce::RunResult>& run = runs[s * cases + c];
      if (!run.ok()) {
        return absl::Status(
            run.status().code(),
            absl::StrCat("case ", result.name, ", seed ", seed_of(s), ": ",
                         run.status().message()));
      }
      result.runs.push_back(*std::move(run));
    }
    MLE_RETURN_IF_ERROR(reproduce::SummariseCase(inputs.initial, result));
  }
  return results;
}

report::RunAgain HowToRunAgain() {
  report::RunAgain again;
  again.command = CommandLine();
  again.version = std::string(Version());
  again.seeds = FLAGS_seeds == 1
                    ? absl::StrCat(FLAGS_first_seed)
                    : absl::StrCat(FLAGS_first_seed, " … ",
                                   FLAGS_first_seed + FLAGS_seeds - 1);
  std::vector<gflags::CommandLineFlagInfo> flags;
  gflags::GetAllFlags(&flags);
  for (const gflags::CommandLineFlagInfo& flag : flags) {
    if (flag.filename.find("mle_reproduce") != std::string::npos &&
        flag.name != "out" && flag.name != "threads") {
      again.more.emplace_back(absl::StrCat("--", flag.name),
                              flag.current_value);
    }
  }
  return again;
}

std::string InFolder(const std::string& name) {
  return absl::StrCat(FLAGS_out, "/", name);
}

absl::Status WriteAll(const std::vector<reproduce::CaseResult>& results,
                      const Eigen::VectorXd& lambdas) {
  MLE_RETURN_IF_ERROR(WriteFileAtomically(InFolder("results.json"),
                                          reproduce::FormatResults(results)));
  for (const auto& [name, content] :
       reproduce::FormatCurves(results, lambdas)) {
    MLE_RETURN_IF_ERROR(WriteFileAtomically(InFolder(name), content));
  }
  std::vector<reproduce::NamedFigure> figures;
  if (FLAGS_figures) figures = reproduce::MakeFigures(results, lambdas);
  std::vector<absl::StatusOr<std::string>> svgs;
  absl::Status drawn;
  for (const reproduce::NamedFigure& figure : figures) {
    svgs.push_back(report::RenderFigure(figure.figure, report::Format::kSvg));
    drawn.Update(report::WriteFigure(
        figure.figure, InFolder(figure.name),
        {report::Format::kSvg, report::Format::kPng, report::Format::kPdf}));
  }
  MLE_RETURN_IF_ERROR(WriteFileAtomically(
      InFolder("report.html"),
      reproduce::FormatPage(results, figures, svgs, HowToRunAgain())));
  return drawn;
}

int Main() {
  const absl::StatusOr<Inputs> inputs = ReadInputs();
  if (!inputs.ok()) return Fail(inputs.status());
  if (const absl::Status status = MakeWritableFolder(FLAGS_out); !status.ok()) {
    return Fail(
        absl::InvalidArgumentError(absl::StrCat("--out: ", status.message())));
  }
  const absl::StatusOr<std::vector<reproduce::CaseResult>> results =
      RunAll(*inputs);
  if (!results.ok()) return Fail(results.status());

  int exit_code = kExitDone;
  for (const reproduce::CaseResult& result : *results) {
    std::cout << report::RenderText(reproduce::DistanceTable(result)) << "\n"
              << report::RenderText(reproduce::GainTable(result)) << "\n"
              << report::RenderText(reproduce::DelayTable(result)) << "\n";
    std::cout << "Relative duality gap, every fit and every λ: at most "
              << report::FormatScientific(result.max_relative_gap, 2) << "\n\n";
    if (!(result.max_relative_gap <= reproduce::kAcceptedGap)) {
      std::cerr << "warning: case " << result.name
                << ": a fit is not exact (relative duality gap above "
                << report::FormatScientific(reproduce::kAcceptedGap, 1)
                << ")\n";
      exit_code = kExitNotUsable;
    }
  }
  if (const absl::Status status =
          WriteAll(*results, inputs->experiment.correction.lambdas);
      !status.ok()) {
    return Fail(absl::InternalError(status.message()));
  }
  std::cout << "Report, figures and results: " << InFolder("report.html")
            << "\n";
  return exit_code;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  mle::StartCommand(mle::kUsage, argc, argv);
  return mle::Main();
}
