#include "mle/data/record_collector.h"

#include <utility>

#include "mle/data/gap_bridging.h"

namespace mle {

RecordCollector::RecordCollector(const CollectorOptions& options)
    : options_(options),
      builder_(options_.num_outputs, options_.num_inputs),
      bridged_(2 * options_.num_outputs + options_.num_inputs),
      missing_(bridged_.size()) {}

void RecordCollector::Add(bool begins, double time,
                          const std::vector<double>& values) {
  if (begins) EndRecord();
  if (builder_.samples() == 0) start_time_ = time;
  builder_.Add(values);
  ++samples_;
}

void RecordCollector::Finish() { EndRecord(); }

void RecordCollector::EndRecord() {
  if (builder_.samples() == 0) return;
  Record record =
      builder_.Take(start_time_, options_.sample_time, options_.has_set_points);
  if (record.samples() < 2) {
    ++short_pieces_;
    return;
  }
  TakeWhole(std::move(record));
}

void RecordCollector::Take(Record record) {
  samples_ += record.samples();
  TakeWhole(std::move(record));
}

void RecordCollector::TakeWhole(Record record) {
  const std::vector<int> bridged = BridgeGaps(options_.max_bridged, record);
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
