#include "apps/study/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kResamples = 1000;
// What figures show of a cell, and of how many cells.
constexpr std::size_t kShownValues = 2000;
constexpr std::int64_t kShownCells = 64;
constexpr Metric kShownMetrics[] = {Metric::kE, Metric::kBestE, Metric::kRatio,
                                    Metric::kLambdaMin, Metric::kBestLambda};

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Of sorted values.
double Quantile(const std::vector<double>& sorted, double level) {
  const double position = level * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double part = position - static_cast<double>(below);
  // Infinite values stay out of differences.
  if (part == 0.0 || sorted[below] == sorted[above]) return sorted[below];
  if (std::isinf(sorted[above])) return sorted[above];
  return sorted[below] + part * (sorted[above] - sorted[below]);
}

void BootstrapMean(const std::vector<double>& values, std::uint64_t number,
                   Distribution& description) {
  std::mt19937_64 engine(number + 1);
  std::vector<double> means(kResamples);
  const std::uint64_t count = values.size();
  for (double& mean : means) {
    double sum = 0.0;
    for (std::uint64_t i = 0; i < count; ++i) {
      // Uniform to one part in 2⁶⁴/n.
      sum += values[static_cast<std::size_t>(engine() % count)];
    }
    mean = sum / static_cast<double>(count);
  }
  std::sort(means.begin(), means.end());
  description.mean_low = Quantile(means, 0.025);
  description.mean_high = Quantile(means, 0.975);
}

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

Distribution Describe(std::vector<double> values, std::uint64_t number) {
  Distribution description;
  description.count = static_cast<int>(values.size());
  if (values.empty()) {
    description.mean = description.mean_low = description.mean_high = kNaN;
    description.deviation = description.min = description.max = kNaN;
    description.quantiles.fill(kNaN);
    return description;
  }
  description.mean = MeanOf(values);
  double squares = 0.0;
  for (const double value : values) {
    squares += (value - description.mean) * (value - description.mean);
  }
  const double count = static_cast<double>(values.size());
  description.deviation = std::isinf(description.mean) ? description.mean
                          : count > 1.0 ? std::sqrt(squares / (count - 1.0))
                                        : 0.0;
  BootstrapMean(values, number, description);
  std::sort(values.begin(), values.end());
  description.min = values.front();
  description.max = values.back();
  for (std::size_t i = 0; i < description.quantiles.size(); ++i) {
    description.quantiles[i] = Quantile(values, Distribution::kLevels[i]);
  }
  return description;
}

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
