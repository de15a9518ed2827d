// Rows of a file in order of time, however the file has them. Internal to
// mle/data.

#ifndef MLE_DATA_ROW_STREAM_H_
#define MLE_DATA_ROW_STREAM_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
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
// after the first row. Rows more than 1000 steps apart leave a gap. Values that
// are points are not held: each stands at the next step, and nowhere else.
class HeldRows : public RowStream {
 public:
  HeldRows(std::unique_ptr<RowStream> rows, double step,
           std::vector<bool> is_point = {});

  bool Next(RecordRow& row) override;
  const absl::Status& status() const override { return rows_->status(); }
  std::string TimePlace() const override { return rows_->TimePlace(); }

 private:
  bool Read();
  void TakePoints(std::vector<double>& values);

  std::unique_ptr<RowStream> rows_;
  double step_;
  std::vector<bool> is_point_;
  std::vector<double> points_;  // that wait for their step
  bool has_last_ = false;
  bool has_next_ = false;
  double first_time_ = 0.0;
  double index_ = 0.0;  // of the step that was put there last
  RecordRow last_;
  RecordRow next_;
};

// Rows of one time, whose seconds are lost, spread evenly until the next time;
// across a gap, and after the last time, over the usual step. Of a first time
// with fewer rows than usual the first ones are missing.
class SpreadRows : public RowStream {
 public:
  // `step`: how far times usually are apart, > 0; `usual`: rows of a time.
  SpreadRows(std::unique_ptr<RowStream> rows, double step, int usual)
      : rows_(std::move(rows)), step_(step), usual_(usual) {}

  bool Next(RecordRow& row) override;
  const absl::Status& status() const override {
    return status_.ok() ? rows_->status() : status_;
  }
  std::string TimePlace() const override { return rows_->TimePlace(); }

  // Rows whose times were changed.
  std::int64_t spread() const { return spread_; }

 private:
  bool Fill();

  std::unique_ptr<RowStream> rows_;
  double step_;
  int usual_;
  std::deque<RecordRow> ready_;
  std::optional<RecordRow> next_;  // of another time than those that are ready
  bool is_first_ = true;
  std::int64_t spread_ = 0;
  absl::Status status_;
};

}  // namespace mle

#endif  // MLE_DATA_ROW_STREAM_H_
