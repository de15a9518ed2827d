#include "apps/experiment/study.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/sha256.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/campaign_json.h"
#include "apps/experiment/report.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/model/element_response.h"

namespace mle::experiment {
namespace {

absl::StatusOr<ProcessModel> InitialModel(const Campaign& campaign, int model,
                                          std::uint64_t seed) {
  const ModelSpec& spec = campaign.models[model];
  if (!spec.random.has_value()) return spec.model;
  return DrawModel(*spec.random, seed, campaign.controllers);
}

// Gains and dead times of first-order fits, over the elements that are not
// zero.
void AddElementErrors(const Experiment& experiment, const Judgement& judged,
                      Row& row) {
  const ProcessModel& plant = experiment.plant();
  double gain_squares = 0.0;
  double delay_squares = 0.0;
  double gain_max = 0.0;
  double delay_max = 0.0;
  int count = 0;
  for (const auto& [i, j] : Pairs(plant)) {
    if (plant.element(i, j).IsZero()) continue;
    const int pair = i * plant.num_inputs() + j;
    const FopdtFit& wanted = experiment.truth_judged().fopdt[pair];
    const FopdtFit& found = judged.fopdt[pair];
    const double gain = (found.gain - wanted.gain) / wanted.gain;
    const double delay = found.delay - wanted.delay;
    if (!std::isfinite(gain) || !std::isfinite(delay)) continue;
    gain_squares += gain * gain;
    delay_squares += delay * delay;
    gain_max = std::max(gain_max, std::abs(gain));
    delay_max = std::max(delay_max, std::abs(delay));
    ++count;
  }
  if (count == 0) return;
  row[Metric::kGainErrorRms] = std::sqrt(gain_squares / count);
  row[Metric::kDelayErrorRms] = std::sqrt(delay_squares / count);
  row[Metric::kGainErrorMax] = gain_max;
  row[Metric::kDelayErrorMax] = delay_max;
}

// Gain, time scale and dead time, where the element can be written so.
std::optional<std::array<double, 3>> ParametersOf(
    const TransferFunction& element) {
  if (element.IsZero()) return std::nullopt;
  const auto response = ElementResponse::Create(element);
  if (!response.ok()) return std::nullopt;
  return std::array<double, 3>{element.StaticGain(),
                               response->initial_values().time_scale,
                               element.delay()};
}

// By gain, time constant, dead time or shape.
bool Differs(const TransferFunction& a, const TransferFunction& b) {
  return a.numerator() != b.numerator() || a.denominator() != b.denominator() ||
         a.delay() != b.delay();
}

// Whether the elements named as aged are those that differ, and the share of
// the intervals of all fitted parameters that hold the plant's.
void AddParameters(const Experiment& experiment,
                   const OutputErrorCorrection& output_error, Row& row) {
  const ProcessModel& initial = experiment.initial();
  const ProcessModel& plant = experiment.plant();
  bool named = true;
  double covered = 0.0;
  double count = 0.0;
  for (const auto& [i, j] : Pairs(plant)) {
    const auto truth = ParametersOf(plant.element(i, j));
    named = named && output_error.aged(i, j) ==
                         Differs(initial.element(i, j), plant.element(i, j));
    const ElementEstimate& element = output_error.full.element(i, j);
    if (element.state != ElementState::kFitted || !truth.has_value()) {
      continue;
    }
    const std::array<const ParameterEstimate*, 3> estimates = {
        &element.gain, &element.time_scale, &element.delay};
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const double value = (*truth)[k];
      covered += estimates[k]->lower <= value && value <= estimates[k]->upper
                     ? 1.0
                     : 0.0;
      count += 1.0;
    }
  }
  row[Metric::kNamed] = named ? 1.0 : 0.0;
  if (count > 0.0) row[Metric::kCovered] = covered / count;
}

// A file that takes its name once it is whole and on the disk.
class NewFile {
 public:
  explicit NewFile(std::string path)
      : path_(std::move(path)),
        part_(absl::StrCat(path_, ".part")),
        file_(std::fopen(part_.c_str(), "wb")),
        good_(file_ != nullptr) {}

  ~NewFile() {
    if (file_ != nullptr) std::fclose(file_);
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  void Add(const std::string& line) {
    good_ = good_ && std::fputs(line.c_str(), file_) >= 0 &&
            std::fputc('\n', file_) != EOF;
  }

  absl::Status Finish() {
    good_ = good_ && std::fflush(file_) == 0 && fsync(fileno(file_)) == 0 &&
            std::rename(part_.c_str(), path_.c_str()) == 0;
    if (good_) return absl::OkStatus();
    return absl::InternalError(
        absl::StrCat(path_, ": cannot be written: ", std::strerror(errno)));
  }

 private:
  const std::string path_;
  const std::string part_;
  std::FILE* const file_;
  bool good_;
};

}  // namespace

Row RowOf(const Outcome& outcome) {
  Row row;
  row.run = outcome.run;
  row.seconds = outcome.seconds;
  if (!outcome.evaluation.ok()) {
    row.status =
        absl::StrCat("failed: ", outcome.evaluation.status().message());
    return row;
  }
  Experiment& experiment = *outcome.experiment;
  const Evaluation& evaluation = *outcome.evaluation;
  row[Metric::kInitialE] =
      DistanceOrInfinity(experiment.truth(), experiment.InitialResponse());
  row[Metric::kE] = evaluation.E();
  AddElementErrors(experiment, evaluation.judgement, row);
  if (evaluation.p_value.has_value()) {
    row[Metric::kProposed] = evaluation.change_proposed ? 1.0 : 0.0;
    row[Metric::kPValue] = *evaluation.p_value;
  }
  if (evaluation.lambda.size() > 0) {
    row[Metric::kLambdaMin] = evaluation.lambda.minCoeff();
    row[Metric::kLambdaMax] = evaluation.lambda.maxCoeff();
  }
  row[Metric::kGap] = evaluation.max_relative_gap;
  if (const Hindsight* const hindsight = evaluation.hindsight) {
    row[Metric::kBestE] = hindsight->best_E;
    row[Metric::kBestLambda] = hindsight->best_lambda;
    row[Metric::kZeroE] = hindsight->zero_E;
    if (hindsight->best_E > 0.0) {
      row[Metric::kRatio] = row[Metric::kE] / hindsight->best_E;
    }
  }
  const std::optional<Estimate>& estimate = evaluation.estimate;
  if (estimate.has_value() &&
      estimate->setting.options.estimator != Estimator::kArx) {
    AddParameters(experiment, estimate->fit.output_error, row);
    const double limit = experiment.Limit();
    if (limit > 0.0) row[Metric::kLimitE] = limit;
  }
  return row;
}

void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Outcome&)>& emit) {
  if (runs.empty()) return;
  double start = ThreadSeconds();
  const Coordinates first = grid.At(runs.front());
  const std::uint64_t seed = campaign.seeds[first.seed];
  const absl::StatusOr<ProcessModel> initial =
      InitialModel(campaign, first.scenario.model, seed);
  Shared<ConversionSummary> conversion;
  std::optional<Scenario> current;
  absl::StatusOr<std::unique_ptr<Experiment>> experiment = nullptr;
  if (!initial.ok()) experiment = WithPrefix(initial.status(), "model: ");
  for (const std::int64_t run : runs) {
    if (stop.load(std::memory_order_relaxed)) return;
    Outcome outcome;
    outcome.run = run;
    outcome.at = grid.At(run);
    if (initial.ok() && current != outcome.at.scenario) {
      current = outcome.at.scenario;
      experiment =
          Experiment::Create(campaign, *current, seed, *initial, conversion);
    }
    if (experiment.ok()) {
      outcome.experiment = experiment->get();
      outcome.evaluation =
          outcome.experiment->Run(campaign.methods[outcome.at.method]);
    } else {
      outcome.evaluation = experiment.status();
    }
    const double now = ThreadSeconds();
    outcome.seconds = now - start;
    start = now;
    emit(outcome);
  }
}

absl::StatusOr<Study> ReadStudy(std::string_view text,
                                const std::string& source,
                                const std::string& folder) {
  Study study;
  MLE_ASSIGN_OR_RETURN(study.resolved, ResolveCampaign(text, source, folder));
  MLE_ASSIGN_OR_RETURN(study.campaign, ParseCampaign(study.resolved, source));
  return study;
}

Work WorkOf(const Study& study) {
  const Campaign& campaign = study.campaign;
  const Grid grid(campaign);
  Work work;
  work.file = "journal.csv";
  work.head.first_line = absl::StrFormat(
      "# mle_study journal 2, campaign SHA-256 %s, mle %s, %d runs",
      Sha256Of(study.resolved), std::string(LibraryVersion()), grid.num_runs());
  work.head.columns = absl::StrCat(RowHeader(), ",seconds");
  work.head.runs = grid.num_runs();
  work.head.run_of =
      [&campaign, grid](std::string_view line) -> absl::StatusOr<std::int64_t> {
    MLE_ASSIGN_OR_RETURN(const Row row, ParseRow(line));
    const bool is_its_own =
        row.run < grid.num_runs() &&
        line.starts_with(absl::StrCat(RowStart(campaign, grid, row.run), ","));
    if (!is_its_own) return absl::DataLossError("coordinates of another run");
    return row.run;
  };
  work.units = grid.num_units();
  work.runs_of = [grid](std::int64_t unit) { return grid.RunsOf(unit); };
  work.run = [&campaign, grid](const std::vector<std::int64_t>& runs,
                               const std::atomic<bool>& stop,
                               const Work::Emit& emit) {
    RunUnit(campaign, grid, runs, stop, [&](const Outcome& outcome) {
      emit(outcome.run, RowText(campaign, grid, RowOf(outcome)));
    });
    return absl::OkStatus();
  };
  return work;
}

absl::StatusOr<RunFolder> OpenFolder(const Study& study, const Work& work,
                                     const std::string& path, const Part& part,
                                     bool resume) {
  MLE_ASSIGN_OR_RETURN(RunFolder folder,
                       RunFolder::Open(work, path, part, resume));
  MLE_RETURN_IF_ERROR(WriteFileAtomically(
      absl::StrCat(folder.path(), "/campaign.json"), study.resolved));
  return folder;
}

absl::StatusOr<StudySummary> Conclude(const Study& study,
                                      const RunFolder& folder, bool figures,
                                      const report::RunAgain& run_again) {
  NewFile merged(absl::StrCat(folder.path(), "/runs.csv"));
  NewFile timings(absl::StrCat(folder.path(), "/timings.csv"));
  merged.Add(RowHeader());
  timings.Add("run,seconds");
  const auto row_of = [&](std::int64_t run) -> absl::StatusOr<Row> {
    MLE_ASSIGN_OR_RETURN(const std::string line, folder.journal().Line(run));
    const std::size_t comma = line.rfind(',');
    merged.Add(line.substr(0, comma));
    timings.Add(absl::StrCat(run, line.substr(comma)));
    return ParseRow(line);
  };
  MLE_ASSIGN_OR_RETURN(const StudySummary summary,
                       Summarise(study.campaign, Grid(study.campaign), row_of));
  MLE_RETURN_IF_ERROR(merged.Finish());
  MLE_RETURN_IF_ERROR(timings.Finish());
  MLE_RETURN_IF_ERROR(
      WriteOutputs(folder.path(), figures, study.campaign, summary, run_again));
  return summary;
}

}  // namespace mle::experiment
