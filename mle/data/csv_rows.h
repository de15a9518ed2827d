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
#include <cstdint>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mle/data/import_options.h"
#include "mle/data/row_source.h"

namespace mle {

class CsvRows : public RowSource {
 public:
  // `source` is the file's name.
  CsvRows(std::istream& in, std::string source, CsvLimits limits = {});
  CsvRows(std::unique_ptr<std::istream> in, std::string source,
          CsvLimits limits = {});

  // A comma until this is called.
  void set_separator(char separator);
  char separator() const { return separator_; }

  bool Next(std::vector<std::string_view>& fields) override;
  // The rows of the text that Peek() shows, as far as its lines are whole.
  std::unique_ptr<RowSource> Preview() override;

  // The text that comes next, without taking it: the rest of the present block,
  // or, at the start, the whole first one. Its last line may be cut.
  std::string_view Peek();

  // Stands above the text: the first row of Next(), before any is read.
  void set_header(std::vector<std::string> names) {
    header_ = std::move(names);
  }
  // From now on lines that begin with # are passed over and counted, but for
  // the errors of spreadsheets (#N/A).
  void set_skips_comments() override { skips_comments_ = true; }
  int comments() const override { return comments_; }
  std::int64_t bytes_read() const override;

  bool SkipLine() override;

  // Errors of status(): a quote that is not closed or stands inside an unquoted
  // field, a NUL byte, a carriage return inside a line, a row or a number of
  // columns beyond the limits, a file that cannot be read.

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

  std::unique_ptr<std::istream> owned_;
  std::istream& in_;
  CsvLimits limits_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of what is not yet taken
  std::size_t end_ = 0;    // of what has been read
  bool at_end_ = false;    // of the file
  bool started_ = false;
  std::array<bool, 256> is_special_{};  // ends a run of plain characters
  char separator_ = ',';

  // State of the row that is scanned.
  std::vector<Field> fields_;
  std::size_t next_ = 0;  // where the next row begins
  int lines_ = 0;         // that the row takes

  std::vector<std::string> header_;
  std::vector<std::string> taken_header_;  // which `fields` refer to
  bool skips_comments_ = false;
  int comments_ = 0;

  int line_ = 1;  // at begin_
};

// A field in double quotes where that is needed, with an apostrophe before what
// a spreadsheet would compute (names such as "=1+1"), which TrimCsvField()
// removes.
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
