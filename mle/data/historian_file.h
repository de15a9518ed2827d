// One file of a historian, opened: its form recognised, its header matched, its
// rows ready to be read. Internal to mle/data.

#ifndef MLE_DATA_HISTORIAN_FILE_H_
#define MLE_DATA_HISTORIAN_FILE_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/csv_rows.h"
#include "mle/data/historian.h"
#include "mle/data/record_clock.h"
#include "mle/data/record_rows.h"
#include "mle/data/row_source.h"
#include "mle/model/process_model.h"

namespace mle {

// Columns of samples: those that are neither times nor qualities. Of a long
// table its tags.
struct HistorianColumns {
  std::vector<std::string> names;
  std::vector<std::string> units;  // in a row below the header; empty: none
  // As the file has it.
  std::vector<std::string> header;
  char separator = ',';
  std::string time_column;  // of two columns, with a plus between them
  bool is_long = false;     // the header is that of the table made of it

  // The one column of samples, which may have the usual name of any value;
  // empty: the file has no tag, or several.
  std::string OnlyValue() const;
};

// The rows of a source; of a text with this separator.
absl::StatusOr<std::unique_ptr<RowSource>> OpenRows(
    const HistorianSource& source, char separator, const CsvLimits& limits);

class HistorianFile {
 public:
  // Dates count from `origin`, or from the first in the file. `clock` is the
  // one of this file.
  static absl::StatusOr<std::unique_ptr<HistorianFile>> Open(
      const HistorianSource& source, const ProcessModel& channels,
      const HistorianOptions& options, const ClockOptions& clock,
      std::optional<double> origin);

  // Columns of samples, whatever their names.
  static absl::StatusOr<HistorianColumns> Columns(
      const HistorianSource& source, const ProcessModel& channels,
      const HistorianOptions& options);

  RecordRows& rows() { return *rows_; }
  const RecordClock& clock() const { return clock_; }
  RecordClock& clock() { return clock_; }
  // Name, separator, decimal mark and ignored columns.
  const FileReport& report() const { return report_; }
  // Notes on what was recognised in the file.
  const std::vector<ImportNote>& notes() const { return notes_; }
  // A long table whose tags have samples at times of their own.
  bool is_sparse() const { return is_sparse_; }
  // Rows of a long table that are left out: at a time already read, comments.
  std::int64_t repeated_rows() const { return repeated_rows_; }
  std::int64_t comment_rows() const { return comment_rows_; }
  // Share of the text that has been read; negative: not known.
  double FractionRead() const;

 private:
  explicit HistorianFile(RecordClock clock) : clock_(std::move(clock)) {}

  static absl::StatusOr<std::unique_ptr<HistorianFile>> Start(
      const HistorianSource& source, const ProcessModel& channels,
      const HistorianOptions& options, const ClockOptions& clock,
      std::optional<double> origin);
  absl::Status SkipToHeader(const HistorianOptions& options,
                            const std::vector<std::string>& names);
  // The header and those rows below it that are whole.
  std::vector<std::vector<std::string>> FirstRows();
  std::string HeaderPlace() const;
  absl::Status TakeHeader(const std::vector<std::string>& names);
  absl::Status RecogniseText(const HistorianOptions& options,
                             const std::vector<std::string>& names);
  absl::Status RecogniseColumns(const std::vector<std::string>& names,
                                const HistorianOptions& options);
  absl::Status WidenLongTable(const std::vector<std::string>& names,
                              HistorianOptions options);
  absl::Status CheckUnderstood();
  absl::Status RecogniseRows(const ProcessModel& channels,
                             const HistorianOptions& options);
  absl::Status RecogniseTable(const ProcessModel& channels,
                              const HistorianOptions& options);

  RecordClock clock_;
  std::unique_ptr<RowSource> source_;
  CsvRows* csv_ = nullptr;  // the source, where it is a text
  std::optional<RecordRows> rows_;
  ColumnOptions columns_;  // with the name of the time that was recognised
  FileReport report_;
  std::vector<ImportNote> notes_;
  std::int64_t bytes_ = 0;  // of the text; 0: not known
  int header_line_ = 1;
  bool has_given_header_ = false;
  int rows_below_header_ = 0;
  bool is_long_ = false;
  bool is_sparse_ = false;
  std::int64_t repeated_rows_ = 0;
  std::int64_t comment_rows_ = 0;
};

// Properties of a file that its first rows show.
struct HistorianProbe {
  HistorianSource source;
  ClockOptions clock;
  std::string time_form;
  bool newest_first = false;
  std::vector<ImportNote> notes;
  bool is_unchanged = false;  // an empty field is the value above it
  double empty_share = 0.0;   // of the fields that are looked at
  bool has_dates = false;
  bool has_set_points = false;
  double origin = 0.0;      // seconds since the epoch of its earliest date
  double first_time = 0.0;  // the earliest, in the model's unit; 0 of dates
  // For each value of a long table whose tags have times of their own: how far
  // its first samples are apart, 0 where that varies.
  std::vector<double> sample_steps;
  // Among the first rows: those at a time already read, how many rows a time
  // usually has, and how far these times usually are apart.
  int repeated_rows = 0;
  int rows_of_time = 1;
  double time_step = 0.0;
  std::vector<double> steps;  // of the first rows, those above 0
};

// InvalidArgument for a file without rows, and as of Open().
absl::StatusOr<HistorianProbe> ProbeHistorian(const HistorianSource& source,
                                              const ProcessModel& channels,
                                              const HistorianOptions& options,
                                              const ClockOptions& clock);

}  // namespace mle

#endif  // MLE_DATA_HISTORIAN_FILE_H_
