// The report of mle_study on a summary: labels, verdict, tables, figures, the
// page and the files beside runs.csv.

#ifndef APPS_EXPERIMENT_REPORT_H_
#define APPS_EXPERIMENT_REPORT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/experiment/summary.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/report/table.h"

namespace mle::experiment {

// Short names of what is compared: only what differs within the campaign.

// "gain, noise 0.001"; the campaign's mismatch where nothing else differs.
std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario);
// The same without the one axis that a figure has.
enum class Axis { kNone, kNoise, kDrift, kSize };
std::string ScenarioLabel(const Campaign& campaign, const Scenario& scenario,
                          Axis without);
// "arx, no test, paper".
std::string MethodLabel(const Campaign& campaign, const Method& method);

// The verdict on a campaign's corrections, in a line and in counts.
//
// A case is a scenario with a method that corrects. Its correction ends closer
// to the plant where the median over the seeds of the squared distance E of the
// step responses is below that of the initial model, and farther where it is
// above.

// The counts and error ratios of the cases of one method.
struct MethodTally {
  int method = 0;  // of the campaign's
  int closer = 0;
  int unchanged = 0;
  int farther = 0;
  int closest = 0;  // scenarios in which no other method has a smaller median
  // E after over E before, medians: of the middle case and of the worst; NaN
  // without cases with E before above 0.
  double middle_ratio = 0.0;
  double worst_ratio = 0.0;
  std::int64_t runs = 0;  // that did not fail
  double harmed = 0.0;    // of them, with E above that of the initial model

  int cases() const { return closer + unchanged + farther; }
};

// In the order of the campaign's methods, those that correct.
std::vector<MethodTally> TallyMethods(const Campaign& campaign,
                                      const StudySummary& summary);

report::Verdict VerdictOf(const Campaign& campaign,
                          const StudySummary& summary);

// The tables of mle_study: of methods, and with a row for each cell.

// The cells of a table: `most` of them from the `first` on.
struct Rows {
  std::size_t first = 0;
  std::size_t most = 0;
};

// In how many scenarios each method ends closer to the plant.
report::Table MethodTable(const Campaign& campaign,
                          const StudySummary& summary);

// E before and after.
report::Table ErrorTable(const Campaign& campaign, const StudySummary& summary,
                         Rows rows);

// The figures of a campaign.

// Scenarios have a panel each, the first kMaxPanels of them, and methods a
// curve:
//   E over the axis of numbers that has the most values, where one has three
//   how E is distributed over the seeds
// Figures and curves that would have no values are left out.
inline constexpr int kMaxPanels = 6;
std::vector<report::NamedFigure> MakeFigures(const Campaign& campaign,
                                             const StudySummary& summary);

// The files that mle_study writes beside runs.csv (summary.csv, summary.json,
// the figures and report.html), and the summary that it prints.

absl::Status WriteOutputs(const std::string& folder, bool figures,
                          const Campaign& campaign, const StudySummary& summary,
                          const report::RunAgain& run_again);

void PrintSummary(const Campaign& campaign, const StudySummary& summary);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_REPORT_H_
