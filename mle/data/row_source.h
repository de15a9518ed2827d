// Rows of text, one by one, wherever they come from: a file, a long table,
// files joined, a query of a database. The first row is the header.
//
//   std::vector<std::string_view> fields;
//   while (rows.Next(fields)) { … }
//   MLE_RETURN_IF_ERROR(rows.status());

#ifndef MLE_DATA_ROW_SOURCE_H_
#define MLE_DATA_ROW_SOURCE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace mle {

class RowSource {
 public:
  // `source` opens every message. `is_table`: messages count rows, the first
  // below the header, not lines.
  explicit RowSource(std::string source, bool is_table = false)
      : source_(std::move(source)), is_table_(is_table) {}
  virtual ~RowSource() = default;

  // The fields of the next row; false at the end or at an error. They last
  // until the next call of a member that is not const.
  virtual bool Next(std::vector<std::string_view>& fields) = 0;
  // Skips a row, of a text a line, whatever it contains. False as Next().
  virtual bool SkipLine();
  // The first rows as a source of their own, from the next one on; what is
  // taken from it is not taken from this.
  virtual std::unique_ptr<RowSource> Preview() = 0;
  // From now on comments are passed over and counted, of texts that have some.
  virtual void set_skips_comments() {}
  virtual int comments() const { return 0; }
  // Bytes read of those that HistorianSource::bytes counts; negative: not
  // known.
  virtual std::int64_t bytes_read() const { return -1; }

  // OK, or what is wrong: it names source, line and column (the field, counted
  // from 1).
  const absl::Status& status() const { return status_; }
  const std::string& source() const { return source_; }
  bool is_table() const { return is_table_; }
  // Where the last row began, counted from 1.
  int line() const { return row_line_; }

  // "run.csv: line 3, column 2", the place of a field of the last row, or of
  // that which began in `line`. In rows of a table: "trend: row 2, column 2".
  std::string Place(int field) const { return PlaceIn(row_line_, field); }
  std::string PlaceIn(int line, int field) const;
  // "run.csv: line 3", of the last row, and "line 3".
  std::string LinePlace() const;
  std::string LineName(int line) const;

 protected:
  // Where a field of a row comes from, for rows that are made of others.
  virtual std::pair<int, int> Origin(int line, int field) const {
    return {line, field};
  }

  absl::Status status_;
  int row_line_ = 0;

 private:
  std::string source_;
  bool is_table_;
};

// "line 3"; of a table, whose header is not counted, "row 2" or "header".
std::string CsvLineName(int line, bool is_table);

// Rows in memory, field after field.
class RowBlock {
 public:
  void Add(std::string_view field);
  // Nothing is left but the memory.
  void Clear();

  std::size_t num_fields() const { return ends_.size(); }
  std::size_t bytes() const { return text_.size(); }
  // `count` fields from `first` on.
  void Get(std::size_t first, std::size_t count,
           std::vector<std::string_view>& fields) const;

 private:
  std::string text_;
  std::vector<std::size_t> ends_;  // of each field in text_
};

}  // namespace mle

#endif  // MLE_DATA_ROW_SOURCE_H_
