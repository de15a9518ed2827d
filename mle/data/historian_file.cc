#include "mle/data/historian_file.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_format.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/header_lines.h"
#include "mle/data/long_table.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

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

// A text that is not one would be answered by columns that are missing.
absl::Status CheckIsTable(const std::string& source, int first_line,
                          std::string_view head,
                          const std::vector<std::string>& names) {
  std::vector<std::string> known = names;
  const std::vector<std::string>& times = UsualTimeColumns();
  known.insert(known.end(), times.begin(), times.end());
  const std::size_t text = head.find_first_not_of(" \t\r\n");
  if (text == std::string_view::npos || LooksLikeTable(head, known)) {
    return absl::OkStatus();
  }
  const auto blank_lines = static_cast<int>(
      std::count(head.begin(), head.begin() + static_cast<int>(text), '\n'));
  head.remove_prefix(text);
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": line ", first_line + blank_lines,
      ": this is not a table of records: no line has names of columns, "
      "separated by commas, semicolons or tabs, with numbers below them. The "
      "text begins with '",
      ShowCsvText(head.substr(0, head.find_first_of("\r\n"))), "'"));
}

}  // namespace

double HistorianFile::FractionRead() const {
  const std::streamoff at =
      in_->rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
  if (bytes_ <= 0 || at < 0) return -1.0;
  return std::min(static_cast<double>(at) / static_cast<double>(bytes_), 1.0);
}

absl::Status HistorianFile::SkipToHeader(
    const HistorianOptions& options, const std::vector<std::string>& names) {
  const auto skip = [&](int lines) {
    for (int line = 0; line < lines; ++line, ++header_line_) {
      if (csv_->SkipLine()) continue;
      MLE_RETURN_IF_ERROR(csv_->status());
      return OptionError(
          "lines_above_header",
          absl::StrCat(
              report_.name, ": line ", line + 1,
              ", column 1: the file ends, with lines_above_header = ", lines));
    }
    return absl::OkStatus();
  };
  MLE_RETURN_IF_ERROR(skip(options.lines_above_header));
  // Spreadsheets name the separator in a line of its own: "sep=;".
  const std::string_view head = csv_->Peek();
  if (head.size() >= 6 &&
      (head.starts_with("sep=") || head.starts_with("SEP=")) &&
      (head[5] == '\n' || head[5] == '\r')) {
    report_.separator = head[4];
    MLE_RETURN_IF_ERROR(skip(1));
  }
  MLE_RETURN_IF_ERROR(csv_->status());
  if (options.lines_above_header > 0) return absl::OkStatus();
  MLE_RETURN_IF_ERROR(
      CheckIsTable(report_.name, header_line_, csv_->Peek(), names));
  const int titles = TitleLines(csv_->Peek(), names);
  if (titles > 0) {
    notes_.push_back({absl::StrCat(report_.name, ": ", titles,
                                   titles == 1 ? " line" : " lines",
                                   " above the header passed over."),
                      "lines_above_header"});
  }
  return skip(titles);
}

CsvHead HistorianFile::Head() {
  CsvHead head;
  head.text = std::string(csv_->Peek());
  head.is_whole = csv_->at_end();
  head.source = report_.name;
  head.line = header_line_;
  head.is_table = is_table_;
  return head;
}

absl::Status HistorianFile::RecogniseTable(const ProcessModel& channels,
                                           const HistorianOptions& options) {
  report_.separator = 0;
  MLE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                       NamesOf(channels, options.columns));
  std::vector<std::string> all = LongColumnNames(options.columns);
  all.insert(all.end(), names.begin(), names.end());
  if (is_table_) {
    report_.separator = ',';
  } else {
    MLE_RETURN_IF_ERROR(SkipToHeader(options, all));
  }
  const CsvHead head = Head();
  MLE_RETURN_IF_ERROR(csv_->status());
  if (options.separator != 0 && !is_table_) {
    report_.separator = options.separator;
  }
  if (report_.separator == 0) {
    MLE_ASSIGN_OR_RETURN(report_.separator, RecogniseSeparator(head, all));
  }
  csv_->set_separator(report_.separator);
  return WidenLongTable(head, names, options);
}

// A long table is read whole and put in the place of the file.
absl::Status HistorianFile::WidenLongTable(
    const CsvHead& head, const std::vector<std::string>& names,
    const HistorianOptions& options) {
  std::istringstream start(head.text);
  CsvRows first(start, report_.name, options.limits);
  first.set_separator(report_.separator);
  std::vector<std::string_view> header;
  if (!first.Next(header)) return absl::OkStatus();
  const std::optional<LongColumns> columns =
      FindLongColumns(header, names, options.columns);
  if (!columns) return absl::OkStatus();
  csv_->Next(header);
  MLE_ASSIGN_OR_RETURN(WideTable table,
                       WidenTable(*csv_, *columns, names, options, clock_));
  notes_.push_back({absl::StrCat(report_.name,
                                 ": a long table, with a row for "
                                 "each sample, of ",
                                 table.tags.size(), " tags."),
                    ""});
  is_sparse_ = !table.is_complete;
  bytes_ = static_cast<std::int64_t>(table.text.size());
  in_ = std::make_unique<std::istringstream>(std::move(table.text));
  csv_ = std::make_unique<CsvRows>(*in_, report_.name, options.limits);
  csv_->set_origin(std::move(table.origin));
  csv_->set_is_table(is_table_);
  header_line_ = 1;
  return absl::OkStatus();
}

// The decimal mark, and rows of units below the header.
absl::Status HistorianFile::RecogniseRows(const ProcessModel& channels,
                                          const HistorianOptions& options) {
  rows_below_header_ = is_table_ ? 0 : options.rows_below_header;
  report_.decimal = options.decimal == 0 ? '.' : options.decimal;
  // Errors in the header are those of RecordRows::Open().
  const CsvHead head = Head();
  std::istringstream in(head.text);
  CsvRows rows(in, report_.name, options.limits);
  rows.set_separator(csv_->separator());
  std::vector<std::string_view> header;
  if (!rows.Next(header)) return absl::OkStatus();
  ColumnOptions lenient = options.columns;
  lenient.ignore_other_columns = true;
  const absl::StatusOr<std::vector<RecordColumn>> columns =
      MatchHeader(header, channels, lenient);
  if (!columns.ok()) return absl::OkStatus();
  if (options.rows_below_header == 0 && !is_table_) {
    rows_below_header_ = UnitRows(rows, *columns, clock_);
    if (rows_below_header_ > 0) {
      notes_.push_back({absl::StrCat(report_.name, ": ", rows_below_header_,
                                     rows_below_header_ == 1 ? " row" : " rows",
                                     " below the header passed over, as ",
                                     "without time and numbers."),
                        "rows_below_header"});
    }
  }
  if (options.decimal != 0) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(report_.decimal,
                       RecogniseDecimal(head, csv_->separator(), *columns));
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<HistorianFile>> HistorianFile::Start(
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
  file->is_table_ = source.is_table;
  file->bytes_ = source.bytes;
  file->csv_->set_is_table(source.is_table);
  file->csv_->set_fault(source.fault);
  MLE_RETURN_IF_ERROR(file->RecogniseTable(channels, options));
  return file;
}

absl::StatusOr<HistorianColumns> HistorianFile::Columns(
    const HistorianSource& source, const ProcessModel& channels,
    const HistorianOptions& options) {
  MLE_ASSIGN_OR_RETURN(
      const std::unique_ptr<HistorianFile> file,
      Start(source, channels, options,
            options.clocks.empty() ? options.clock : options.clocks[0],
            std::nullopt));
  // The first row that is as long as the one below it, for titles above a
  // header of which no name is known.
  std::vector<std::string> header;
  std::vector<std::string> below;
  std::vector<std::string_view> fields;
  while (header.size() < 2 || header.size() != below.size()) {
    if (!file->csv_->Next(fields)) break;
    header = std::move(below);
    below.assign(fields.begin(), fields.end());
  }
  MLE_RETURN_IF_ERROR(file->csv_->status());
  if (header.empty()) header.swap(below);
  below.resize(header.size());
  const bool has_units =
      !file->is_table_ &&
      std::none_of(below.begin(), below.end(), [](std::string_view text) {
        return text.find_first_of("0123456789") != std::string_view::npos;
      });
  const std::vector<std::string> times =
      LongColumnNames({.time_column = options.columns.time_column});
  HistorianColumns columns;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const std::string name(TrimCsvField(header[c]));
    const std::string folded = FoldedName(name);
    const auto& suffixes = options.columns.quality_suffixes;
    const bool is_other =
        folded.empty() || folded == FoldedName(options.columns.time_column) ||
        std::find(times.begin(), times.end(), folded) != times.end() ||
        std::any_of(suffixes.begin(), suffixes.end(),
                    [&](const std::string& suffix) {
                      return !suffix.empty() && name.ends_with(suffix);
                    });
    if (is_other) continue;
    columns.names.push_back(name);
    columns.units.emplace_back(has_units ? TrimCsvField(below[c]) : "");
  }
  return columns;
}

absl::StatusOr<std::unique_ptr<HistorianFile>> HistorianFile::Open(
    const HistorianSource& source, const ProcessModel& channels,
    const HistorianOptions& options, const ClockOptions& clock,
    std::optional<double> origin) {
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<HistorianFile> file,
                       Start(source, channels, options, clock, origin));
  MLE_RETURN_IF_ERROR(file->RecogniseRows(channels, options));

  RecordRowsOptions row_options;
  row_options.columns = options.columns;
  row_options.decimal = file->report_.decimal;
  row_options.bad_values = options.bad_values;
  row_options.bad_words = KnownBadWords();
  row_options.any_word_is_bad = options.any_word_is_bad;
  row_options.good_qualities = options.good_qualities;
  row_options.rows_below_header = file->rows_below_header_;
  MLE_ASSIGN_OR_RETURN(row_options.range,
                       TimeRange::Create(options.begin, options.end, clock));
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

}  // namespace mle
