// summary.csv and summary.json.

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/study/summary.h"
#include "mle/base/version.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::study {
namespace {

using experiment::Campaign;
using experiment::CoordinateNames;
using experiment::CoordinateTexts;
using experiment::CsvField;
using experiment::Distribution;
using experiment::kMetricNames;
using experiment::kNumMetrics;
using experiment::NumberText;

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

// What of a distribution is written, in order.
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

}  // namespace mle::study
