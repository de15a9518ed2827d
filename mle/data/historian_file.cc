#include "mle/data/historian_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_format.h"
#include "mle/data/usual_step.h"

namespace mle {
namespace {

constexpr std::size_t kProbeRows = 4096;
constexpr std::size_t kMaxIgnoredNames = 20;

// Names that a header may have.
absl::StatusOr<std::vector<std::string>> NamesOf(const ProcessModel& channels,
                                                 const ColumnOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> columns,
                       ColumnsOf(channels));
  std::vector<std::string> names = {options.time_column};
  for (const RecordColumn& column : columns) names.push_back(column.name);
  for (const TagMapping& tag : options.tags) names.push_back(tag.tag);
  return names;
}

// Of the rows that are looked at, one in ten may be out of order.
bool IsNewestFirst(const std::vector<double>& times) {
  std::size_t earlier = 0;
  std::size_t later = 0;
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] < times[k - 1]) ++earlier;
    if (times[k] > times[k - 1]) ++later;
  }
  return earlier > 10 * later;
}

// Numbers of no declared unit may be Excel's: days such as 45355, apart by what
// is a second or more of a day, but next to nothing in the model's unit.
absl::Status CheckUnit(const RecordClock& clock, const std::string& source,
                       double first, const std::vector<double>& steps) {
  constexpr double kFirstDay = 32874.0;  // 1990
  constexpr double kLastDay = 54789.0;   // 2050
  constexpr double kSecondsPerDay = 86400.0;
  if (!clock.has_assumed_unit() || clock.has_dates() || steps.empty() ||
      first < kFirstDay || first > kLastDay) {
    return absl::OkStatus();
  }
  const double step = UsualStep(steps);
  if (step * clock.seconds_per_unit().value_or(1.0) > 0.5 ||
      step * kSecondsPerDay < 0.9) {
    return absl::OkStatus();
  }
  return OptionError(
      "time_format",
      absl::StrCat(source, ": times such as ", first, ", ", step,
                   " apart, look like the days of Excel; declare time_format = "
                   "excel, or time_format = numbers if they are none"));
}

}  // namespace

absl::Status HistorianFile::SkipToHeader(const HistorianOptions& options) {
  for (int line = 0; line < options.lines_above_header; ++line) {
    if (csv_->SkipLine()) continue;
    MLE_RETURN_IF_ERROR(csv_->status());
    return absl::InvalidArgumentError(absl::StrCat(
        report_.name, ": line ", line + 1, ", column 1: the file ends, with ",
        options.lines_above_header, " lines declared above its header"));
  }
  header_line_ = options.lines_above_header + 1;
  // Spreadsheets name the separator in a line of its own: "sep=;".
  const std::string_view head = csv_->Peek();
  if (head.size() >= 6 &&
      (head.starts_with("sep=") || head.starts_with("SEP=")) &&
      (head[5] == '\n' || head[5] == '\r')) {
    report_.separator = head[4];
    csv_->SkipLine();
    ++header_line_;
  }
  return csv_->status();
}

absl::Status HistorianFile::Recognise(const ProcessModel& channels,
                                      const HistorianOptions& options) {
  report_.separator = 0;
  MLE_RETURN_IF_ERROR(SkipToHeader(options));
  CsvHead head;
  head.text = std::string(csv_->Peek());
  head.is_whole = csv_->at_end();
  head.source = report_.name;
  head.line = header_line_;
  MLE_RETURN_IF_ERROR(csv_->status());
  if (options.separator != 0) report_.separator = options.separator;
  if (report_.separator == 0) {
    MLE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         NamesOf(channels, options.columns));
    MLE_ASSIGN_OR_RETURN(report_.separator, RecogniseSeparator(head, names));
  }
  csv_->set_separator(report_.separator);
  report_.decimal = options.decimal;
  if (report_.decimal != 0) return absl::OkStatus();
  report_.decimal = '.';
  // Errors in the header are those of RecordRows::Open().
  std::istringstream in(head.text);
  CsvRows rows(in, report_.name, options.limits);
  rows.set_separator(report_.separator);
  std::vector<std::string_view> header;
  if (!rows.Next(header)) return absl::OkStatus();
  ColumnOptions lenient = options.columns;
  lenient.ignore_other_columns = true;
  const absl::StatusOr<std::vector<RecordColumn>> columns =
      MatchHeader(header, channels, lenient);
  if (!columns.ok()) return absl::OkStatus();
  for (int row = 0; row < options.rows_below_header; ++row) rows.SkipLine();
  MLE_ASSIGN_OR_RETURN(report_.decimal,
                       RecogniseDecimal(head, report_.separator, *columns));
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<HistorianFile>> HistorianFile::Open(
    const HistorianSource& source, const ProcessModel& channels,
    const HistorianOptions& options, const ClockOptions& clock_options,
    std::optional<double> origin) {
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<std::istream> in, source.open());
  MLE_ASSIGN_OR_RETURN(
      RecordClock clock,
      RecordClock::Create(channels.time_unit(), clock_options));
  clock.set_origin(origin);
  std::unique_ptr<HistorianFile> file(
      new HistorianFile(std::move(in), std::move(clock)));
  file->report_.name = source.name;
  file->csv_ =
      std::make_unique<CsvRows>(*file->in_, source.name, options.limits);
  MLE_RETURN_IF_ERROR(file->Recognise(channels, options));

  RecordRowsOptions row_options;
  row_options.columns = options.columns;
  row_options.decimal = file->report_.decimal;
  row_options.bad_values = options.bad_values;
  row_options.bad_words = KnownBadWords();
  row_options.good_qualities = options.good_qualities;
  row_options.rows_below_header = options.rows_below_header;
  MLE_ASSIGN_OR_RETURN(
      RecordRows rows,
      RecordRows::Open(*file->csv_, channels, row_options, file->clock_));
  for (const RecordColumn& column : rows.columns()) {
    if (column.kind != RecordColumn::Kind::kOther) continue;
    ++file->report_.num_ignored_columns;
    if (file->report_.ignored_columns.size() < kMaxIgnoredNames) {
      file->report_.ignored_columns.push_back(ShowCsvText(column.name));
    }
  }
  file->rows_ = std::move(rows);
  return file;
}

absl::StatusOr<HistorianProbe> ProbeHistorian(const HistorianSource& source,
                                              const ProcessModel& channels,
                                              const HistorianOptions& options,
                                              const ClockOptions& clock) {
  MLE_ASSIGN_OR_RETURN(
      const std::unique_ptr<HistorianFile> file,
      HistorianFile::Open(source, channels, options, clock, std::nullopt));
  HistorianProbe probe;
  probe.source = source;
  probe.clock = clock;
  for (const RecordColumn& column : file->rows().columns()) {
    probe.has_set_points |= column.kind == RecordColumn::Kind::kSetPoint;
  }
  RecordRow row;
  std::vector<double> times;
  while (times.size() < kProbeRows && file->rows().Next(row)) {
    times.push_back(row.time);
    if (times.size() == 2) file->clock().set_descending(times[1] < times[0]);
  }
  MLE_RETURN_IF_ERROR(file->rows().status());
  if (times.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(source.name, ": line ", file->rows().line(),
                     ", column 1: there is no row below the header; a record "
                     "needs samples"));
  }
  probe.newest_first = IsNewestFirst(times);
  double first = probe.newest_first ? times.back() : times.front();
  if (probe.newest_first) {
    while (file->rows().Next(row)) first = row.time;
    MLE_RETURN_IF_ERROR(file->rows().status());
    std::reverse(times.begin(), times.end());
  }
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) probe.steps.push_back(times[k] - times[k - 1]);
  }
  MLE_RETURN_IF_ERROR(
      CheckUnit(file->clock(), source.name, first, probe.steps));
  probe.time_form = file->clock().form_name();
  probe.has_dates = file->clock().has_dates();
  if (probe.has_dates) {
    probe.origin = file->clock().origin().value_or(0.0) +
                   first * file->clock().seconds_per_unit().value_or(1.0);
  } else {
    probe.first_time = first;
  }
  return probe;
}

HistorianSource FileSource(const std::string& path) {
  return {
      path, [path]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
        std::error_code error;
        using std::filesystem::file_type;
        const file_type type = std::filesystem::status(path, error).type();
        if (type != file_type::regular) {
          // Why, if it is not there or is a folder.
          if (type == file_type::not_found || type == file_type::directory) {
            MLE_RETURN_IF_ERROR(ReadFile(path).status());
          }
          return absl::FailedPreconditionError(absl::StrCat(
              "cannot read '", path,
              "': it must be a regular file, as it is read twice"));
        }
        auto in = std::make_unique<std::ifstream>(path, std::ios::binary);
        if (!*in) {
          MLE_RETURN_IF_ERROR(ReadFile(path).status());
          return absl::UnavailableError(
              absl::StrCat("cannot read '", path, "'"));
        }
        return in;
      }};
}

HistorianSource TextSource(std::string name, std::string text) {
  return {std::move(name),
          [text = std::move(
               text)]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
            return std::make_unique<std::istringstream>(text);
          }};
}

}  // namespace mle
