#include "mle/data/record_collector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/data/gap_bridging.h"

namespace mle {

RecordCollector::RecordCollector(const CollectorOptions& options,
                                 RecordSink* sink)
    : options_(options),
      sink_(sink),
      builder_(options_.num_outputs, options_.num_inputs),
      bridged_(2 * options_.num_outputs + options_.num_inputs),
      missing_(bridged_.size()) {
  if (sink_ != nullptr) {
    piece_ = std::max(sink_->PieceSamples(options_.sample_time), 2);
  }
}

void RecordCollector::Add(bool begins, double time,
                          const std::vector<double>& values) {
  if (begins) EndRecord();
  if (builder_.samples() == 0) start_time_ = time;
  builder_.Add(values);
  ++samples_;
  if (!IsPiece(values)) return;
  EndPiece();
  continues_ = true;
}

void RecordCollector::Finish() { EndRecord(); }

bool RecordCollector::IsPiece(const std::vector<double>& last) const {
  if (sink_ == nullptr || builder_.samples() < piece_) return false;
  const auto first =
      last.begin() + (options_.has_set_points ? options_.num_outputs
                                              : 2 * options_.num_outputs);
  return builder_.samples() / 2 >= piece_ ||
         std::none_of(first, last.end(),
                      [](double value) { return std::isnan(value); });
}

void RecordCollector::EndRecord() {
  EndPiece();
  continues_ = false;
}

void RecordCollector::EndPiece() {
  if (builder_.samples() == 0) return;
  Record record =
      builder_.Take(start_time_, options_.sample_time, options_.has_set_points);
  if (record.samples() < 2 && !continues_) {
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
  if (sink_ == nullptr) {
    records_.push_back(std::move(record));
  } else if (status_.ok()) {
    status_ = sink_->Take(std::move(record), continues_);
  }
}

}  // namespace mle
