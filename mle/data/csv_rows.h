// Rows of a CSV file, one by one (RFC 4180).
//
// Fields are separated by commas. A field in double quotes may hold commas,
// line breaks and, doubled, quotes. Lines end with LF or CRLF; a byte-order
// mark is skipped, empty lines are passed over.
//
//   CsvRows rows(file, "run.csv");
//   std::vector<std::string> fields;
//   while (rows.Next(fields)) { … }
//   MLE_RETURN_IF_ERROR(rows.status());

#ifndef MLE_DATA_CSV_ROWS_H_
#define MLE_DATA_CSV_ROWS_H_

#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace mle {

class CsvRows {
 public:
  // `source` (the file's name) opens every message.
  CsvRows(std::istream& in, std::string source);

  // The fields of the next row; false at the end or at an error.
  bool Next(std::vector<std::string>& fields);

  // OK, or what is wrong with the text: a quote that is not closed or stands
  // inside an unquoted field, or a file that cannot be read. It names file,
  // line and column (the field, counted from 1).
  const absl::Status& status() const { return status_; }

  // Where the last row began, counted from 1.
  int line() const { return row_line_; }

  // "run.csv: line 3, column 2", the place of a field of the last row.
  std::string Place(int field) const;

 private:
  bool ReadLine();
  bool ParseRow(std::vector<std::string>& fields);
  bool ParseQuoted(std::size_t& at, std::string& field, int number);
  bool Fault(int field, std::string_view what);

  std::istream& in_;
  std::string source_;
  std::string text_;  // the present line, without its end
  int line_ = 0;
  int row_line_ = 0;
  absl::Status status_;
};

// A field in double quotes where that is needed.
std::string QuoteCsvField(std::string_view field);

}  // namespace mle

#endif  // MLE_DATA_CSV_ROWS_H_
