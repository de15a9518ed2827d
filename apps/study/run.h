// A campaign from its text to its results, in a folder that one run of it at a
// time has for itself.
//
//   MLE_ASSIGN_OR_RETURN(const Study study, ReadStudy(text, source, folder));
//   MLE_ASSIGN_OR_RETURN(StudyFolder out, OpenFolder(study, "study", false));
//   … Coordinate(…);
//   MLE_ASSIGN_OR_RETURN(const StudySummary summary,
//                        Conclude(study, out, figures, run_again));

#ifndef APPS_STUDY_RUN_H_
#define APPS_STUDY_RUN_H_

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
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
  FolderLock lock;
  std::unique_ptr<Journal> journal;
};

// Locks the folder, opens its journal and writes campaign.json.
absl::StatusOr<StudyFolder> OpenFolder(const Study& study,
                                       const std::string& path, bool resume);

// `wanted`, as far as there are processors, or, where that is 0, those that
// this process may use: its share of the machine's with `processes` on it.
int StudyThreads(int wanted, int processes);

// Of a journal with every run: writes runs.csv and timings.csv, what
// WriteOutputs() writes, and gives the summary.
absl::StatusOr<StudySummary> Conclude(const Study& study,
                                      const StudyFolder& folder, bool figures,
                                      const report::RunAgain& run_again);

}  // namespace mle::study

#endif  // APPS_STUDY_RUN_H_
