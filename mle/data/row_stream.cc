#include "mle/data/row_stream.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace mle {

LastRowFirst::LastRowFirst(RecordRows& rows, std::int64_t max_rows)
    : rows_(rows) {
  RecordRow row;
  while (rows_.Next(row)) {
    if (static_cast<std::int64_t>(lines_.size()) == max_rows) {
      status_ = absl::InvalidArgumentError(
          absl::StrCat(rows_.TimePlace(),
                       ": the newest rows stand first, and there are "
                       "more than ",
                       max_rows,
                       "; turn the file round before it is read, or "
                       "read less at once"));
      return;
    }
    times_.push_back(row.time);
    lines_.push_back(rows_.line());
    values_.insert(values_.end(), row.values.begin(), row.values.end());
    num_values_ = row.values.size();
  }
  status_ = rows_.status();
}

bool LastRowFirst::Next(RecordRow& row) {
  if (!status_.ok() || lines_.empty()) return false;
  row.time = times_.back();
  row.values.assign(values_.end() - static_cast<std::ptrdiff_t>(num_values_),
                    values_.end());
  line_ = lines_.back();
  times_.pop_back();
  lines_.pop_back();
  values_.resize(values_.size() - num_values_);
  return true;
}

namespace {

constexpr double kLongestHold = 1000.0;  // steps
constexpr double kStepSnap = 1e-6;       // of a step

}  // namespace

HeldRows::HeldRows(std::unique_ptr<RowStream> rows, double step)
    : rows_(std::move(rows)), step_(step) {}

// The next row of the file, its empty fields filled.
bool HeldRows::Read() {
  if (!rows_->Next(next_)) return false;
  for (std::size_t v = 0; v < next_.values.size(); ++v) {
    if (has_last_ && IsNoSample(next_.values[v])) {
      next_.values[v] = last_.values[v];
    }
  }
  if (!has_last_) first_time_ = next_.time;
  index_ = std::floor((last_.time - first_time_) / step_ + kStepSnap) + 1.0;
  has_next_ = true;
  return true;
}

bool HeldRows::Next(RecordRow& row) {
  if (!has_next_ && !Read()) return false;
  const double held = first_time_ + index_ * step_;
  if (has_last_ && held < next_.time - kStepSnap * step_ &&
      next_.time - last_.time <= kLongestHold * step_) {
    row.time = held;
    row.values = last_.values;
    index_ += 1.0;
    return true;
  }
  row = next_;
  last_ = next_;
  has_last_ = true;
  has_next_ = false;
  return true;
}

std::string LastRowFirst::TimePlace() const { return rows_.TimePlaceOf(line_); }

}  // namespace mle
