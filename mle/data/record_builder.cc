#include "mle/data/record_builder.h"

#include <algorithm>
#include <cstddef>

namespace mle {
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

}  // namespace mle
