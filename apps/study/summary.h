// What a campaign's runs say, cell by cell: the runs of a cell differ in their
// seed alone.

#ifndef APPS_STUDY_SUMMARY_H_
#define APPS_STUDY_SUMMARY_H_

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/distribution.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/row.h"
#include "apps/study/campaign.h"

namespace mle::study {

struct Cell {
  std::int64_t number = 0;
  experiment::Coordinates at;  // of its first run
  int runs = 0;
  int failed = 0;
  // Of the runs that did not fail.
  std::array<experiment::Distribution, experiment::kNumMetrics> metrics;
  // Share of them with E above that of the model left alone, and above twice
  // that at the best λ; NaN where there is none.
  double harmed = 0.0;
  double above_twice_best = 0.0;
  // As many of the values as figures show, in the order of the seeds.
  std::map<experiment::Metric, std::vector<double>> shown;

  const experiment::Distribution& operator[](experiment::Metric metric) const {
    return metrics[static_cast<std::size_t>(metric)];
  }
};

struct StudySummary {
  std::vector<Cell> cells;
  std::int64_t runs = 0;
  std::int64_t failed = 0;
  // How often each failure occurred, numbers in it taken out.
  std::map<std::string, std::int64_t> failures;
  // Of the solvers that are exact, all runs.
  double max_gap = 0.0;
};

// One pass over runs.csv, whose runs are in order: memory holds a cell at a
// time. InvalidArgument names file and line.
absl::StatusOr<StudySummary> Summarise(const std::string& path,
                                       const experiment::Campaign& campaign,
                                       const experiment::Grid& grid);

// summary.csv: a line for each cell and metric. summary.json: the same.
std::string SummaryCsv(const StudySummary& summary,
                       const experiment::Campaign& campaign);
std::string SummaryJson(const StudySummary& summary,
                        const experiment::Campaign& campaign);

}  // namespace mle::study

#endif  // APPS_STUDY_SUMMARY_H_
