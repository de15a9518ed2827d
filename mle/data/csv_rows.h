// Rows of a CSV file, one by one (RFC 4180).
//
// Fields are separated by commas, or by another separator. A field in double
// quotes may hold separators, line breaks and, doubled, quotes. Lines end with
// LF or CRLF; a byte-order mark and empty lines are skipped.
//
// The file is read in blocks, and fields are views into the present block:
// memory does not depend on the file's length, and a file that is not text in
// rows (an endless line, binary, UTF-16) is refused before it uses any.
//
//   CsvRows rows(file, "run.csv");
//   std::vector<std::string_view> fields;
//   while (rows.Next(fields)) { … }
//   MLE_RETURN_IF_ERROR(rows.status());

#ifndef MLE_DATA_CSV_ROWS_H_
#define MLE_DATA_CSV_ROWS_H_

#include <array>
#include <cstddef>
#include <functional>
#include <istream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace mle {

struct CsvLimits {
  std::size_t max_row_bytes = std::size_t{1} << 20;
  int max_columns = 10000;
};

// "line 3"; of a table, whose header is not counted, "row 2" or "header".
std::string CsvLineName(int line, bool is_table);

class CsvRows {
 public:
  // `source` (the file's name) opens every message.
  CsvRows(std::istream& in, std::string source, CsvLimits limits = {});

  // A comma until this is called.
  void set_separator(char separator);
  char separator() const { return separator_; }

  // The fields of the next row; false at the end or at an error. They last
  // until the next call of a member that is not const.
  bool Next(std::vector<std::string_view>& fields);

  // What comes next, without taking it: the rest of the present block, or, at
  // the start, the whole first one. Cut somewhere.
  std::string_view Peek();

  // Stands above the text: the first row of Next(), before any is read.
  void set_header(std::vector<std::string> names) {
    header_ = std::move(names);
  }
  // From now on lines that begin with # are passed over and counted, but for
  // the errors of spreadsheets (#N/A).
  void set_skips_comments() { skips_comments_ = true; }
  int comments() const { return comments_; }

  // Skips a line, whatever it contains. False as Next().
  bool SkipLine();

  // OK, or what is wrong with the text: a quote that is not closed or stands
  // inside an unquoted field, a NUL byte, a carriage return inside a line, a
  // row or a number of columns beyond the limits, or a file that cannot be
  // read. It names file, line and column (the field, counted from 1).
  const absl::Status& status() const { return status_; }

  // Where the last row began, counted from 1.
  int line() const { return row_line_; }

  const std::string& source() const { return source_; }

  // Nothing is left to be read from the file but what Peek() shows.
  bool at_end() const { return at_end_; }

  // "run.csv: line 3, column 2", the place of a field of the last row, or of
  // that which began in `line`. In rows of a table: "trend: row 2, column 2".
  std::string Place(int field) const { return PlaceIn(row_line_, field); }
  std::string PlaceIn(int line, int field) const;

  // "run.csv: line 3", of the last row, and "line 3".
  std::string LinePlace() const;
  std::string LineName(int line) const { return CsvLineName(line, is_table_); }

  // For text that was made from another file: where a field of a line came
  // from, as line and column of that file.
  using Origin = std::function<std::pair<int, int>(int line, int field)>;
  void set_origin(Origin origin) { origin_ = std::move(origin); }

  // The text is a table that was not a file (a query of a database): messages
  // count its rows, one in each line, below the header.
  void set_is_table(bool is_table) { is_table_ = is_table; }
  // Why the stream turned bad(), where it can say more than that.
  void set_fault(std::function<absl::Status()> fault) {
    fault_ = std::move(fault);
  }

 private:
  enum class Scan { kRow, kEmptyLine, kMore, kFault };
  struct Field {
    std::size_t begin = 0;  // in buffer_, without quotes
    std::size_t end = 0;
    bool escaped = false;  // has doubled quotes or carriage returns in it
  };

  bool Fill();
  Scan ScanRow();
  Scan ScanQuoted(std::size_t& at, Field& field);
  Scan ScanEnd(std::size_t at);
  void Unescape(Field& field);
  Scan Fault(std::string_view what);

  std::istream& in_;
  std::string source_;
  CsvLimits limits_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of what is not yet taken
  std::size_t end_ = 0;    // of what has been read
  bool at_end_ = false;    // of the file
  bool started_ = false;
  std::array<bool, 256> is_special_{};  // ends a run of plain characters
  char separator_ = ',';

  // Of the row that is scanned.
  std::vector<Field> fields_;
  std::size_t next_ = 0;  // where the next row begins
  int lines_ = 0;         // that the row takes

  std::vector<std::string> header_;
  std::vector<std::string> taken_header_;  // which `fields` refer to
  bool skips_comments_ = false;
  int comments_ = 0;
  Origin origin_;
  bool is_table_ = false;
  std::function<absl::Status()> fault_;

  int line_ = 1;  // at begin_
  int row_line_ = 0;
  absl::Status status_;
};

// A field in double quotes where that is needed.
std::string QuoteCsvField(std::string_view field);

// Whether `text` is UTF-8 throughout.
bool IsUtf8(std::string_view text);

// `text` for a message: cut if long, its control characters and what is not
// UTF-8 as \x01.
std::string ShowCsvText(std::string_view text);
// The same between ' and '.
std::string QuotedCsvText(std::string_view text);

}  // namespace mle

#endif  // MLE_DATA_CSV_ROWS_H_
