#include "apps/experiment/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::experiment {
namespace {

// Figures show at most this many values of a cell, of this many cells.
constexpr std::size_t kShownValues = 2000;
constexpr std::int64_t kShownCells = 64;
constexpr Metric kShownMetrics[] = {Metric::kE, Metric::kBestE};

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

absl::StatusOr<StudySummary> Summarise(
    const Campaign& campaign, const Grid& grid,
    const std::function<absl::StatusOr<Row>(std::int64_t run)>& row_of) {
  StudySummary summary;
  CellRuns cell;
  for (; summary.runs < grid.num_runs(); ++summary.runs) {
    MLE_ASSIGN_OR_RETURN(const Row row, row_of(summary.runs));
    cell.Add(row);
    const Method& method = campaign.methods[grid.At(summary.runs).method];
    if (!row.ok()) {
      ++summary.failed;
      ++summary.failures[KindOf(row.status)];
    } else if (method.solver >= 0 && campaign.solvers[method.solver].exact &&
               !std::isnan(row[Metric::kGap])) {
      summary.max_gap = std::max(summary.max_gap, row[Metric::kGap]);
    }
    if (cell.runs() == grid.seeds()) {
      const std::int64_t finished = grid.CellOf(summary.runs);
      summary.cells.push_back(
          cell.Finish(finished, grid, finished < kShownCells));
    }
  }
  return summary;
}

namespace {

using Json = nlohmann::ordered_json;

// Coordinates of a cell: all but the seed.
std::vector<std::string> CellNames() {
  std::vector<std::string> names = CoordinateNames();
  names.pop_back();
  return names;
}

std::vector<std::string> CellTexts(const Campaign& campaign, const Cell& cell) {
  std::vector<std::string> texts = CoordinateTexts(campaign, cell.at);
  texts.pop_back();
  return texts;
}

// The numbers of a distribution that are written, in order.
std::vector<std::pair<const char*, double>> Values(const Distribution& d) {
  return {{"mean", d.mean},
          {"mean_low", d.mean_low},
          {"mean_high", d.mean_high},
          {"standard_deviation", d.deviation},
          {"min", d.min},
          {"q05", d.quantiles[0]},
          {"q25", d.quantiles[1]},
          {"median", d.quantiles[2]},
          {"q75", d.quantiles[3]},
          {"q95", d.quantiles[4]},
          {"max", d.max}};
}

}  // namespace

std::string SummaryCsv(const StudySummary& summary, const Campaign& campaign) {
  std::string text = absl::StrCat("cell,", absl::StrJoin(CellNames(), ","),
                                  ",runs,failed,metric,count");
  for (const auto& [name, value] : Values(Distribution())) {
    absl::StrAppend(&text, ",", name);
  }
  text += "\n";
  for (const Cell& cell : summary.cells) {
    std::string start = absl::StrCat(cell.number);
    for (const std::string& field : CellTexts(campaign, cell)) {
      absl::StrAppend(&start, ",", CsvField(field));
    }
    absl::StrAppend(&start, ",", cell.runs, ",", cell.failed);
    for (int i = 0; i < kNumMetrics; ++i) {
      const Distribution& metric = cell.metrics[i];
      if (metric.count == 0) continue;
      absl::StrAppend(&text, start, ",", kMetricNames[i], ",", metric.count);
      for (const auto& [name, value] : Values(metric)) {
        absl::StrAppend(&text, ",", NumberText(value));
      }
      text += "\n";
    }
  }
  return text;
}

std::string SummaryJson(const StudySummary& summary, const Campaign& campaign) {
  Json json = {{"version", 1},
               {"program", "mle_study"},
               {"program_version", std::string(LibraryVersion())},
               {"campaign", campaign.name},
               {"runs", summary.runs},
               {"failed", summary.failed},
               {"max_relative_gap", summary.max_gap},
               {"failures", Json::object()},
               {"cells", Json::array()}};
  for (const auto& [kind, count] : summary.failures) {
    json["failures"][kind] = count;
  }
  const std::vector<std::string> names = CellNames();
  for (const Cell& cell : summary.cells) {
    Json entry = Json::object();
    const std::vector<std::string> texts = CellTexts(campaign, cell);
    for (std::size_t i = 0; i < names.size(); ++i) entry[names[i]] = texts[i];
    entry["noise_variance"] = campaign.noise_variances[cell.at.scenario.noise];
    entry["drift_variance"] = campaign.drift_variances[cell.at.scenario.drift];
    entry["size"] = campaign.mismatches[cell.at.scenario.mismatch].size;
    entry["runs"] = cell.runs;
    entry["failed"] = cell.failed;
    entry["share_harmed"] = cell.harmed;
    entry["share_above_twice_best"] = cell.above_twice_best;
    for (int i = 0; i < kNumMetrics; ++i) {
      if (cell.metrics[i].count == 0) continue;
      Json metric = {{"count", cell.metrics[i].count}};
      for (const auto& [name, value] : Values(cell.metrics[i])) {
        metric[name] = value;
      }
      entry["metrics"][kMetricNames[i]] = std::move(metric);
    }
    json["cells"].push_back(std::move(entry));
  }
  return FormatJson(json);
}

}  // namespace mle::experiment
