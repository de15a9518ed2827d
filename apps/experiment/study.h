// A campaign from its text to its results, in a folder (run_folder.h).
//
//   MLE_ASSIGN_OR_RETURN(const Study study, ReadStudy(text, source, folder));
//   const Work work = WorkOf(study);
//   MLE_ASSIGN_OR_RETURN(RunFolder out, RunFolder::Open(work, …));
//   MLE_RETURN_IF_ERROR(out.RunRemaining(work, threads, stopped, told));
//   MLE_ASSIGN_OR_RETURN(const StudySummary summary,
//                        Conclude(study, out, figures, run_again));

#ifndef APPS_EXPERIMENT_STUDY_H_
#define APPS_EXPERIMENT_STUDY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/experiment.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/run_folder.h"
#include "apps/experiment/summary.h"
#include "apps/report/html.h"

namespace mle::experiment {

struct Study {
  std::string resolved;  // the campaign's text, which needs no other file
  Campaign campaign;
};

// Arguments as of ResolveCampaign().
absl::StatusOr<Study> ReadStudy(std::string_view text,
                                const std::string& source,
                                const std::string& folder);

// Its journal is journal.csv. The study must outlive it.
Work WorkOf(const Study& study);

// Opens the folder for the work of a study, and writes campaign.json.
absl::StatusOr<RunFolder> OpenFolder(const Study& study, const Work& work,
                                     const std::string& path, const Part& part,
                                     bool resume);

// The journal has every run. Writes runs.csv, whose bytes depend on the
// campaign alone, and timings.csv, line by line beside their place and then
// renamed; what WriteOutputs() writes; and gives the summary.
absl::StatusOr<StudySummary> Conclude(const Study& study,
                                      const RunFolder& folder, bool figures,
                                      const report::RunAgain& run_again);

// The runs of one unit of a campaign (grid.h). What they have in common is
// computed once: the conversion for the unit, records for a scenario, paths for
// a solver.

// How a run went. The experiment lives until the callback returns.
struct Outcome {
  std::int64_t run = 0;
  Coordinates at;
  absl::StatusOr<Evaluation> evaluation;
  Experiment* experiment = nullptr;  // null where there were no records
  // Processor time; work that runs share counts for the first that needs it.
  double seconds = 0.0;
};

// `runs` are some of the runs of one unit, in the order of Grid::RunsOf(). Each
// is given to `emit` as soon as it is done, also where it failed; none is
// started once `stop` is set. An outcome depends on nothing but the campaign
// and the run's number, but for its seconds.
void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Outcome&)>& emit);

// The figures of merit of an outcome.
Row RowOf(const Outcome& outcome);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_STUDY_H_
