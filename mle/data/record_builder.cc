#include "mle/data/record_builder.h"

#include <cmath>
#include <cstddef>

namespace mle {
namespace {

constexpr int kBlockSamples = 4096;

enum class Bridge { kHold, kLinear };

int BridgeRow(int max_samples, Bridge bridge,
              Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> row) {
  int bridged = 0;
  Eigen::Index last = -1;  // the last good sample
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    if (!std::isfinite(row(k))) continue;
    const Eigen::Index missing = k - last - 1;
    if (last >= 0 && missing > 0 && missing <= max_samples) {
      const double slope =
          bridge == Bridge::kHold
              ? 0.0
              : (row(k) - row(last)) / static_cast<double>(missing + 1);
      for (Eigen::Index i = 1; i <= missing; ++i) {
        row(last + i) = row(last) + static_cast<double>(i) * slope;
      }
      bridged += static_cast<int>(missing);
    }
    last = k;
  }
  return bridged;
}

}  // namespace

void RecordBuilder::Add(const std::vector<double>& values) {
  if (samples_ % kBlockSamples == 0) {
    blocks_.emplace_back().reserve(kBlockSamples * values.size());
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

std::vector<int> BridgeGaps(int max_samples, bool bridge_outputs,
                            Record& record) {
  const int p = record.num_outputs();
  std::vector<int> bridged(2 * p + record.num_inputs(), 0);
  for (int i = 0; i < p; ++i) {
    if (bridge_outputs) {
      bridged[i] =
          BridgeRow(max_samples, Bridge::kLinear, record.outputs.row(i));
    }
    if (record.set_points.size() > 0) {
      bridged[p + i] =
          BridgeRow(max_samples, Bridge::kHold, record.set_points.row(i));
    }
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    bridged[2 * p + j] =
        BridgeRow(max_samples, Bridge::kHold, record.inputs.row(j));
  }
  return bridged;
}

}  // namespace mle
