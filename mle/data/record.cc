#include "mle/data/record.h"

#include <cmath>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

std::string Shape(const Eigen::MatrixXd& matrix) {
  return absl::StrCat(matrix.rows(), " × ", matrix.cols());
}

absl::Status CheckSizes(const char* kind, const Eigen::MatrixXd& values) {
  for (Eigen::Index k = 0; k < values.cols(); ++k) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      if (std::isfinite(values(i, k)) &&
          std::abs(values(i, k)) > kLargestSample) {
        return InvalidArgument("record: ", kind, " ", i + 1, " is ",
                               values(i, k), " in sample ", k + 1,
                               "; samples may not exceed ", kLargestSample,
                               ": check units, or make it NaN, a bad sample");
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Record::Validate() const {
  MLE_RETURN_IF_ERROR(ValidateSampleTime("record: sample_time", sample_time));
  if (!std::isfinite(start_time)) {
    return InvalidArgument("record: start_time is ", start_time,
                           ", must be finite");
  }
  if (inputs.cols() != outputs.cols()) {
    return InvalidArgument("record: outputs are ", Shape(outputs), ", inputs ",
                           Shape(inputs),
                           "; the numbers of samples must agree");
  }
  if (set_points.size() != 0 && (set_points.rows() != outputs.rows() ||
                                 set_points.cols() != outputs.cols())) {
    return InvalidArgument("record: set points are ", Shape(set_points),
                           ", must be ", Shape(outputs), " or empty");
  }
  MLE_RETURN_IF_ERROR(CheckSizes("output", outputs));
  MLE_RETURN_IF_ERROR(CheckSizes("input", inputs));
  return CheckSizes("the set point of output", set_points);
}

int Record::lead() const {
  for (int k = 0; k < samples(); ++k) {
    if (outputs.col(k).array().isFinite().any()) return k;
  }
  return 0;
}

std::vector<SetPointChange> FindSetPointChanges(const Record& record) {
  const Eigen::MatrixXd& set_points = record.set_points;
  std::vector<SetPointChange> changes;
  Eigen::VectorXd last = Eigen::VectorXd::Constant(
      set_points.rows(), std::numeric_limits<double>::quiet_NaN());
  for (int k = 0; k < set_points.cols(); ++k) {
    for (int i = 0; i < set_points.rows(); ++i) {
      const double value = set_points(i, k);
      if (!std::isfinite(value)) continue;
      if (std::isfinite(last(i)) && value != last(i)) {
        changes.push_back({k, i, last(i), value});
      }
      last(i) = value;
    }
  }
  return changes;
}

absl::StatusOr<Record> CutWindow(const Record& record, int center,
                                 double before, double after) {
  if (!(before >= 0.0) || !(after >= 0.0)) {
    return InvalidArgument("window: before is ", before, " and after is ",
                           after, "; neither may be negative");
  }
  const double first = center - std::round(before / record.sample_time);
  const double last = center + std::round(after / record.sample_time);
  if (center < 0 || center >= record.samples() || first < 0 ||
      last >= record.samples()) {
    const double center_time = record.time(center);
    const std::string present =
        record.samples() == 0
            ? "is empty"
            : absl::StrCat("goes from ", record.start_time, " to ",
                           record.time(record.samples() - 1));
    return absl::OutOfRangeError(absl::StrCat(
        "window: from ", center_time - before, " to ", center_time + after,
        " (around ", center_time, ") is wanted, but the record ", present));
  }
  const int begin = static_cast<int>(first);
  return PartOf(record, begin, static_cast<int>(last) - begin + 1);
}

Record PartOf(const Record& record, int first, int samples) {
  Record part;
  part.start_time = record.time(first);
  part.sample_time = record.sample_time;
  part.outputs = record.outputs.middleCols(first, samples);
  part.inputs = record.inputs.middleCols(first, samples);
  if (record.set_points.size() > 0) {
    part.set_points = record.set_points.middleCols(first, samples);
  }
  return part;
}

Eigen::VectorXd Filled(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Eigen::VectorXd filled = values;
  double last = 0.0;
  for (const double value : values) {
    if (std::isfinite(value)) {
      last = value;
      break;
    }
  }
  for (double& value : filled) {
    if (std::isfinite(value)) {
      last = value;
    } else {
      value = last;
    }
  }
  return filled;
}

Record JoinRecords(std::span<const Record> records) {
  Record all = records.front();
  if (records.size() == 1) return all;
  int samples = 0;
  for (const Record& record : records) samples += record.samples();
  const auto join = [&](Eigen::MatrixXd Record::*rows) {
    if ((all.*rows).rows() == 0) return;
    (all.*rows).resize(Eigen::NoChange, samples);
    Eigen::Index column = 0;
    for (const Record& record : records) {
      const Eigen::MatrixXd& part = record.*rows;
      (all.*rows).middleCols(column, part.cols()) = part;
      column += part.cols();
    }
  };
  join(&Record::outputs);
  join(&Record::inputs);
  join(&Record::set_points);
  return all;
}

}  // namespace mle
