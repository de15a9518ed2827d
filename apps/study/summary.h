// What a campaign's runs say, cell by cell: the runs of a cell differ in their
// seed alone.
//
// Means have bootstrap intervals (Efron and Tibshirani, An Introduction to the
// Bootstrap, 1993, ch. 13: percentiles of means of resampled runs), since E and
// its ratios are far from Gaussian; quantiles are exact, by linear
// interpolation between order statistics.

#ifndef APPS_STUDY_SUMMARY_H_
#define APPS_STUDY_SUMMARY_H_

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/study/campaign.h"
#include "apps/study/grid.h"
#include "apps/study/row.h"

namespace mle::study {

// Of n ≥ 0 values; NaN where there are none. Values may be infinite (> 0).
struct Distribution {
  static constexpr std::array<double, 5> kLevels = {0.05, 0.25, 0.5, 0.75,
                                                    0.95};
  int count = 0;
  double mean = 0.0;
  double mean_low = 0.0;  // ends of the 95 % interval of the mean
  double mean_high = 0.0;
  double deviation = 0.0;  // standard (n − 1); 0 for one value
  double min = 0.0;
  double max = 0.0;
  std::array<double, 5> quantiles = {};  // at kLevels

  double median() const { return quantiles[2]; }
};

// `number` seeds the resampling: a cell's number.
Distribution Describe(std::vector<double> values, std::uint64_t number);

struct Cell {
  std::int64_t number = 0;
  Coordinates at;  // of its first run
  int runs = 0;
  int failed = 0;
  // Of the runs that did not fail.
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
  // Of the solvers that are exact, all runs.
  double max_gap = 0.0;
};

// One pass over runs.csv, whose runs are in order: memory holds a cell at a
// time. InvalidArgument names file and line.
absl::StatusOr<StudySummary> Summarise(const std::string& path,
                                       const Campaign& campaign,
                                       const Grid& grid);

// summary.csv: a line for each cell and metric. summary.json: the same.
std::string SummaryCsv(const StudySummary& summary, const Campaign& campaign);
std::string SummaryJson(const StudySummary& summary, const Campaign& campaign);

}  // namespace mle::study

#endif  // APPS_STUDY_SUMMARY_H_
