// Tables in memory on the way of files: historian_importer.h.

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/historian_importer.h"
#include "mle/data/record.h"
#include "mle/data/record_columns.h"
#include "mle/data/table_import.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

std::vector<double> BadNumbers(const HistorianOptions& options) {
  std::vector<double> numbers;
  for (const std::string& text : options.bad_values) {
    double number = 0.0;
    if (ReadCsvNumber(text, number)) numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

struct HistorianImporter::MatchedTable {
  // A column of samples, and where they go.
  struct Source {
    const TableColumn* column = nullptr;
    RecordColumn match;
    int value = 0;
  };

  const Table* table = nullptr;
  std::vector<Source> sources;
  std::vector<std::string> ignored;
  std::vector<double> bad_numbers;
  double origin = 0.0;
  double seconds_per_unit = 1.0;  // 1 where times are numbers

  double time(std::size_t k) const {
    return (table->times[k] - origin) / seconds_per_unit;
  }
};

absl::StatusOr<std::vector<HistorianImporter::MatchedTable>>
HistorianImporter::MatchTables(const std::vector<Table>& tables) {
  std::vector<MatchedTable> matched_tables;
  for (const Table& table : tables) {
    std::vector<std::string_view> header = {options_.columns.time_column};
    for (const TableColumn& column : table.columns) {
      header.push_back(column.name);
    }
    const absl::StatusOr<std::vector<RecordColumn>> columns =
        MatchHeader(header, channels_, options_.columns);
    if (!columns.ok()) return WithPrefix(columns.status(), table.name + ": ");
    MatchedTable& matched = matched_tables.emplace_back();
    matched.table = &table;
    matched.bad_numbers = BadNumbers(options_);
    for (std::size_t c = 1; c < columns->size(); ++c) {
      const RecordColumn& match = (*columns)[c];
      const TableColumn& column = table.columns[c - 1];
      const int value = ValueOf(match, channels_);
      if (value < 0) {
        matched.ignored.push_back(column.name);
        continue;
      }
      if (column.values == nullptr) {
        return InvalidArgument(
            table.name, ": column '", ShowCsvText(column.name), "' holds ",
            column.holds, "; it must hold numbers, with NaN for bad samples");
      }
      matched.sources.push_back({&column, match, value});
    }
  }
  return matched_tables;
}

// Finds for tables what Probe() finds for files.
absl::Status HistorianImporter::ProbeTables(
    const std::vector<MatchedTable>& tables) {
  constexpr std::size_t kProbeRows = 4096;
  std::vector<double> steps;
  for (const MatchedTable& matched : tables) {
    const Table& table = *matched.table;
    HistorianProbe& probe = probes_.emplace_back();
    probe.source.name = table.name;
    probe.source.is_table = true;
    probe.has_dates = table.has_dates;
    probe.clock.time_zone = table.time_zone;
    if (!table.has_dates) probe.first_time = matched.time(0);
    for (const MatchedTable::Source& source : matched.sources) {
      probe.has_set_points |= source.match.kind == Kind::kSetPoint;
    }
    const std::size_t rows = std::min(table.times.size(), kProbeRows);
    for (std::size_t k = 1; k < rows; ++k) {
      const double step = matched.time(k) - matched.time(k - 1);
      if (step > 0.0) steps.push_back(step);
    }
  }
  if (steps.empty() && tables[0].time(1) < tables[0].time(0)) {
    steps.push_back(tables[0].time(0) - tables[0].time(1));
  }
  if (steps.empty()) {
    return InvalidArgument(
        tables[0].table->name,
        ": no row is later than the one before it; a record needs at least 2 "
        "rows at different times");
  }
  if (probes_[0].has_dates) {
    import_.report.time_origin = tables[0].origin;
    import_.report.time_zone = probes_[0].clock.time_zone;
  }
  return ChooseSampleTime(steps);
}

class HistorianImporter::TableRows : public RowStream {
 public:
  // Counts bad samples in `reports`, by value.
  TableRows(const MatchedTable& matched, int num_values,
            std::vector<ChannelReport>& reports)
      : matched_(matched), num_values_(num_values), reports_(reports) {}

  bool Next(RecordRow& row) override;
  const absl::Status& status() const override { return status_; }
  std::string TimePlace() const override {
    return absl::StrCat(matched_.table->name, ": row ", rows_);
  }

 private:
  bool ReadSample(const MatchedTable::Source& from, double& value);

  const MatchedTable& matched_;
  const int num_values_;
  std::vector<ChannelReport>& reports_;
  std::size_t rows_ = 0;  // so far
  absl::Status status_;
};

bool HistorianImporter::TableRows::Next(RecordRow& row) {
  if (!status_.ok() || rows_ == matched_.table->times.size()) return false;
  row.time = matched_.time(rows_++);
  row.values.assign(static_cast<std::size_t>(num_values_), kNaN);
  return std::all_of(matched_.sources.begin(), matched_.sources.end(),
                     [&](const MatchedTable::Source& from) {
                       return ReadSample(from, row.values[from.value]);
                     });
}

bool HistorianImporter::TableRows::ReadSample(const MatchedTable::Source& from,
                                              double& value) {
  const double sample =
      from.column->values[static_cast<std::ptrdiff_t>(rows_ - 1) *
                          from.column->stride];
  BadSampleCounts& bad = reports_[from.value].bad;
  if (std::isnan(sample)) {
    ++bad.not_a_number;
    return true;
  }
  if (std::find(matched_.bad_numbers.begin(), matched_.bad_numbers.end(),
                sample) != matched_.bad_numbers.end()) {
    ++bad.declared;
    return true;
  }
  const bool has_unit = from.match.scale != 1.0 || from.match.offset != 0.0;
  value = has_unit ? from.match.scale * sample + from.match.offset : sample;
  if (std::abs(value) <= kLargestSample) return true;
  status_ =
      InvalidArgument(TimePlace(), ", column '", ShowCsvText(from.column->name),
                      "': ", sample, " is not a finite number of at most ",
                      kLargestSample, ", or NaN for a bad sample",
                      has_unit ? ", once its unit is converted" : "");
  return false;
}

absl::Status HistorianImporter::ReadTable(const MatchedTable& matched,
                                          const HistorianProbe& probe,
                                          Resampler& resampler) {
  for (const MatchedTable::Source& source : matched.sources) {
    NoteColumn(source.match);
  }
  const Table& table = *matched.table;
  FileReport report;
  report.name = table.name;
  report.time_form = table.has_dates ? "dates" : "numbers";
  report.num_ignored_columns = static_cast<int>(matched.ignored.size());
  report.ignored_columns = matched.ignored;
  report.ignored_columns.resize(
      std::min<std::size_t>(matched.ignored.size(), 20));
  TableRows rows(matched, num_values(), values_);
  MLE_RETURN_IF_ERROR(TakeRows(rows, probe, nullptr, report, resampler));
  import_.report.rows += report.rows;
  import_.report.files.push_back(std::move(report));
  return absl::OkStatus();
}

absl::StatusOr<HistorianImport> HistorianImporter::Run(
    const std::vector<Table>& tables) {
  MLE_ASSIGN_OR_RETURN(std::vector<MatchedTable> matched, MatchTables(tables));
  double seconds_per_unit = 1.0;
  if (tables[0].has_dates) {
    const auto seconds = SecondsPerUnit(channels_.time_unit());
    if (!seconds) {
      return InvalidArgument(
          tables[0].name, ": its times are dates, but the model's time unit '",
          channels_.time_unit(), "' is not one of ms, s, min, h and d");
    }
    seconds_per_unit = *seconds;
  }
  for (MatchedTable& one : matched) {
    if (!tables[0].has_dates) break;
    one.origin = tables[0].times[0];
    one.seconds_per_unit = seconds_per_unit;
  }
  MLE_RETURN_IF_ERROR(ProbeTables(matched));
  Resampler resampler = Begin();
  for (std::size_t i = 0; i < matched.size(); ++i) {
    MLE_RETURN_IF_ERROR(ReadTable(matched[i], probes_[i], resampler));
  }
  return End(resampler);
}

absl::StatusOr<HistorianImport> ImportTables(const std::vector<Table>& tables,
                                             const ProcessModel& channels,
                                             const HistorianOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate(channels));
  if (tables.empty()) {
    return absl::InvalidArgumentError("there is no table, 1 is needed");
  }
  if (!options.begin.empty() || !options.end.empty()) {
    return OptionError("begin,end",
                       "begin and end are not for tables in memory; cut them "
                       "before");
  }
  for (const Table& table : tables) {
    if (table.times.size() < 2) {
      return InvalidArgument(table.name, " has ", table.times.size(),
                             " rows; a record needs at least 2");
    }
    const bool finite =
        std::all_of(table.times.begin(), table.times.end(),
                    [](double time) { return std::isfinite(time); });
    if (!finite) {
      return InvalidArgument(table.name, ": a time is missing (NaN or NaT)");
    }
    if (table.has_dates != tables[0].has_dates) {
      return InvalidArgument(
          table.name, ": its times are ", table.has_dates ? "dates" : "numbers",
          ", those of ", tables[0].name, " are not; tables must agree");
    }
  }
  MLE_ASSIGN_OR_RETURN(HistorianImport import,
                       HistorianImporter(channels, options).Run(tables));
  if (!import.records.empty()) return import;
  return InvalidArgument(
      tables[0].name,
      ": no two samples follow each other without a gap longer than max_gap");
}

}  // namespace mle
