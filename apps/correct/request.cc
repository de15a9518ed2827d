#include "apps/correct/request.h"

#include <set>
#include <utility>

#include "apps/common/command_line.h"
#include "apps/common/model_files.h"
#include "apps/common/shared_options.h"
#include "mle/base/status.h"

namespace mle::correct {
namespace {

std::vector<Option> FileOptions(Request& request) {
  return {
      {"model", &request.model_path,
       "Model of the controller (JSON, CSV or MAT: docs/formats.md), to be "
       "corrected; must be given."},
      {"data", Words(&request.data_paths),
       "Records (CSV, also compressed by gzip) of routine operation with "
       "set-point changes, separated by commas; - is standard input. Or a "
       "database: postgresql://USER@HOST/NAME, sqlite:FILE, odbc:NAME, with "
       "--table or --query. Must be given."},
      {"out", &request.out,
       "Folder for report.html, result.json, model.json, model.mat, "
       "fopdt.json, arx.json, state_space.json, step_response.csv and, of a "
       "--model in another form, model_corrected."},
      {"truth", &request.truth_path,
       "Process model (JSON) of a simulated plant: its step responses are "
       "shown as the truth."},
      {"outputs", Words(&request.outputs),
       "Outputs that are judged and corrected, separated by commas; empty: "
       "all. Columns of the others are not needed."},
      {"dry_run", &request.dry_run,
       "Only reports on the records and on what they can tell."},
      {"verbose", &request.verbose,
       "Prints warnings, tables and advice below the verdict."},
      {"json", &request.json,
       "Writes the content of result.json, and nothing else, to standard "
       "output; the files are written as well."},
      {"propose_tags", &request.propose_tags,
       "Only writes this file for --tag_file, with a row for each column of "
       "the records and the channel whose name is nearest, to be checked."},
      {"previous", &request.previous,
       "Folder of the last run, which the page compares."},
      {"figures", &request.figures,
       "Draws the figures, for the page and as files (SVG; PNG and PDF need "
       "rsvg-convert)."},
      {"threads", &request.options.threads,
       "Threads; 0: one for each processor. The results do not depend on the "
       "number.",
       "", kNotNegative},
  };
}

absl::Status ReadModels(Request& request) {
  if (request.model_path.empty() || request.data_paths.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE.json (or .csv) and --data=A.csv,B.csv must be given (see "
        "--help)");
  }
  MLE_ASSIGN_OR_RETURN(request.model_file,
                       AboutOption("model", ReadModelFile(request.model_path)));
  request.model = request.model_file.process;
  MLE_RETURN_IF_ERROR(
      CheckMoves(request.model, request.model_path, "nothing to correct"));
  if (request.truth_path.empty()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(request.truth,
                       ReadModelLike(request.model, request.model_path, "truth",
                                     request.truth_path));
  return absl::OkStatus();
}

absl::Status CheckOutput(const Request& request) {
  if (!request.json || (!request.dry_run && request.propose_tags.empty())) {
    return absl::OkStatus();
  }
  return InvalidArgument("--json: there is no result.json with ",
                         request.dry_run ? "--dry_run" : "--propose_tags");
}

absl::Status CheckDataPaths(const std::vector<std::string>& paths) {
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    if (!seen.insert(path).second) {
      return InvalidArgument("--data: '", path, "' is named twice");
    }
  }
  return absl::OkStatus();
}

}  // namespace

void AddOptions(Request& request, OptionTable& table) {
  CorrectOptions& options = request.options;
  table.Add("Files", FileOptions(request));
  table.Add("Reading the records",
            OptionsOf(request.import, request.tags, &request.tag_file));
  table.Add("Reading a database", OptionsOf(request.database));
  table.Add("Windows and bad samples", OptionsOf(options.records));
  table.Add("Estimation", OptionsOf(options.estimation));
  table.Add("Hold-out validation", OptionsOf(options.hold_out));
  table.Add("Decision", OptionsOf(options.decision));
  table.Add(
      "Results",
      {{"response_horizon", &options.response_horizon,
        "Length NΔt of the step responses; 0: the model's settling time.",
        "min", kNotNegative},
       {"filter", &options.filter.estimate,
        "Whether the filter of the outputs' disturbances is estimated."}});
  request.controller.control_period = 0.0;
  std::vector<Option> controller = mle::OptionsOf(request.controller);
  Option& period = Find(controller, "control_period");
  period.help =
      "Control period of the controller, a multiple of the sample time; 0: "
      "unknown, nothing is then said about loops and tuning.";
  period.range = kNotNegative;
  table.Add("The controller as it is tuned, for the advice",
            std::move(controller));
  table.Add("The next move", OptionsOf(request.next_move));
  table.PutFirst({"model", "data", "out", "tags", "dry_run", "change_times",
                  "leave_out", "control_period", "plan", "previous", "verbose",
                  "json"});
}

absl::Status Complete(Request& request, OptionTable& table) {
  MLE_RETURN_IF_ERROR(ReadModels(request));
  return CompleteForModel(request, table);
}

absl::Status CompleteForModel(Request& request, OptionTable& table) {
  MLE_RETURN_IF_ERROR(CheckDataPaths(request.data_paths));
  MLE_RETURN_IF_ERROR(CheckOutput(request));
  if (const std::string option = table.FirstChanged("plan_");
      !request.next_move.wanted && !option.empty()) {
    return InvalidArgument("--", option, ": a plan is made with --plan alone");
  }
  MLE_RETURN_IF_ERROR(ParseTags(request.tags, request.tag_file, request.model,
                                request.import.columns));
  MLE_RETURN_IF_ERROR(ChooseOutputs(request));
  MLE_RETURN_IF_ERROR(table.FitTo(request.model));
  MLE_RETURN_IF_ERROR(CheckNextMove(request.next_move, request.model));
  if (!request.previous.empty()) {
    MLE_ASSIGN_OR_RETURN(request.last,
                         ReadPreviousRun(request.previous, request.model));
  }
  if (const absl::Status status = request.import.Validate(request.model);
      !status.ok()) {
    return InvalidArgument("options of the records: ", status.message());
  }
  if (const absl::Status status = request.options.records.Validate();
      !status.ok()) {
    return InvalidArgument("options of the windows: ", status.message());
  }
  EstimationOptions& estimation = request.options.estimation;
  estimation.calibration.seed = estimation.conversion.seed;
  request.options.threads = UsableThreads(request.options.threads);
  request.options.records.examination.threads = request.options.threads;
  control::MpcOptions controller = request.controller;
  if (!request.controller_known()) controller.control_period = 1.0;
  return CheckController(controller, request.model);
}

}  // namespace mle::correct
