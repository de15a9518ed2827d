#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/option_table.h"
#include "apps/correct/report.h"
#include "apps/correct/request.h"
#include "apps/correct/result.h"
#include "apps/report/text.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "apps/watch/update.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

constexpr int kMostDays = 60;
constexpr int kAgainAfter = 14;
constexpr std::chrono::hours kLongestCorrection(1);

// The options of mle_correct, by name.
using Options = std::vector<std::pair<std::string, std::string>>;

std::string ValuesText(const Eigen::VectorXd& values) {
  std::vector<std::string> texts;
  for (const double value : values) {
    texts.push_back(std::isinf(value) ? "none" : ReadableNumber(value));
  }
  return absl::StrJoin(texts, ",");
}

// The plan, with the prices and the tuning that are in the list.
void AddPlan(const Controller& controller, Options& options) {
  const correct::NextMoveOptions& plan = *controller.plan;
  const auto add = [&options](const char* name, const std::string& value) {
    if (!value.empty()) options.emplace_back(name, value);
  };
  add("plan", "true");
  add("plan_error", ReadableNumber(plan.error));
  if (plan.longest.has_value()) {
    add("plan_longest", ReadableNumber(*plan.longest));
  }
  add("plan_quiet", ReadableNumber(plan.quiet));
  add("plan_set_points", absl::StrJoin(plan.set_points, ","));
  add("plan_min_output", ValuesText(plan.min_output));
  add("plan_max_output", ValuesText(plan.max_output));
  add("plan_min_input", ValuesText(plan.min_input));
  add("plan_max_input", ValuesText(plan.max_input));
  if (controller.valuation.has_value()) {
    const control::Prices& prices = controller.valuation->prices;
    if (!prices.squared_error.isZero(0.0)) {
      add("plan_price_squared", ValuesText(prices.squared_error));
    }
    if (!prices.absolute_error.isZero(0.0)) {
      add("plan_price_absolute", ValuesText(prices.absolute_error));
    }
  }
  if (!controller.tuning.has_value()) return;
  const control::MpcOptions& tuning = *controller.tuning;
  add("control_period", ReadableNumber(tuning.control_period));
  add("prediction_horizon", absl::StrCat(tuning.prediction_horizon));
  add("control_horizon", absl::StrCat(tuning.control_horizon));
  add("output_weight", ValuesText(tuning.output_weight.diagonal()));
  add("move_weight", ValuesText(tuning.move_weight.diagonal()));
  add("disturbance_variance_ratio",
      ReadableNumber(tuning.disturbance_variance_ratio));
}

class Correction {
 public:
  Correction(const Controller& controller, const ModelFile& model,
             const Watch& watch, int day)
      : controller_(controller), model_(model), watch_(watch), day_(day) {
    correct::AddOptions(request_, table_);
  }

  // Into `folder`, which is there. A corrected model goes on trial in `watch`.
  absl::Status Run(const std::string& folder, Proposal& proposal, Watch& watch);

 private:
  Options OptionsFor(const std::string& folder);
  absl::Status Prepare(const Options& options);

  const Controller& controller_;
  const ModelFile& model_;
  const Watch& watch_;
  int day_;
  std::vector<std::string> sources_;
  correct::Request request_;
  OptionTable table_;
};

Options Correction::OptionsFor(const std::string& folder) {
  // Not of a time before the change: a plant that changes within the records
  // has no one model.
  int from = day_ - kMostDays;
  for (const Alarm& alarm : AlarmsOfAgeing(watch_.alarms)) {
    from = std::max(from, alarm.began);
  }
  HistorianOptions range;
  sources_ = SourcesBetween(controller_, watch_, from * kSecondsOfDay,
                            (day_ + 1) * kSecondsOfDay, range);
  Options options = {{"model", controller_.model},
                     {"data", absl::StrJoin(sources_, ",")},
                     {"begin", range.begin},
                     {"end", range.end},
                     {"out", folder}};
  const auto add = [&options](const char* name, const std::string& value) {
    if (!value.empty()) options.emplace_back(name, value);
  };
  add("query", controller_.database.query);
  add("table", controller_.database.table);
  add("columns", absl::StrJoin(controller_.database.columns, ","));
  add("tag_file", controller_.tag_file);
  add("time_zone", controller_.time_zone);
  if (controller_.sample_time > 0.0) {
    add("sample_time", ReadableNumber(controller_.sample_time));
  }
  for (const char* const flag :
       {"ignore_other_columns", "any_word_is_bad", "skip_repeated_times"}) {
    options.emplace_back(flag, "true");
  }
  if (controller_.plan.has_value()) AddPlan(controller_, options);
  return options;
}

absl::Status Correction::Prepare(const Options& options) {
  for (const auto& [name, value] : options) {
    MLE_RETURN_IF_ERROR(table_.Set(name, value));
  }
  MLE_RETURN_IF_ERROR(table_.Read());
  // Those with commas in their names too.
  request_.data_paths = sources_;
  request_.database = controller_.database;
  request_.model_file = model_;
  request_.model = model_.process;
  request_.options.threads = 1;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point until = Clock::now() + kLongestCorrection;
  request_.options.progress = [until](const RunProgress&) {
    return Clock::now() < until;
  };
  return correct::CompleteForModel(request_, table_);
}

// As typed into a shell.
std::string CommandFor(const Options& options) {
  std::vector<std::string> arguments = {"mle_correct"};
  for (const auto& [name, value] : options) {
    if (name != "out")
      arguments.push_back(absl::StrCat("--", name, "=", value));
  }
  return report::QuoteCommandLine(arguments);
}

absl::Status Correction::Run(const std::string& folder, Proposal& proposal,
                             Watch& watch) {
  const Options options = OptionsFor(folder);
  MLE_RETURN_IF_ERROR(Prepare(options));
  MLE_ASSIGN_OR_RETURN(
      const correct::DataSources sources,
      correct::DataSources::Create(request_.data_paths, request_.database,
                                   request_.import));
  MLE_ASSIGN_OR_RETURN(RecordData data,
                       LoadSources(sources.sources(), request_.model,
                                   request_.import, request_.options.records));
  MLE_ASSIGN_OR_RETURN(
      const correct::Result result,
      correct::RunCorrection(request_, std::move(data), sources.Files()));
  const std::string command = CommandFor(options);
  MLE_ASSIGN_OR_RETURN(
      const std::string json,
      correct::FormatResult(result, command, ShapingResults(table_.Values())));
  MLE_RETURN_IF_ERROR(correct::WriteResult(
      result, json, HowToCallAgain(command, {}, correct::Checksums(result))));
  proposal.decision = NameOf(result.decision);
  std::vector<std::string> conclusion = result.verdict;
  if (result.next_move.has_value() && !result.accepted()) {
    for (std::string& sentence : correct::DescribeNextMove(result)) {
      conclusion.push_back(std::move(sentence));
    }
  }
  proposal.conclusion = absl::StrJoin(conclusion, " ");
  if (result.accepted()) {
    BeginTrial(request_.model, result.model, result.data.sample_time(),
               result.data.records, day_, watch);
  }
  return absl::OkStatus();
}

// `made` in place of `folder`, which is that of a run that was killed before
// its state was saved, if it is there.
absl::Status PutInPlace(const std::string& made, const std::string& folder) {
  const bool there = std::filesystem::exists(folder);
  if (renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, folder.c_str(),
                there ? RENAME_EXCHANGE : 0) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot make ", folder));
  }
  return absl::OkStatus();
}

}  // namespace

bool NeedsProposal(const Watch& watch) {
  if (AlarmsOfAgeing(watch.alarms).empty()) return false;
  if (!watch.trials.empty() && WaitsForRollBack(watch.trials.back())) {
    return false;
  }
  if (watch.proposals.empty()) return true;
  const Proposal& last = watch.proposals.back();
  if (last.decision != "corrected") {
    return watch.last_day() >= last.day + kAgainAfter;
  }
  return !watch.trials.empty() && watch.trials.back().day == last.day &&
         HasFailed(watch.trials.back()) &&
         watch.last_day() >= watch.trials.back().last_day + kAgainAfter;
}

void MakeProposal(const Controller& controller, const ModelFile& model,
                  const std::string& folder, Watch& watch) {
  const int day = watch.last_day();
  Proposal proposal{.day = day, .decision = "failed"};
  proposal.folder = absl::StrCat(folder, "/", FileNameOf(controller.name), "/",
                                 NameOfDay(day));
  const std::string made = absl::StrCat(proposal.folder, ".new");
  std::error_code error;
  std::filesystem::remove_all(made, error);
  absl::Status status = MakeWritableFolder(made);
  if (status.ok()) {
    status =
        Correction(controller, model, watch, day).Run(made, proposal, watch);
  }
  if (status.ok()) status = PutInPlace(made, proposal.folder);
  std::filesystem::remove_all(made, error);
  if (!status.ok()) {
    proposal.decision = "failed";
    proposal.conclusion = std::string(status.message());
  }
  watch.proposals.push_back(std::move(proposal));
}

std::string FileNameOf(const std::string& controller) {
  std::string name;
  for (const char c : controller) {
    const auto byte = static_cast<unsigned char>(c);
    if (absl::ascii_isalnum(byte) || c == '-') {
      name += c;
    } else {
      absl::StrAppendFormat(&name, "_%02x", byte);
    }
  }
  return name;
}

}  // namespace mle::watch
