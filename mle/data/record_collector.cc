#include "mle/data/record_collector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

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

namespace {

// Large enough for the allocator to give each back to the system by itself.
constexpr int kBlockBytes = 4 << 20;

}  // namespace

void RecordBuilder::Add(const std::vector<double>& values) {
  const std::size_t per_block =
      std::max<std::size_t>(kBlockBytes / (8 * values.size()), 1) *
      values.size();
  if (blocks_.empty() || blocks_.back().size() == per_block) {
    blocks_.emplace_back().reserve(per_block);
  }
  blocks_.back().insert(blocks_.back().end(), values.begin(), values.end());
  ++samples_;
}

Record RecordBuilder::Take(double start_time, double sample_time,
                           bool with_set_points) {
  Record record;
  record.start_time = start_time;
  record.sample_time = sample_time;
  const int p = num_outputs_;
  const int m = num_inputs_;
  record.outputs.resize(p, samples_);
  record.inputs.resize(m, samples_);
  if (with_set_points) record.set_points.resize(p, samples_);
  int begin = 0;
  for (std::vector<double>& block : blocks_) {
    const int count = static_cast<int>(block.size()) / (2 * p + m);
    const Eigen::Map<const Eigen::MatrixXd> values(block.data(), 2 * p + m,
                                                   count);
    record.outputs.middleCols(begin, count) = values.topRows(p);
    record.inputs.middleCols(begin, count) = values.bottomRows(m);
    if (with_set_points) {
      record.set_points.middleCols(begin, count) = values.middleRows(p, p);
    }
    begin += count;
    std::vector<double>().swap(block);
  }
  blocks_.clear();
  samples_ = 0;
  return record;
}

namespace {

using Row = Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>;

// Moves at arbitrary instants would all be multiples of two samples apart with
// a probability of 2^−(moves − 1).
constexpr int kEnoughMoves = 11;

// The instants at which a held signal moves: phase + i period.
struct MoveInstants {
  Eigen::Index phase = 0;
  Eigen::Index period = 0;  // 0: not known

  // The last up to sample k.
  Eigen::Index LastUpTo(Eigen::Index k) const {
    return k - (k - phase % period + period) % period;
  }
};

MoveInstants FindMoveInstants(const Row& row) {
  MoveInstants instants;
  int moves = 0;
  for (Eigen::Index k = 1; k < row.size(); ++k) {
    if (!std::isfinite(row(k - 1)) || !std::isfinite(row(k)) ||
        row(k) == row(k - 1)) {
      continue;
    }
    if (moves == 0) instants.phase = k;
    instants.period = std::gcd(instants.period, k - instants.phase);
    ++moves;
  }
  if (moves < kEnoughMoves) instants.period = 0;
  return instants;
}

// Returns how many samples it filled.
int BridgeHeld(int max_samples, const MoveInstants& instants, Row row) {
  int bridged = 0;
  Eigen::Index last = -1;  // the last good sample
  for (Eigen::Index next = 0; next < row.size(); ++next) {
    if (!std::isfinite(row(next))) continue;
    const Eigen::Index missing = next - last - 1;
    if (last >= 0 && missing > 0 && missing <= max_samples) {
      Eigen::Index moved = next;
      if (instants.period > 1 && instants.LastUpTo(next) > last) {
        moved = instants.LastUpTo(next);
      }
      for (Eigen::Index k = last + 1; k < next; ++k) {
        row(k) = k < moved ? row(last) : row(next);
      }
      bridged += static_cast<int>(missing);
    }
    last = next;
  }
  return bridged;
}

}  // namespace

std::vector<int> BridgeGaps(int max_samples, Record& record) {
  const int p = record.num_outputs();
  std::vector<int> bridged(2 * p + record.num_inputs(), 0);
  for (Eigen::Index i = 0; i < record.set_points.rows(); ++i) {
    bridged[p + i] = BridgeHeld(max_samples, {}, record.set_points.row(i));
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    bridged[2 * p + j] =
        BridgeHeld(max_samples, FindMoveInstants(record.inputs.row(j)),
                   record.inputs.row(j));
  }
  return bridged;
}

}  // namespace mle
