#include "mle/data/historian_file.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_format.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/long_table.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"
#include "mle/data/time_columns.h"
#include "mle/data/wide_rows.h"

namespace mle {
namespace {

constexpr std::size_t kMaxIgnoredNames = 20;

// Names that a header may have.
absl::StatusOr<std::vector<std::string>> NamesOf(const ProcessModel& channels,
                                                 const ColumnOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> columns,
                       ColumnsOf(channels));
  std::vector<std::string> names = {options.time_column};
  if (const auto parts = SplitTimeName(options.time_column, {})) {
    names.push_back(parts->first);
    names.push_back(parts->second);
  }
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
  return InvalidArgument(
      source, ": line ", first_line + blank_lines,
      ": this is not a table of records: no line has names of columns, "
      "separated by commas, semicolons or tabs, with numbers below them. The "
      "text begins with '",
      ShowCsvText(head.substr(0, head.find_first_of("\r\n"))), "'");
}

bool HasSuffix(const std::string& name,
               const std::vector<std::string>& suffixes) {
  return std::any_of(suffixes.begin(), suffixes.end(),
                     [&](const std::string& suffix) {
                       return !suffix.empty() && name.ends_with(suffix);
                     });
}

// Whether a name is that of qualities, of all columns or of another one.
bool IsQualityOfAny(const std::string& name,
                    const std::vector<std::string>& header) {
  std::vector<std::string_view> others;
  for (const std::string& other : header) {
    if (other != name) others.emplace_back(other);
  }
  return QualityOfName(name, others).has_value();
}

// Samples where names of columns should be.
absl::Status CheckNames(const std::string& place,
                        const std::vector<std::string>& header,
                        const std::vector<std::string>& names,
                        const RecordClock& clock) {
  std::set<std::string> known;
  for (const std::string& name : names) known.insert(FoldedName(name));
  std::size_t samples = 0;
  std::size_t fields = 0;
  for (const std::string& field : header) {
    if (known.contains(FoldedName(field))) return absl::OkStatus();
    if (field.empty()) continue;
    ++fields;
    if (IsSampleField(field, clock)) ++samples;
  }
  if (samples < 2 || 3 * samples < 2 * fields) return absl::OkStatus();
  return OptionError(
      "header,lines_above_header",
      absl::StrCat(place, ": there is no header: samples (",
                   ListOfNames({header.begin(), header.begin() + 2}),
                   ", …) stand where names of columns should. Put a line of ",
                   header.size(),
                   " names above them, or give the names: header = "
                   "time,…"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<RowSource>> OpenRows(
    const HistorianSource& source, char separator, const CsvLimits& limits) {
  if (source.open_rows) return source.open_rows();
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<std::istream> in, source.open());
  auto rows = std::make_unique<CsvRows>(std::move(in), source.name, limits);
  rows->set_separator(separator);
  return rows;
}

double HistorianFile::FractionRead() const {
  const std::int64_t at = source_->bytes_read();
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
  if (options.lines_above_header > 0 || !options.header.empty()) {
    return absl::OkStatus();
  }
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

std::vector<std::vector<std::string>> HistorianFile::FirstRows() {
  constexpr std::size_t kRows = 2000;
  std::vector<std::vector<std::string>> first;
  const std::unique_ptr<RowSource> rows = source_->Preview();
  std::vector<std::string_view> fields;
  while (first.size() < kRows && rows->Next(fields)) {
    std::vector<std::string> row;
    for (const std::string_view field : fields) {
      row.emplace_back(first.empty() && row.empty() ? WithoutHash(field)
                                                    : TrimCsvField(field));
    }
    first.push_back(std::move(row));
  }
  return first;
}

// "run.csv: line 3".
std::string HistorianFile::HeaderPlace() const {
  const int line = has_given_header_ ? header_line_ - 1 : header_line_;
  return absl::StrCat(report_.name, ": ", source_->LineName(std::max(line, 1)));
}

// Where the header of a text stands, and what separates its fields.
absl::Status HistorianFile::RecogniseText(
    const HistorianOptions& options, const std::vector<std::string>& names) {
  report_.separator = 0;
  MLE_RETURN_IF_ERROR(SkipToHeader(options, names));
  const std::string head(csv_->Peek());
  MLE_RETURN_IF_ERROR(csv_->status());
  if (options.separator != 0) report_.separator = options.separator;
  if (report_.separator == 0) {
    MLE_ASSIGN_OR_RETURN(
        report_.separator,
        RecogniseSeparator(head, report_.name, header_line_, names));
  }
  csv_->set_separator(report_.separator);
  return absl::OkStatus();
}

absl::Status HistorianFile::RecogniseTable(const ProcessModel& channels,
                                           const HistorianOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                       NamesOf(channels, options.columns));
  std::vector<std::string> all = LongColumnNames(options.columns);
  all.insert(all.end(), names.begin(), names.end());
  if (csv_ != nullptr) MLE_RETURN_IF_ERROR(RecogniseText(options, all));
  if (!options.header.empty()) MLE_RETURN_IF_ERROR(TakeHeader(options.header));
  MLE_RETURN_IF_ERROR(RecogniseColumns(all, options));
  return WidenLongTable(names, options);
}

// Names that are given in place of a header.
absl::Status HistorianFile::TakeHeader(const std::vector<std::string>& names) {
  const auto fault = [&](const std::string& what) {
    return OptionError("header", absl::StrCat(report_.name, ": ", what));
  };
  if (csv_ == nullptr) return fault("header is not for tables of databases");
  const auto first = FirstRows();
  if (!first.empty() && first[0].size() != names.size()) {
    return fault(absl::StrCat("header has ", names.size(), " names, line ",
                              header_line_, " has ", first[0].size(),
                              " fields"));
  }
  csv_->set_header(names);
  has_given_header_ = true;
  return absl::OkStatus();
}

// That there is a header, and which of its columns is the time.
absl::Status HistorianFile::RecogniseColumns(
    const std::vector<std::string>& names, const HistorianOptions& options) {
  columns_ = options.columns;
  if (csv_ == nullptr) return absl::OkStatus();
  std::vector<std::vector<std::string>> rows = FirstRows();
  if (rows.empty()) return absl::OkStatus();
  const std::vector<std::string> header = std::move(rows[0]);
  rows.erase(rows.begin());
  if (options.header.empty()) {
    MLE_RETURN_IF_ERROR(CheckNames(HeaderPlace(), header, names, clock_));
  }
  if (columns_.time_column != ColumnOptions().time_column) {
    return absl::OkStatus();
  }
  const std::optional<std::string> name =
      RecogniseTimeColumn(header, rows, clock_);
  if (!name || *name == columns_.time_column) return absl::OkStatus();
  columns_.time_column = *name;
  notes_.push_back(
      {absl::StrCat(report_.name, ": the time is ", QuotedCsvText(*name), "."),
       "time_column"});
  return absl::OkStatus();
}

// A long table is read whole and put in the place of the file.
absl::Status HistorianFile::WidenLongTable(
    const std::vector<std::string>& names, HistorianOptions options) {
  options.columns = columns_;
  std::vector<std::vector<std::string>> first = FirstRows();
  if (first.empty()) return absl::OkStatus();
  const std::vector<std::string> header = std::move(first[0]);
  first.erase(first.begin());
  const absl::StatusOr<std::optional<LongColumns>> columns =
      FindLongColumns(header, first, names, options.columns);
  if (!columns.ok()) {
    return WithPrefix(columns.status(), HeaderPlace() + ": ");
  }
  if (!*columns) return absl::OkStatus();
  std::vector<std::string_view> fields;
  source_->Next(fields);
  MLE_ASSIGN_OR_RETURN(
      std::unique_ptr<WideRows> table,
      WideRows::Read(*source_, header, **columns, names, options, clock_));
  repeated_rows_ = table->counts().repeated_rows;
  comment_rows_ = table->counts().comment_rows;
  notes_.push_back({absl::StrCat(report_.name,
                                 ": a long table, with a row for "
                                 "each sample, of ",
                                 table->counts().tags, " tags."),
                    ""});
  is_long_ = true;
  is_sparse_ = !table->counts().is_complete;
  bytes_ = table->counts().rows;
  source_ = std::move(table);
  csv_ = nullptr;
  header_line_ = 1;
  has_given_header_ = false;
  return absl::OkStatus();
}

// The decimal mark, and rows of units below the header.
absl::Status HistorianFile::RecogniseRows(const ProcessModel& channels,
                                          const HistorianOptions& options) {
  rows_below_header_ = csv_ == nullptr ? 0 : options.rows_below_header;
  report_.decimal = options.decimal == 0 ? '.' : options.decimal;
  // Errors in the header are those of RecordRows::Open().
  const std::unique_ptr<RowSource> rows = source_->Preview();
  std::vector<std::string_view> header;
  if (!rows->Next(header)) return absl::OkStatus();
  ColumnOptions lenient = columns_;
  lenient.ignore_other_columns = true;
  const absl::StatusOr<std::vector<RecordColumn>> columns =
      MatchHeader(header, channels, lenient);
  if (!columns.ok()) return absl::OkStatus();
  if (options.rows_below_header == 0 && csv_ != nullptr) {
    rows_below_header_ = UnitRows(*rows, *columns, clock_);
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
                       RecogniseDecimal(*source_->Preview(), *columns));
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<HistorianFile>> HistorianFile::Start(
    const HistorianSource& source, const ProcessModel& channels,
    const HistorianOptions& options, const ClockOptions& clock_options,
    std::optional<double> origin) {
  MLE_ASSIGN_OR_RETURN(
      RecordClock clock,
      RecordClock::Create(channels.time_unit(), clock_options));
  clock.set_origin(origin);
  std::unique_ptr<HistorianFile> file(new HistorianFile(std::move(clock)));
  file->report_.name = source.name;
  MLE_ASSIGN_OR_RETURN(file->source_, OpenRows(source, ',', options.limits));
  if (!source.open_rows) {
    file->csv_ = static_cast<CsvRows*>(file->source_.get());
  }
  file->bytes_ = source.bytes;
  MLE_RETURN_IF_ERROR(file->RecogniseTable(channels, options));
  return file;
}

// That a table has a time and samples in columns of their own, as far as can be
// said without names that are known.
absl::Status HistorianFile::CheckUnderstood() {
  std::vector<std::vector<std::string>> rows = FirstRows();
  if (rows.size() < 2) return absl::OkStatus();
  const std::vector<std::string> header = std::move(rows[0]);
  rows.erase(rows.begin());
  const auto fault = [&](const char* options, const std::string& what) {
    return OptionError(
        options, absl::StrCat(HeaderPlace(), ": ", what, ". The header has ",
                              ListOfNames(header)));
  };
  std::vector<std::string> names;
  std::size_t numbers = 0;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const auto count = [&](const auto& is) {
      return std::count_if(rows.begin(), rows.end(), [&](const auto& row) {
        return c < row.size() && is(row[c]);
      });
    };
    const auto most = static_cast<std::ptrdiff_t>((rows.size() + 1) / 2);
    if (IsQualityOfAny(header[c], header)) continue;
    if (count([&](const std::string& text) {
          return !text.empty() && !IsSampleField(text, clock_);
        }) > most) {
      names.push_back(header[c]);
    } else if (count([](const std::string& text) {
                 double number = 0.0;
                 return ReadCsvNumber(text, number) ||
                        ReadCsvNumber(text, number, ',');
               }) > most) {
      ++numbers;
    }
  }
  if (!names.empty() && numbers <= names.size()) {
    return fault(
        "tag_column,value_column,time_column",
        absl::StrCat("this may be a table with a row for each sample, with "
                     "tags in ",
                     ListOfNames(names),
                     ": then name tag_column, value_column and time_column"));
  }
  const std::string& time = columns_.time_column;
  const std::vector<std::string>& usual = UsualTimeColumns();
  const bool has_time =
      SplitTimeName(time, header).has_value() ||
      std::any_of(header.begin(), header.end(), [&](const std::string& name) {
        const std::string folded = FoldedName(name);
        return folded == FoldedName(time) ||
               std::find(usual.begin(), usual.end(), folded) != usual.end();
      });
  if (has_time) return absl::OkStatus();
  return fault("time_column",
               "no column is known to hold the time: name it with time_column");
}

absl::StatusOr<HistorianColumns> HistorianFile::Columns(
    const HistorianSource& source, const ProcessModel& channels,
    const HistorianOptions& options) {
  MLE_ASSIGN_OR_RETURN(
      const std::unique_ptr<HistorianFile> file,
      Start(source, channels, options,
            options.clocks.empty() ? options.clock : options.clocks[0],
            std::nullopt));
  MLE_RETURN_IF_ERROR(file->CheckUnderstood());
  // The first row that is as long as the one below it, for titles above a
  // header of which no name is known.
  std::vector<std::string> header;
  std::vector<std::string> below;
  std::vector<std::string_view> fields;
  while (header.size() < 2 || header.size() != below.size()) {
    if (!file->source_->Next(fields)) break;
    header = std::move(below);
    below.assign(fields.begin(), fields.end());
  }
  MLE_RETURN_IF_ERROR(file->source_->status());
  if (header.empty()) header.swap(below);
  below.resize(header.size());
  const bool has_units =
      file->csv_ != nullptr &&
      std::none_of(below.begin(), below.end(), [](std::string_view text) {
        return text.find_first_of("0123456789") != std::string_view::npos;
      });
  const std::vector<std::string> times =
      LongColumnNames({.time_column = options.columns.time_column});
  const std::string& named = file->columns_.time_column;
  const std::pair<std::string, std::string> time =
      SplitTimeName(named, header).value_or(std::pair(named, named));
  HistorianColumns columns;
  columns.header = header;
  columns.separator = file->report_.separator;
  columns.time_column = named;
  columns.is_long = file->is_long_;
  for (std::size_t c = 0; c < header.size(); ++c) {
    const std::string name(TrimCsvField(header[c]));
    const std::string folded = FoldedName(name);
    const auto& suffixes = options.columns.quality_suffixes;
    const bool is_quality =
        AreUsualSuffixes(suffixes) && IsQualityOfAny(name, header);
    const bool is_other =
        is_quality || folded.empty() || folded == FoldedName(time.first) ||
        folded == FoldedName(time.second) ||
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
  row_options.columns = file->columns_;
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
      RecordRows::Open(*file->source_, channels, row_options, file->clock_));
  std::vector<std::string> qualities;
  for (const RecordColumn& column : rows.columns()) {
    // A column that ends with a declared suffix needs no note.
    if (column.kind == RecordColumn::Kind::kQuality &&
        !HasSuffix(column.name, options.columns.quality_suffixes)) {
      qualities.push_back(column.name);
    }
    if (column.kind != RecordColumn::Kind::kOther) continue;
    ++file->report_.num_ignored_columns;
    if (file->report_.ignored_columns.size() < kMaxIgnoredNames) {
      file->report_.ignored_columns.push_back(ShowCsvText(column.name));
    }
  }
  if (!qualities.empty()) {
    file->notes_.push_back(
        {absl::StrCat(source.name, ": ", ListOfNames(qualities),
                      qualities.size() == 1 ? " says" : " say",
                      " how good samples are."),
         "quality_suffixes"});
  }
  file->rows_ = std::move(rows);
  return file;
}

}  // namespace mle
