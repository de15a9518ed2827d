#include "apps/experiment/grid.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <sstream>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"

namespace mle::experiment {
namespace {

// The digits of a scenario, the slowest first. Runs that share the first ones
// share the conversion of the initial model.
constexpr int Scenario::*kDigits[] = {
    &Scenario::model,   &Scenario::noise,   &Scenario::ablation,
    &Scenario::drift,   &Scenario::effects, &Scenario::controller,
    &Scenario::windows, &Scenario::mismatch};
constexpr std::size_t kConversionDigits = 3;

std::int64_t Product(std::span<const int> counts) {
  std::int64_t product = 1;
  for (const int count : counts) product *= count;
  return product;
}

// The last digit of `number` in base `base`, which is taken off.
int Digit(std::int64_t& number, int base) {
  const auto digit = static_cast<int>(number % base);
  number /= base;
  return digit;
}

}  // namespace

Grid::Grid(const Campaign& campaign, int unit_scenarios)
    : methods_(static_cast<int>(campaign.methods.size())),
      seeds_(static_cast<int>(campaign.seeds.size())),
      unit_scenarios_(unit_scenarios) {
  constexpr double kMostRuns = 1e9;
  const std::size_t counts[] = {
      campaign.models.size(),    campaign.noise_variances.size(),
      campaign.ablations.size(), campaign.drift_variances.size(),
      campaign.effects.size(),   campaign.controllers.size(),
      campaign.windows.size(),   campaign.mismatches.size()};
  std::copy(std::begin(counts), std::end(counts), scenario_counts_.begin());
  double runs = static_cast<double>(methods_) * seeds_;
  for (const int count : scenario_counts_) runs *= count;
  countable_ = runs <= kMostRuns;
  const std::span<const int> digits(scenario_counts_);
  conversions_ = Product(digits.first(kConversionDigits));
  shared_ = countable_ ? Product(digits.subspan(kConversionDigits)) : 1;
  blocks_ = (shared_ + unit_scenarios_ - 1) / unit_scenarios_;
  scenarios_ = countable_ ? conversions_ * shared_ : 1;
}

Coordinates Grid::At(std::int64_t run) const {
  Coordinates at;
  at.seed = Digit(run, seeds_);
  at.method = Digit(run, methods_);
  for (std::size_t d = std::size(kDigits); d-- > 0;) {
    at.scenario.*kDigits[d] = Digit(run, scenario_counts_[d]);
  }
  return at;
}

std::vector<std::int64_t> Grid::RunsOf(std::int64_t unit) const {
  const std::int64_t block = unit % blocks_;
  const std::int64_t conversion = unit / blocks_ % conversions_;
  const std::int64_t seed = unit / blocks_ / conversions_;
  const std::int64_t first = conversion * shared_ + block * unit_scenarios_;
  const std::int64_t count = std::min<std::int64_t>(
      unit_scenarios_, shared_ - block * unit_scenarios_);
  std::vector<std::int64_t> runs;
  runs.reserve(static_cast<std::size_t>(count * methods_));
  for (std::int64_t s = first; s < first + count; ++s) {
    for (std::int64_t m = 0; m < methods_; ++m) {
      runs.push_back((s * methods_ + m) * seeds_ + seed);
    }
  }
  return runs;
}

const std::array<const char*, kNumMetrics> kMetricNames = {
    "E_initial",       "E",
    "E_best",          "ratio",
    "E_zero",          "lambda_min",
    "lambda_max",      "lambda_best",
    "gain_error_rms",  "gain_error_max",
    "delay_error_rms", "delay_error_max",
    "change_proposed", "p_value",
    "relative_gap",    "E_limit",
    "named_exactly",   "interval_coverage"};

namespace {

// The columns before the metrics: the run's number and its coordinates.
int FirstMetric() { return 1 + static_cast<int>(CoordinateNames().size()); }

absl::StatusOr<std::vector<std::string>> SplitCsv(std::string_view line) {
  std::istringstream text{std::string(line)};
  CsvRows rows(text, "row");
  std::vector<std::string_view> fields;
  rows.Next(fields);
  MLE_RETURN_IF_ERROR(rows.status());
  return std::vector<std::string>(fields.begin(), fields.end());
}

absl::StatusOr<double> ParseNumber(const std::string& field,
                                   const std::string& column) {
  if (field.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  if (!absl::SimpleAtod(field, &value) || std::isnan(value)) {
    return InvalidArgument("column ", column, " holds '", field,
                           "', which is not a number");
  }
  return value;
}

}  // namespace

std::string NumberText(double value) {
  if (std::isnan(value)) return "";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

std::string CsvField(std::string_view text) {
  std::string field(text);
  for (char& c : field) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return QuoteCsvField(field);
}

std::vector<std::string> CoordinateNames() {
  return {"model",      "noise_variance", "drift_variance", "effects",
          "controller", "windows",        "mismatch",       "size",
          "ablation",   "estimator",      "selection",      "solver",
          "seed"};
}

std::vector<std::string> CoordinateTexts(const Campaign& campaign,
                                         const Coordinates& at) {
  const Mismatch& mismatch = campaign.mismatches[at.scenario.mismatch];
  const Method& method = campaign.methods[at.method];
  const Ablation* const ablation = campaign.ablations[at.scenario.ablation];
  return {
      campaign.models[at.scenario.model].name,
      NumberText(campaign.noise_variances[at.scenario.noise]),
      NumberText(campaign.drift_variances[at.scenario.drift]),
      campaign.effects[at.scenario.effects].name,
      campaign.controllers[at.scenario.controller].name,
      campaign.windows[at.scenario.windows].name,
      mismatch.name,
      NumberText(mismatch.size),
      ablation == nullptr ? "" : ablation->name,
      method.name(),
      method.selection < 0 ? "" : campaign.selections[method.selection].name,
      method.solver < 0 ? "" : campaign.solvers[method.solver].name,
      absl::StrCat(campaign.seeds[at.seed])};
}

std::string RowHeader() {
  return absl::StrCat("run,", absl::StrJoin(CoordinateNames(), ","), ",",
                      absl::StrJoin(kMetricNames, ","), ",status");
}

std::string RowStart(const Campaign& campaign, const Grid& grid,
                     std::int64_t run) {
  std::string start = absl::StrCat(run);
  for (const std::string& text : CoordinateTexts(campaign, grid.At(run))) {
    absl::StrAppend(&start, ",", CsvField(text));
  }
  return start;
}

std::string RowText(const Campaign& campaign, const Grid& grid,
                    const Row& row) {
  std::string line = RowStart(campaign, grid, row.run);
  for (const double value : row.values) {
    absl::StrAppend(&line, ",", NumberText(value));
  }
  absl::StrAppend(&line, ",", CsvField(row.status), ",",
                  absl::StrFormat("%.6f", row.seconds));
  return line;
}

absl::StatusOr<Row> ParseRow(std::string_view line) {
  MLE_ASSIGN_OR_RETURN(const std::vector<std::string> fields, SplitCsv(line));
  const int first = FirstMetric();
  const int needed = first + kNumMetrics + 2;
  const auto columns = static_cast<std::size_t>(needed);
  if (fields.size() != columns) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%d fields, where %d are needed", fields.size(), columns));
  }
  Row row;
  if (!absl::SimpleAtoi(fields[0], &row.run) || row.run < 0) {
    return InvalidArgument("'", fields[0], "' is not a number of a run");
  }
  for (int i = 0; i < kNumMetrics; ++i) {
    MLE_ASSIGN_OR_RETURN(row.values[i],
                         ParseNumber(fields[first + i], kMetricNames[i]));
  }
  row.status = fields[first + kNumMetrics];
  if (row.status.empty()) {
    return absl::InvalidArgumentError("the status is empty");
  }
  MLE_ASSIGN_OR_RETURN(row.seconds, ParseNumber(fields.back(), "seconds"));
  return row;
}

}  // namespace mle::experiment
