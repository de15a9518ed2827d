#include "mle/data/record_collector.h"

#include <cmath>
#include <limits>
#include <utility>

#include "mle/data/gap_bridging.h"

namespace mle {

RecordCollector::RecordCollector(CollectorOptions options)
    : options_(std::move(options)),
      builder_(options_.num_outputs, options_.num_inputs),
      bridged_(2 * options_.num_outputs + options_.num_inputs),
      missing_(bridged_.size()),
      last_set_points_(options_.num_outputs,
                       std::numeric_limits<double>::quiet_NaN()) {}

void RecordCollector::Add(bool begins, double time,
                          const std::vector<double>& values) {
  if (options_.scan_for_change >= 0.0) {
    Scan(begins, time, values);
    return;
  }
  const std::vector<TimeRange>& keep = options_.keep;
  if (!keep.empty()) {
    while (range_ < keep.size() && time > keep[range_].to) {
      EndRecord();
      ++range_;
    }
    if (range_ == keep.size() || time < keep[range_].from) {
      if (begins) EndRecord();
      return;
    }
  }
  if (begins) EndRecord();
  if (builder_.samples() == 0) start_time_ = time;
  builder_.Add(values);
  ++samples_;
}

void RecordCollector::Finish() { EndRecord(); }

void RecordCollector::Scan(bool begins, double time,
                           const std::vector<double>& values) {
  for (int i = 0; i < options_.num_outputs; ++i) {
    const double value = values[options_.num_outputs + i];
    if (!std::isfinite(value)) continue;
    double& last = last_set_points_[i];
    const bool changes = !begins && std::isfinite(last) &&
                         std::abs(value - last) > options_.scan_for_change;
    if (changes && (change_times_.empty() || change_times_.back() < time)) {
      change_times_.push_back(time);
    }
    if (changes || begins || !std::isfinite(last)) last = value;
  }
}

void RecordCollector::EndRecord() {
  if (builder_.samples() == 0) return;
  Record record =
      builder_.Take(start_time_, options_.sample_time, options_.has_set_points);
  if (record.samples() < 2) {
    ++short_pieces_;
    return;
  }
  const std::vector<int> bridged =
      BridgeGaps(options_.max_bridged, options_.bridge_outputs, record);
  const auto count = [&](const Eigen::MatrixXd& rows, int first) {
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      bridged_[first + i] += bridged[first + i];
      missing_[first + i] += (!rows.row(i).array().isFinite()).count();
    }
  };
  count(record.outputs, 0);
  count(record.set_points, options_.num_outputs);
  count(record.inputs, 2 * options_.num_outputs);
  records_.push_back(std::move(record));
}

}  // namespace mle
