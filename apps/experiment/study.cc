#include "apps/experiment/study.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/sha256.h"
#include "apps/experiment/campaign_json.h"
#include "apps/experiment/report.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"

namespace mle::experiment {
namespace {

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
