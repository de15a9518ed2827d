#include "mle/data/row_stream.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {

LastRowFirst::LastRowFirst(RecordRows& rows, std::int64_t max_rows)
    : rows_(rows) {
  RecordRow row;
  while (rows_.Next(row)) {
    if (static_cast<std::int64_t>(lines_.size()) == max_rows) {
      status_ = InvalidArgument(rows_.TimePlace(),
                                ": the newest rows stand first, and there are "
                                "more than ",
                                max_rows,
                                "; turn the file round before it is read, or "
                                "read less at once");
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

HeldRows::HeldRows(std::unique_ptr<RowStream> rows, double step,
                   std::vector<bool> is_point)
    : rows_(std::move(rows)), step_(step), is_point_(std::move(is_point)) {}

// Those that wait, at a step.
void HeldRows::TakePoints(std::vector<double>& values) {
  for (std::size_t v = 0; v < points_.size(); ++v) {
    if (!is_point_[v]) continue;
    values[v] = points_[v];
    points_[v] = kNaN;
  }
}

// The next row of the file, its empty fields filled.
bool HeldRows::Read() {
  if (!rows_->Next(next_)) return false;
  is_point_.resize(next_.values.size(), false);
  points_.resize(next_.values.size(), kNaN);
  for (std::size_t v = 0; v < next_.values.size(); ++v) {
    if (is_point_[v]) continue;
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
    TakePoints(row.values);
    index_ += 1.0;
    return true;
  }
  for (std::size_t v = 0; v < points_.size(); ++v) {
    if (!is_point_[v]) continue;
    if (!IsNoSample(next_.values[v])) points_[v] = next_.values[v];
    next_.values[v] = kNaN;
  }
  row = next_;
  last_ = next_;
  const double steps = (next_.time - first_time_) / step_;
  if (std::abs(steps - std::round(steps)) <= kStepSnap) {
    TakePoints(row.values);
  }
  has_last_ = true;
  has_next_ = false;
  return true;
}

// The rows of the next time.
bool SpreadRows::Fill() {
  constexpr std::size_t kMostRows = 100'000;
  constexpr double kGap = 1.9;  // steps
  RecordRow row;
  if (!next_) {
    if (!rows_->Next(row)) return false;
    next_ = row;
  }
  const double time = next_->time;
  ready_.push_back(*std::move(next_));
  next_.reset();
  while (!next_ && rows_->Next(row)) {
    if (row.time == time) {
      ready_.push_back(row);
    } else {
      next_ = row;
    }
    if (ready_.size() > kMostRows) {
      status_ = InvalidArgument(
          rows_->TimePlace(), ": more than ", kMostRows,
          " rows have the time of this one, too many to be spread");
      return false;
    }
  }
  if (!rows_->status().ok()) return false;
  const auto count = static_cast<int>(ready_.size());
  const double apart = next_ ? next_->time - time : 0.0;
  double of_row = apart / count;
  if (!(apart > 0.0) || apart > kGap * step_) {
    of_row = step_ / std::max(count, usual_);
  }
  int first = 0;
  if (is_first_ && count < usual_ && next_) {
    of_row = step_ / usual_;
    first = usual_ - count;
  }
  is_first_ = false;
  for (int k = 0; k < count; ++k) {
    if (first + k > 0) ++spread_;
    ready_[k].time += of_row * (first + k);
  }
  return true;
}

bool SpreadRows::Next(RecordRow& row) {
  if (ready_.empty() && !Fill()) return false;
  row = std::move(ready_.front());
  ready_.pop_front();
  return true;
}

std::string LastRowFirst::TimePlace() const { return rows_.TimePlaceOf(line_); }

}  // namespace mle
