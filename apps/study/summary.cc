#include "apps/study/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::Campaign;
using experiment::Describe;
using experiment::Grid;
using experiment::kNumMetrics;
using experiment::Method;
using experiment::Metric;
using experiment::ParseRow;
using experiment::Row;

// What figures show of a cell, and of how many cells.
constexpr std::size_t kShownValues = 2000;
constexpr std::int64_t kShownCells = 64;
constexpr Metric kShownMetrics[] = {Metric::kE, Metric::kBestE, Metric::kRatio,
                                    Metric::kLambdaMin, Metric::kBestLambda};

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// A failure's words with every number made "#", so that like counts with like.
std::string KindOf(const std::string& status) {
  std::string kind;
  const char* at = status.c_str();
  while (*at != '\0') {
    const bool sign = *at == '-' || *at == '+';
    if (!IsDigit(sign ? at[1] : at[0])) {
      kind += *at++;
      continue;
    }
    char* end = nullptr;
    std::strtod(at, &end);
    at = end;
    kind += '#';
  }
  return kind;
}

// Gathers the runs of one cell.
class CellRuns {
 public:
  void Add(const Row& row) {
    ++runs_;
    if (!row.ok()) {
      ++failed_;
      return;
    }
    for (int i = 0; i < kNumMetrics; ++i) {
      if (!std::isnan(row.values[i])) values_[i].push_back(row.values[i]);
    }
    Count(row[Metric::kE], row[Metric::kInitialE], harmed_, compared_);
    Count(row[Metric::kE], 2.0 * row[Metric::kBestE], above_, oracles_);
  }

  Cell Finish(std::int64_t number, const Grid& grid, bool shown) {
    Cell cell;
    cell.number = number;
    cell.at = grid.At(number * grid.seeds());
    cell.runs = runs_;
    cell.failed = failed_;
    cell.harmed = Share(harmed_, compared_);
    cell.above_twice_best = Share(above_, oracles_);
    if (shown) {
      for (const Metric metric : kShownMetrics) {
        std::vector<double> values = values_[static_cast<std::size_t>(metric)];
        if (values.size() > kShownValues) values.resize(kShownValues);
        cell.shown[metric] = std::move(values);
      }
    }
    for (int i = 0; i < kNumMetrics; ++i) {
      cell.metrics[i] =
          Describe(std::move(values_[i]), static_cast<std::uint64_t>(number));
    }
    *this = CellRuns();
    return cell;
  }

  int runs() const { return runs_; }

 private:
  static void Count(double value, double limit, int& above, int& all) {
    if (std::isnan(value) || std::isnan(limit)) return;
    ++all;
    if (value > limit * (1.0 + 1e-9)) ++above;
  }

  static double Share(int part, int all) {
    return all > 0 ? static_cast<double>(part) / all : kNaN;
  }

  int runs_ = 0;
  int failed_ = 0;
  int harmed_ = 0;
  int compared_ = 0;
  int above_ = 0;
  int oracles_ = 0;
  std::array<std::vector<double>, kNumMetrics> values_;
};

}  // namespace

absl::StatusOr<StudySummary> Summarise(const std::string& path,
                                       const Campaign& campaign,
                                       const Grid& grid) {
  std::ifstream input(path, std::ios::binary);
  if (!input) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": cannot be read"));
  }
  StudySummary summary;
  CellRuns cell;
  std::string line;
  std::int64_t number = 0;
  while (std::getline(input, line)) {
    if (++number == 1) continue;
    const absl::StatusOr<Row> row = ParseRow(line, /*with_seconds=*/false);
    if (!row.ok() || row->run != summary.runs) {
      return absl::InvalidArgumentError(absl::StrCat(
          path, ":", number, ": ",
          row.ok() ? "not the next run" : std::string(row.status().message())));
    }
    ++summary.runs;
    cell.Add(*row);
    const Method& method = campaign.methods[grid.At(row->run).method];
    if (!row->ok()) {
      ++summary.failed;
      ++summary.failures[KindOf(row->status)];
    } else if (method.solver >= 0 && campaign.solvers[method.solver].exact &&
               !std::isnan((*row)[Metric::kGap])) {
      summary.max_gap = std::max(summary.max_gap, (*row)[Metric::kGap]);
    }
    if (cell.runs() == grid.seeds()) {
      const std::int64_t finished = grid.CellOf(row->run);
      summary.cells.push_back(
          cell.Finish(finished, grid, finished < kShownCells));
    }
  }
  return summary;
}

}  // namespace mle::study
