// The summary of a campaign's runs, cell by cell: the runs of a cell differ in
// their seed alone.

#ifndef APPS_EXPERIMENT_SUMMARY_H_
#define APPS_EXPERIMENT_SUMMARY_H_

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/distribution.h"
#include "apps/experiment/grid.h"

namespace mle::experiment {

struct Cell {
  std::int64_t number = 0;
  Coordinates at;  // of its first run
  int runs = 0;
  int failed = 0;
  // Distributions over the runs that did not fail.
  std::array<Distribution, kNumMetrics> metrics;
  // Share of them with E above that of the model left alone, and above twice
  // that at the best λ; NaN where there is none.
  double harmed = 0.0;
  double above_twice_best = 0.0;
  // As many of the values as figures show, in the order of the seeds.
  std::map<Metric, std::vector<double>> shown;

  const Distribution& operator[](Metric metric) const {
    return metrics[static_cast<std::size_t>(metric)];
  }
};

struct StudySummary {
  std::vector<Cell> cells;
  std::int64_t runs = 0;
  std::int64_t failed = 0;
  // How often each failure occurred, numbers in it taken out.
  std::map<std::string, std::int64_t> failures;
  // Largest gap of the solvers that are exact, over all runs.
  double max_gap = 0.0;
};

// One pass over the runs, in their order: memory holds a cell at a time.
absl::StatusOr<StudySummary> Summarise(
    const Campaign& campaign, const Grid& grid,
    const std::function<absl::StatusOr<Row>(std::int64_t run)>& row_of);

// summary.csv: a line for each cell and metric. summary.json: the same.
std::string SummaryCsv(const StudySummary& summary, const Campaign& campaign);
std::string SummaryJson(const StudySummary& summary, const Campaign& campaign);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_SUMMARY_H_
