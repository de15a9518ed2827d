#include "mle/data/row_stream.h"

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

std::string LastRowFirst::TimePlace() const { return rows_.TimePlaceOf(line_); }

}  // namespace mle
