// mle_correct: a process model corrected from a user's own records.

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/command_line.h"
#include "apps/common/password_prompt.h"
#include "apps/common/progress.h"
#include "apps/common/run_again.h"
#include "apps/correct/console.h"
#include "apps/correct/data_sources.h"
#include "apps/correct/outputs.h"
#include "apps/correct/part_of_model.h"
#include "apps/correct/proposed_tags.h"
#include "apps/correct/result.h"
#include "apps/correct/result_files.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/tag_file.h"

namespace mle {
namespace {

constexpr char kUsage[] =
    R"(Corrects a process model from records of routine closed-loop operation with
set-point changes, and says whether it has aged, where, by how much, and how far
the correction can be trusted.

  mle_correct --model=column.json --data=march.csv --dry_run
  mle_correct --model=column.json --data=march.csv,april.csv --out=correction

Times are in the model's time unit: min below. Exit codes: 0 done, 1 the result
is not usable or no decision was possible, 2 bad input or flags.)";

// Writes the file of --propose_tags.
int Propose(const correct::Request& request,
            const std::vector<HistorianSource>& sources) {
  const absl::StatusOr<std::vector<TagProposal>> proposals =
      ProposeTags(sources, request.model, request.import);
  if (!proposals.ok()) {
    return Fail(WithPrefix(correct::NameFlags(proposals.status()), "--data: "));
  }
  if (const absl::Status status =
          WriteFileAtomically(request.propose_tags, FormatTagFile(*proposals));
      !status.ok()) {
    return Fail(WithPrefix(status, "--propose_tags: "));
  }
  std::cout << correct::DescribeProposals(*proposals, request.model,
                                          request.propose_tags);
  return kExitDone;
}

// With what helps where columns have other names than the channels.
absl::Status OnReading(const absl::Status& status,
                       const correct::Request& request) {
  std::string more;
  if (absl::StrContains(OptionOf(status), "tags") && request.tags.empty() &&
      request.tag_file.empty()) {
    more =
        ". --propose_tags=tags.csv writes a file of the columns, to be "
        "completed and given as --tag_file";
  }
  return absl::Status(
      status.code(),
      absl::StrCat("--data: ", correct::NameFlags(status).message(), more));
}

bool ShowStage(const RunProgress& progress) {
  ShowStatus(progress.fraction == 0.0
                 ? progress.stage
                 : absl::StrFormat("%s: %.0f %%", progress.stage,
                                   100.0 * progress.fraction));
  return true;
}

// Where columns are missing, of what is there.
absl::StatusOr<RecordData> Load(const std::vector<HistorianSource>& sources,
                                correct::Request& request) {
  const auto load = [&] {
    return LoadSources(sources, request.model, request.import,
                       request.options.records, ShowStage);
  };
  absl::StatusOr<RecordData> data = load();
  const auto is_about_tags = [](const absl::Status& status) {
    return absl::StrContains(OptionOf(status), "tags");
  };
  if (data.ok() || !is_about_tags(data.status()) ||
      !correct::LeaveOutMissing(sources, request)) {
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

int Main(correct::Request& request, OptionTable& table) {
  KeepFreedMemory();
  if (const absl::Status status = correct::Complete(request, table);
      !status.ok()) {
    return Fail(status);
  }
  request.database.ask_password = AskPassword;
  const absl::StatusOr<correct::DataSources> sources =
      correct::DataSources::Create(request.data_paths, request.database,
                                   request.import);
  if (!sources.ok()) {
    return Fail(WithPrefix(correct::NameFlags(sources.status()), "--data: "));
  }
  if (!request.propose_tags.empty()) {
    return Propose(request, sources->sources());
  }
  ShowStatus(
      absl::StrCat("reading ", request.data_paths.size(),
                   request.data_paths.size() == 1 ? " source" : " sources"));
  absl::StatusOr<RecordData> data = Load(sources->sources(), request);
  if (!data.ok()) {
    return Fail(OnReading(data.status(), request));
  }
  if (request.dry_run) {
    EndStatus();
    correct::NameFlags(*data);
    correct::PrintData(*data, sources->Files(), request.model);
    correct::PrintMessages("warning", request.left_out);
    correct::PrintMessages("warning", data->warnings);
    correct::PrintMessages("warning",
                           correct::DescriptionWarnings(request.model_file));
    correct::PrintMemory();
    return kExitDone;
  }
  const absl::StatusOr<FolderLock> lock = ClaimOutputFolder(request.out);
  if (!lock.ok()) return Fail(lock.status());
  request.options.progress = ShowStage;
  const absl::StatusOr<correct::Result> result =
      correct::RunCorrection(request, *std::move(data), sources->Files());
  if (!result.ok()) return Fail(correct::NameFlags(result.status()));
  absl::StatusOr<std::string> json =
      correct::FormatResult(*result, CommandLine(), ResultFlags());
  absl::Status status = json.status();
  if (status.ok()) {
    ShowStatus("writing the results");
    status = correct::WriteResult(
        *result, *json, HowToRunAgain({}, correct::Checksums(*result)));
  }
  if (!status.ok()) return Fail(absl::InternalError(status.message()));
  EndStatus();
  correct::PrintMessages("error", result->failures);
  if (request.json) {
    std::cout << *json;
  } else {
    correct::PrintResult(*result);
  }
  return result->exit_code();
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  mle::correct::Request request;
  mle::OptionTable table;
  mle::correct::AddOptions(request, table);
  mle::StartCommand(mle::kUsage, table, argc, argv);
  return mle::Main(request, table);
}
