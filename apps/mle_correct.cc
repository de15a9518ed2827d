// mle_correct: a process model corrected from a user's own records.

#include <sys/resource.h>

#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/common/password_prompt.h"
#include "apps/common/process_faults.h"
#include "apps/common/progress.h"
#include "apps/correct/data_sources.h"
#include "apps/correct/prospects.h"
#include "apps/correct/report.h"
#include "apps/correct/request.h"
#include "apps/correct/result.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/nearest_names.h"
#include "mle/data/record_columns.h"
#include "mle/data/tag_file.h"
#include "mle/model/process_model.h"

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace mle::correct {
namespace {

// The channels of these names that no column is proposed for.
std::vector<std::string> WithoutColumn(
    const std::vector<std::string>& channels,
    const std::vector<TagProposal>& proposals) {
  std::set<std::string> proposed;
  for (const TagProposal& proposal : proposals) {
    proposed.insert(proposal.channel);
  }
  std::vector<std::string> missing;
  for (const std::string& channel : channels) {
    if (!proposed.contains(channel)) missing.push_back(channel);
  }
  return missing;
}

std::string OnSetPoints(const std::vector<std::string>& set_points,
                        const std::vector<TagProposal>& proposals) {
  const std::vector<std::string> missing = WithoutColumn(set_points, proposals);
  if (missing.empty()) return "";
  std::vector<std::string> likely;
  for (const TagProposal& proposal : proposals) {
    if (proposal.channel.empty() && IsSetPointTag(proposal.tag)) {
      likely.push_back(proposal.tag);
    }
  }
  if (!likely.empty()) {
    return absl::StrCat("Set points are probably ", ListOfNames(likely),
                        "; their channels are ", ListOfNames(missing), ".\n");
  }
  if (missing.size() < set_points.size()) return "";
  return absl::StrCat(
      "No column looks like a set point. If one is, its channel is among ",
      ListOfNames(missing),
      "; if none is, --change_times names when set points were changed.\n");
}

// Lines: what was proposed in the file `path`, the channels that still need a
// column, what there is of set points, and the flag that reads the file.
std::string DescribeProposals(const std::vector<TagProposal>& proposals,
                              const ProcessModel& model,
                              const std::string& path) {
  std::vector<std::string> needed;
  std::vector<std::string> set_points;
  for (const OutputChannel& output : model.outputs()) {
    needed.push_back(output.name);
    set_points.push_back(SetPointName(output.name));
  }
  for (const InputChannel& input : model.inputs()) {
    needed.push_back(input.name);
  }
  std::size_t mapped = 0;
  for (const TagProposal& proposal : proposals) {
    if (!proposal.channel.empty()) ++mapped;
  }
  const std::vector<std::string> missing = WithoutColumn(needed, proposals);
  return absl::StrCat(
      path, ": a channel is proposed for ", mapped, " of ", proposals.size(),
      " columns. Check each line; scale and offset convert units",
      mapped < proposals.size()
          ? ", and a column without a channel is ignored.\n"
          : ".\n",
      missing.empty()
          ? ""
          : absl::StrCat(
                "Write into the column channel: ", ListOfNames(missing), ".\n"),
      OnSetPoints(set_points, proposals), "Then use it: --tag_file=", path,
      "\n");
}

// Text that mle_correct prints.

// "kind: text", on standard error.
void PrintMessages(const char* kind, const std::vector<Message>& messages) {
  for (const std::string& text : ShownTogether(messages)) {
    std::cerr << kind << ": " << text << "\n";
  }
}

// On standard error: the most memory that the process has used so far.
void PrintMemory() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  constexpr long kKibibytes = 1024;  // of a MiB
  std::cerr << "at most " << (usage.ru_maxrss + kKibibytes - 1) / kKibibytes
            << " MiB of memory were used\n";
}

// The verdict in at most six lines; with --verbose also what it rests on, and
// the warnings.
void PrintResult(const Result& result) {
  for (const std::string& line : ShortVerdict(result)) {
    std::cout << line << "\n";
  }
  for (const std::string& line : DescribeNextMove(result)) {
    std::cout << line << "\n";
  }
  std::cout << WhereTheRestIs(result) << "\n";
  if (!result.request.verbose) return;
  PrintMessages("warning", result.warnings);
  std::cout << "\n" << Details(result);
}

constexpr char kUsage[] =
    R"(Corrects a process model from records of routine closed-loop operation with
set-point changes, and says whether it has aged, where, by how much, and how far
the correction can be trusted.

  mle_correct --model=column.json --data=march.csv --dry_run
  mle_correct --model=column.json --data=march.csv,april.csv --out=correction

Times are in the model's time unit: min below. Exit codes: 0 done, 1 the result
is not usable or no decision was possible, 2 bad input or flags.)";

// Writes the file of --propose_tags.
absl::StatusOr<int> Propose(const Request& request,
                            const std::vector<HistorianSource>& sources) {
  const absl::StatusOr<std::vector<TagProposal>> proposals =
      ProposeTags(sources, request.model, request.import);
  if (!proposals.ok()) {
    return WithPrefix(NameFlags(proposals.status()), "--data: ");
  }
  MLE_RETURN_IF_ERROR(WithPrefix(
      WriteFileAtomically(request.propose_tags, FormatTagFile(*proposals)),
      "--propose_tags: "));
  std::cout << DescribeProposals(*proposals, request.model,
                                 request.propose_tags);
  return kExitDone;
}

// With what helps where columns have other names than the channels.
absl::Status OnReading(const absl::Status& status, const Request& request) {
  std::string more;
  if (absl::StrContains(OptionOf(status), "tags") && request.tags.empty() &&
      request.tag_file.empty()) {
    more =
        ". --propose_tags=tags.csv writes a file of the columns, to be "
        "completed and given as --tag_file";
  }
  return absl::Status(
      status.code(),
      absl::StrCat("--data: ", NameFlags(status).message(), more));
}

// Shown until Ctrl-C.
ProgressCallback TellStages() {
  return [show = ShowStages()](const RunProgress& progress) {
    show(progress.stage, progress.fraction);
    return !StopRequested();
  };
}

// Where columns are missing, of what is there.
absl::StatusOr<RecordData> Load(const std::vector<HistorianSource>& sources,
                                Request& request) {
  const auto load = [&] {
    return LoadSources(sources, request.model, request.import,
                       request.options.records, TellStages());
  };
  absl::StatusOr<RecordData> data = load();
  const auto is_about_tags = [](const absl::Status& status) {
    return absl::StrContains(OptionOf(status), "tags");
  };
  if (data.ok() || !is_about_tags(data.status()) ||
      !LeaveOutMissing(sources, request)) {
    return data;
  }
  absl::StatusOr<RecordData> part = load();
  return part.ok() || !is_about_tags(part.status()) ? std::move(part)
                                                    : std::move(data);
}

// Columns of long records come and go, and pages that the system gets back are
// cleared before they are had again: up to 1 GiB is kept for what comes next.
void KeepFreedMemory() {
#ifdef M_MMAP_THRESHOLD
  constexpr int kKept = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
#endif
}

// Corrects, writes the files of --out and prints the verdict.
absl::StatusOr<int> CorrectAndWrite(RecordData data,
                                    std::vector<DataFile> files,
                                    Request& request) {
  request.options.progress = TellStages();
  const absl::StatusOr<Result> result =
      RunCorrection(request, std::move(data), std::move(files));
  if (!result.ok()) return NameFlags(result.status());
  absl::StatusOr<std::string> json =
      FormatResult(*result, CommandLine(), ResultFlags());
  absl::Status status = json.status();
  if (status.ok()) {
    ShowStatus("writing the results");
    status = WriteResult(*result, *json, HowToRunAgain({}, Checksums(*result)));
  }
  if (!status.ok()) return absl::InternalError(status.message());
  EndStatus();
  PrintMessages("error", result->failures);
  if (request.json) {
    std::cout << *json;
  } else {
    PrintResult(*result);
  }
  return result->exit_code();
}

// The same; without a result, no folder is left that was not there before.
absl::StatusOr<int> CorrectIntoFolder(RecordData data,
                                      std::vector<DataFile> files,
                                      Request& request) {
  CatchStopSignals();
  const bool is_new = !std::filesystem::exists(request.out);
  MLE_ASSIGN_OR_RETURN(const FolderLock lock, ClaimOutputFolder(request.out));
  absl::StatusOr<int> code =
      CorrectAndWrite(std::move(data), std::move(files), request);
  if (code.ok()) return code;
  std::error_code not_empty;
  if (is_new) std::filesystem::remove(request.out, not_empty);
  if (!absl::IsCancelled(code.status())) return code;
  return absl::FailedPreconditionError(
      is_new ? "stopped: nothing was written"
             : absl::StrCat("stopped: nothing was written, the files in ",
                            request.out, " are as they were"));
}

absl::StatusOr<int> Run(Request& request, OptionTable& table) {
  KeepFreedMemory();
  MLE_RETURN_IF_ERROR(Complete(request, table));
  request.database.ask_password = AskPassword;
  const absl::StatusOr<DataSources> sources =
      DataSources::Create(request.data_paths, request.database, request.import);
  if (!sources.ok()) {
    return WithPrefix(NameFlags(sources.status()), "--data: ");
  }
  if (!request.propose_tags.empty()) {
    return Propose(request, sources->sources());
  }
  ShowStatus(
      absl::StrCat("reading ", request.data_paths.size(),
                   request.data_paths.size() == 1 ? " source" : " sources"));
  absl::StatusOr<RecordData> data = Load(sources->sources(), request);
  if (!data.ok()) return OnReading(data.status(), request);
  if (request.dry_run) {
    EndStatus();
    NameFlags(*data);
    std::cout << DescribeRecords(
        *data, sources->Files(), request.model,
        FindProspects(*data, request.model, request.options.threads));
    PrintMessages("warning", request.left_out);
    PrintMessages("warning", data->warnings);
    PrintMessages("warning", DescriptionWarnings(request.model_file));
    PrintMemory();
    return kExitDone;
  }
  return CorrectIntoFolder(*std::move(data), sources->Files(), request);
}

}  // namespace
}  // namespace mle::correct

int main(int argc, char** argv) {
  return mle::RunCommand(mle::correct::kUsage, mle::correct::AddOptions,
                         mle::correct::Run, argc, argv);
}
