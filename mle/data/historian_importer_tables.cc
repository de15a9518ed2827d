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

std::string PlaceIn(const Table& table, std::size_t row) {
  return absl::StrCat(table.name, ": row ", row + 1);
}

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
        return absl::InvalidArgumentError(absl::StrCat(
            table.name, ": column '", ShowCsvText(column.name), "' holds ",
            column.holds, "; it must hold numbers, with NaN for bad samples"));
      }
      matched.sources.push_back({&column, match, value});
    }
  }
  return matched_tables;
}

// What Probe() finds out of files.
absl::Status HistorianImporter::ProbeTables(
    const std::vector<MatchedTable>& tables) {
  constexpr std::size_t kProbeRows = 4096;
  std::vector<double> steps;
  for (const MatchedTable& matched : tables) {
    const Table& table = *matched.table;
    HistorianProbe& probe = probes_.emplace_back();
    probe.source.name = table.name;
    probe.has_dates = table.has_dates;
    probe.clock.time_zone = table.time_zone;
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
    return absl::InvalidArgumentError(absl::StrCat(
        tables[0].table->name,
        ": no row is later than the one before it; a record needs at least 2 "
        "rows at different times"));
  }
  if (probes_[0].has_dates) {
    import_.report.time_origin = tables[0].origin;
    import_.report.time_zone = probes_[0].clock.time_zone;
  }
  return ChooseSampleTime(steps);
}

absl::Status HistorianImporter::ReadSample(const MatchedTable& matched,
                                           std::size_t source, std::size_t k,
                                           double& value) {
  const MatchedTable::Source& from = matched.sources[source];
  const double sample =
      from.column->values[static_cast<std::ptrdiff_t>(k) * from.column->stride];
  value = kNaN;
  BadSampleCounts& bad = values_[from.value].bad;
  if (std::isnan(sample)) {
    ++bad.not_a_number;
    return absl::OkStatus();
  }
  if (std::find(matched.bad_numbers.begin(), matched.bad_numbers.end(),
                sample) != matched.bad_numbers.end()) {
    ++bad.declared;
    return absl::OkStatus();
  }
  const bool has_unit = from.match.scale != 1.0 || from.match.offset != 0.0;
  value = has_unit ? from.match.scale * sample + from.match.offset : sample;
  if (std::abs(value) <= kLargestSample) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      PlaceIn(*matched.table, k), ", column '", ShowCsvText(from.column->name),
      "': ", sample, " is not a finite number of at most ", kLargestSample,
      ", or NaN for a bad sample",
      has_unit ? ", once its unit is converted" : ""));
}

void HistorianImporter::NoteTable(const MatchedTable& matched) {
  for (const MatchedTable::Source& source : matched.sources) {
    NoteColumn(source.match);
  }
  const Table& table = *matched.table;
  FileReport& file = import_.report.files.emplace_back();
  file.name = table.name;
  file.time_form = table.has_dates ? "dates" : "numbers";
  file.rows = static_cast<std::int64_t>(table.times.size());
  file.first_time = matched.time(0);
  file.last_time = matched.time(table.times.size() - 1);
  file.num_ignored_columns = static_cast<int>(matched.ignored.size());
  file.ignored_columns = matched.ignored;
  file.ignored_columns.resize(
      std::min<std::size_t>(matched.ignored.size(), 20));
  import_.report.rows += file.rows;
}

absl::Status HistorianImporter::CheckOrder(const MatchedTable& matched,
                                           std::size_t k, double time,
                                           bool& skip) {
  skip = has_last_ && !(time > last_time_);
  if (!skip) return absl::OkStatus();
  HistorianReport& report = import_.report;
  const bool is_repeated = time == last_time_;
  if (is_repeated ? options_.skip_repeated_times
                  : options_.skip_backward_times) {
    ++(is_repeated ? report.repeated_rows : report.backward_rows);
    return absl::OkStatus();
  }
  const TimeNames times = report.Times(channels_.time_unit());
  const char* const option =
      is_repeated ? "skip_repeated_times" : "skip_backward_times";
  return OptionError(
      option,
      absl::StrCat(
          PlaceIn(*matched.table, k), ": time ", times.Short(time), " ",
          is_repeated ? "stands twice"
                      : absl::StrCat("follows ", times.Short(last_time_)),
          "; times must increase, or such rows be ignored (", option,
          " = true)"));
}

absl::Status HistorianImporter::ReadTable(const MatchedTable& matched,
                                          Resampler& resampler) {
  RecordRow row;
  for (std::size_t k = 0; k < matched.table->times.size(); ++k) {
    row.time = matched.time(k);
    bool skip = false;
    MLE_RETURN_IF_ERROR(CheckOrder(matched, k, row.time, skip));
    if (skip) continue;
    has_last_ = true;
    last_time_ = row.time;
    row.values.assign(num_values(), kNaN);
    for (std::size_t s = 0; s < matched.sources.size(); ++s) {
      MLE_RETURN_IF_ERROR(
          ReadSample(matched, s, k, row.values[matched.sources[s].value]));
    }
    if (!TakeRow(row, resampler)) {
      return absl::InvalidArgumentError(
          absl::StrCat(PlaceIn(*matched.table, k), TooManySamples()));
    }
  }
  return absl::OkStatus();
}

// Every row is a sample, each Δt from the first on. The resampler would take
// each as it is; without it a table is copied once.
bool HistorianImporter::IsEven(const MatchedTable& matched) const {
  constexpr double kSnap = 0.01;  // of Δt, as in resampler.cc
  const HistorianReport& report = import_.report;
  const std::size_t rows = matched.table->times.size();
  // A step is rounded, and Δt may be given with all its digits.
  if (std::abs(report.step / report.sample_time - 1.0) > 1e-5 ||
      static_cast<std::int64_t>(rows) > options_.max_samples) {
    return false;
  }
  for (std::size_t k = 0; k < rows; ++k) {
    const double at = (matched.time(k) - matched.time(0)) / report.sample_time;
    if (!(std::abs(at - static_cast<double>(k)) <= kSnap)) return false;
  }
  return true;
}

// `usable` becomes false where a row has no good sample at all: that leaves a
// gap, as rows that are not there do.
absl::Status HistorianImporter::CopyTable(const MatchedTable& matched,
                                          Record& record, bool& usable) {
  constexpr std::size_t kRowsAtOnce = 1024;  // which stay in the cache
  const std::size_t rows = matched.table->times.size();
  const auto samples = static_cast<Eigen::Index>(rows);
  record.start_time = matched.time(0);
  record.sample_time = import_.report.sample_time;
  record.outputs.resize(channels_.num_outputs(), samples);
  record.inputs.resize(channels_.num_inputs(), samples);
  if (probes_[0].has_set_points) {
    record.set_points.setConstant(channels_.num_outputs(), samples, kNaN);
  }
  std::vector<int> good(kRowsAtOnce);
  for (std::size_t begin = 0; begin < rows && usable; begin += kRowsAtOnce) {
    const std::size_t end = std::min(begin + kRowsAtOnce, rows);
    std::fill(good.begin(), good.end(), 0);
    for (std::size_t s = 0; s < matched.sources.size(); ++s) {
      const RecordColumn& column = matched.sources[s].match;
      const bool is_input = column.kind == Kind::kInput;
      Eigen::MatrixXd& matrix = is_input ? record.inputs
                                : column.kind == Kind::kOutput
                                    ? record.outputs
                                    : record.set_points;
      for (std::size_t k = begin; k < end; ++k) {
        double& value = matrix(column.channel, static_cast<Eigen::Index>(k));
        MLE_RETURN_IF_ERROR(ReadSample(matched, s, k, value));
        if (std::isnan(value)) continue;
        // A mean of inputs has no negative zero.
        if (is_input) value += 0.0;
        ++good[k - begin];
        ++good_[matched.sources[s].value];
      }
    }
    usable =
        std::find(good.begin(),
                  good.begin() + static_cast<std::ptrdiff_t>(end - begin),
                  0) == good.begin() + static_cast<std::ptrdiff_t>(end - begin);
  }
  return absl::OkStatus();
}

// Whether the table was taken without the resampler.
absl::StatusOr<bool> HistorianImporter::TakeEvenTable(
    const MatchedTable& matched) {
  if (!IsEven(matched)) return false;
  Record record;
  bool usable = true;
  MLE_RETURN_IF_ERROR(CopyTable(matched, record, usable));
  if (usable) {
    collector_->Take(std::move(record));
    return true;
  }
  std::fill(good_.begin(), good_.end(), 0);
  for (ChannelReport& channel : values_) channel.bad = {};
  return false;
}

absl::StatusOr<HistorianImport> HistorianImporter::Run(
    const std::vector<Table>& tables) {
  MLE_ASSIGN_OR_RETURN(std::vector<MatchedTable> matched, MatchTables(tables));
  double seconds_per_unit = 1.0;
  if (tables[0].has_dates) {
    const auto seconds = SecondsPerUnit(channels_.time_unit());
    if (!seconds) {
      return absl::InvalidArgumentError(absl::StrCat(
          tables[0].name, ": its times are dates, but the model's time unit '",
          channels_.time_unit(), "' is not one of ms, s, min, h and d"));
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
  for (const MatchedTable& one : matched) NoteTable(one);
  bool taken = false;
  if (matched.size() == 1) {
    MLE_ASSIGN_OR_RETURN(taken, TakeEvenTable(matched[0]));
  }
  for (const MatchedTable& one : matched) {
    if (!taken) MLE_RETURN_IF_ERROR(ReadTable(one, resampler));
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
      return absl::InvalidArgumentError(
          absl::StrCat(table.name, " has ", table.times.size(),
                       " rows; a record needs at least 2"));
    }
    const bool finite =
        std::all_of(table.times.begin(), table.times.end(),
                    [](double time) { return std::isfinite(time); });
    if (!finite) {
      return absl::InvalidArgumentError(
          absl::StrCat(table.name, ": a time is missing (NaN or NaT)"));
    }
    if (table.has_dates != tables[0].has_dates) {
      return absl::InvalidArgumentError(absl::StrCat(
          table.name, ": its times are ", table.has_dates ? "dates" : "numbers",
          ", those of ", tables[0].name, " are not; tables must agree"));
    }
  }
  MLE_ASSIGN_OR_RETURN(HistorianImport import,
                       HistorianImporter(channels, options).Run(tables));
  if (!import.records.empty()) return import;
  return absl::InvalidArgumentError(absl::StrCat(
      tables[0].name,
      ": no two samples follow each other without a gap longer than max_gap"));
}

}  // namespace mle
