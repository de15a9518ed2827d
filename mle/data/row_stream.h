// Rows of a file in order of time, however the file has them. Internal to
// mle/data.

#ifndef MLE_DATA_ROW_STREAM_H_
#define MLE_DATA_ROW_STREAM_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "mle/data/record_rows.h"

namespace mle {

class RowStream {
 public:
  virtual ~RowStream() = default;

  // False at the end or at an error.
  virtual bool Next(RecordRow& row) = 0;
  virtual const absl::Status& status() const = 0;
  // "run.csv: line 3, column 1 ('time')", of the last row.
  virtual std::string TimePlace() const = 0;
};

// As they stand.
class FileOrder : public RowStream {
 public:
  // `rows` must outlive it.
  explicit FileOrder(RecordRows& rows) : rows_(rows) {}

  bool Next(RecordRow& row) override { return rows_.Next(row); }
  const absl::Status& status() const override { return rows_.status(); }
  std::string TimePlace() const override { return rows_.TimePlace(); }

 private:
  RecordRows& rows_;
};

// The last row first. Holds all of them: 8 bytes for each value and row, of at
// most `max_rows`.
class LastRowFirst : public RowStream {
 public:
  LastRowFirst(RecordRows& rows, std::int64_t max_rows);

  bool Next(RecordRow& row) override;
  const absl::Status& status() const override { return status_; }
  std::string TimePlace() const override;

 private:
  RecordRows& rows_;
  std::vector<double> times_;
  std::vector<double> values_;
  std::vector<int> lines_;
  std::size_t num_values_ = 0;
  int line_ = 0;  // of the last row
  absl::Status status_;
};

// Empty fields are values that have not changed since the row above, and
// between two rows nothing has changed either: rows are put there at each step
// after the first row. Rows more than 1000 steps apart leave a gap.
class HeldRows : public RowStream {
 public:
  HeldRows(std::unique_ptr<RowStream> rows, double step);

  bool Next(RecordRow& row) override;
  const absl::Status& status() const override { return rows_->status(); }
  std::string TimePlace() const override { return rows_->TimePlace(); }

 private:
  bool Read();

  std::unique_ptr<RowStream> rows_;
  double step_;
  bool has_last_ = false;
  bool has_next_ = false;
  double first_time_ = 0.0;
  double index_ = 0.0;  // of the step that was put there last
  RecordRow last_;
  RecordRow next_;
};

}  // namespace mle

#endif  // MLE_DATA_ROW_STREAM_H_
