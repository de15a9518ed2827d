// A campaign from its text to its results, in a folder that one run of it at a
// time has for itself. Parts of a campaign (apps/common/part.h) have folders of
// their own below it, and may run at once, on any machines that see the folder.
//
//   MLE_ASSIGN_OR_RETURN(const Study study, ReadStudy(text, source, folder));
//   MLE_ASSIGN_OR_RETURN(StudyFolder out,
//                        OpenFolder(study, "study", Part(), false));
//   MLE_RETURN_IF_ERROR(RunRemaining(study, out, threads, stopped, told));
//   MLE_ASSIGN_OR_RETURN(const StudySummary summary,
//                        Conclude(study, out, figures, run_again));

#ifndef APPS_STUDY_RUN_H_
#define APPS_STUDY_RUN_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/common/part.h"
#include "apps/common/progress.h"
#include "apps/report/html.h"
#include "apps/study/campaign.h"
#include "apps/study/journal.h"
#include "apps/study/summary.h"
#include "mle/base/folder_lock.h"

namespace mle::study {

struct Study {
  std::string resolved;  // the campaign's text, which needs no other file
  experiment::Campaign campaign;
};

// Arguments as of ResolveCampaign().
absl::StatusOr<Study> ReadStudy(std::string_view text,
                                const std::string& source,
                                const std::string& folder);

struct StudyFolder {
  std::string path;
  Part part;
  FolderLock lock;
  std::unique_ptr<Journal> journal;
  std::int64_t runs = 0;  // of the part
  // Of these the journal has so many.
  std::int64_t num_done() const { return journal->num_done(); }
  bool is_done() const { return num_done() == runs; }
};

// Locks the folder of the part, opens its journal and writes campaign.json.
// For everything, the runs that parts have done are taken over; InvalidArgument
// where a part is at work or is of another campaign.
absl::StatusOr<StudyFolder> OpenFolder(const Study& study,
                                       const std::string& path,
                                       const Part& part, bool resume);

// `wanted`, as far as there are processors, or, where that is 0, those that
// this process may use.
int StudyThreads(int wanted);

// Until every run of the part is in the journal, or `stopped` says so (then the
// runs under way are still waited for). `told` is called with the runs done and
// all of them, in the beginning and several times a second. Both are called by
// the caller's thread.
absl::Status RunRemaining(const Study& study, StudyFolder& folder, int threads,
                          const std::function<bool()>& stopped,
                          const ProgressFunction& told);

// Of a journal with every run: writes runs.csv and timings.csv, what
// WriteOutputs() writes, and gives the summary.
absl::StatusOr<StudySummary> Conclude(const Study& study,
                                      const StudyFolder& folder, bool figures,
                                      const report::RunAgain& run_again);

}  // namespace mle::study

#endif  // APPS_STUDY_RUN_H_
