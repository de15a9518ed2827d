// Rows of a record file as times and samples.
//
// A row of values has the p outputs, their p set points and the m inputs; NaN
// where a sample is bad or its column is missing.
//
//   MLE_ASSIGN_OR_RETURN(RecordRows rows,
//                        RecordRows::Open(csv, channels, options, clock));
//   RecordRow row;
//   while (rows.Next(row)) { … }
//   MLE_RETURN_IF_ERROR(rows.status());

#ifndef MLE_DATA_RECORD_ROWS_H_
#define MLE_DATA_RECORD_ROWS_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/record_clock.h"
#include "mle/data/record_columns.h"
#include "mle/data/row_source.h"
#include "mle/data/time_range.h"
#include "mle/model/process_model.h"

namespace mle {

struct RecordRowsOptions {
  ColumnOptions columns;
  char decimal = '.';
  // Values that mark a bad sample, as text or as a number ("-9999", which
  // -9999.0 is too).
  std::vector<std::string> bad_values;
  // Words for bad samples, whatever their case.
  std::vector<std::string> bad_words;
  // Any other text that is not a number is a bad sample too. If false it is an
  // error, which counts the words.
  bool any_word_is_bad = false;
  // Values of quality columns that mean good, whatever their case; numbers by
  // value. All others mean bad.
  std::vector<std::string> good_qualities;
  // Rows to skip below the header (of units, say).
  int rows_below_header = 0;
  // Other rows are passed over.
  TimeRange range = {};
};

// A NaN that stands for an empty field, which may mean that nothing has changed
// (row_stream.h). All others are bad samples.
double NoSample();
bool IsNoSample(double value);

struct RecordRow {
  double time = 0.0;
  std::vector<double> values;  // 2p + m
};

class RecordRows {
 public:
  // Takes the header. `csv` and `clock` must outlive the rows. InvalidArgument
  // as of MatchHeader() and RowSource.
  static absl::StatusOr<RecordRows> Open(RowSource& csv,
                                         const ProcessModel& channels,
                                         const RecordRowsOptions& options,
                                         RecordClock& clock);

  // False at the end or at an error: a malformed row, one with more or fewer
  // fields than the header, or a field that is not a time or not a number.
  bool Next(RecordRow& row);
  const absl::Status& status() const { return status_; }

  const std::vector<RecordColumn>& columns() const { return columns_; }
  // "run.csv: line 3, column 1 ('time')", of the last row.
  std::string TimePlace() const { return TimePlaceOf(csv_->line()); }
  // The same of another row, which began in `line`.
  std::string TimePlaceOf(int line) const;
  int line() const { return csv_->line(); }
  // Rows outside of the range.
  std::int64_t passed_over() const { return passed_over_; }
  // Comments, and the header again, as files joined have it.
  std::int64_t comments() const { return csv_->comments() + repeated_headers_; }
  // By value.
  const std::vector<BadSampleCounts>& bad() const { return bad_; }
  // The first few values of quality columns that were not good.
  const std::vector<std::string>& bad_qualities() const {
    return bad_qualities_;
  }

 private:
  // Words and numbers in a list of texts.
  struct Vocabulary {
    std::vector<double> numbers;
    std::vector<std::string> texts;
    bool ignores_case = false;

    Vocabulary(const std::vector<std::string>& list, bool case_ignored);
    bool Contains(std::string_view text) const;
    bool Contains(double number) const;
  };

  RecordRows(RowSource& csv, const RecordRowsOptions& options,
             RecordClock& clock);

  bool ReadSample(std::string_view field, double& sample,
                  BadSampleCounts& bad) const;
  bool IsHeader() const;
  std::string_view TimeText();
  bool ReadTime(RecordRow& row);
  bool ReadSamples(RecordRow& row);
  bool NotASample(std::size_t c);
  std::string UnknownWords();
  bool IsGood(const RecordColumn& column, std::string_view text) const;
  void TakeQuality(RecordRow& row);
  bool NotReadable(std::size_t c, std::string_view wanted);

  RowSource* csv_;
  RecordClock* clock_;
  char decimal_;
  Vocabulary bad_values_;
  Vocabulary bad_words_;
  bool any_word_is_bad_;
  Vocabulary good_qualities_;
  bool has_usual_qualities_;
  std::map<std::string, double> word_values_;
  TimeRange range_;
  std::int64_t passed_over_ = 0;
  std::vector<RecordColumn> columns_;
  std::vector<int> value_of_;  // of each column: where its sample goes, or −1
  int time_column_ = 0;
  int time_part_ = -1;  // the rest of the time; −1: none
  std::string joined_time_;
  int repeated_headers_ = 0;
  int num_values_ = 0;
  bool has_quality_ = false;
  std::vector<std::string_view> fields_;
  std::vector<BadSampleCounts> bad_;
  std::vector<std::string> bad_qualities_;
  absl::Status status_;
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_ROWS_H_
