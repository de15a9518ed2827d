#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/escaping.h"
#include "apps/common/sha256.h"
#include "apps/watch/source.h"
#include "mle/base/double_limits.h"
#include "mle/data/civil_time.h"

namespace mle::watch {
namespace {

constexpr std::size_t kChecksumBytes = 16;
constexpr std::size_t kDateLength = 10;

// The last sample of a day may be missing.
constexpr double kNearlyOver = 1.5;

std::string_view BytesOf(const Eigen::MatrixXd& values) {
  return {reinterpret_cast<const char*>(values.data()),
          static_cast<std::size_t>(values.size()) * sizeof(double)};
}

}  // namespace

std::vector<int> ClosedDays(const DatedRecords& data) {
  std::set<int> days;
  double end = 0.0;
  for (const Record& record : data.records) {
    const double last = data.TimeOf(record, record.samples() - 1);
    end = std::max(end, last);
    const auto from =
        static_cast<int>(std::floor(record.start_time / kSecondsOfDay));
    const auto to = static_cast<int>(std::floor(last / kSecondsOfDay));
    for (int day = from; day <= to; ++day) days.insert(day);
  }
  std::vector<int> closed;
  for (const int day : days) {
    if (end >=
        (day + 1) * kSecondsOfDay - kNearlyOver * data.sample_seconds()) {
      closed.push_back(day);
    }
  }
  return closed;
}

WatchBatch DayOf(const DatedRecords& data, int day, int lead) {
  const double step = data.sample_seconds();
  const double begin = day * kSecondsOfDay;
  const double from = begin - lead * step;
  const double to = begin + kSecondsOfDay;
  WatchBatch batch;
  Record& whole = batch.record;
  double origin = 0.0;
  int samples = 0;
  // The grid is that of the first record that reaches into the time.
  for (const Record& record : data.records) {
    const auto first = std::max(
        0,
        static_cast<int>(std::ceil((from - record.start_time) / step - 1e-6)));
    if (first >= record.samples() || data.TimeOf(record, first) >= to) continue;
    if (samples == 0) {
      origin = data.TimeOf(record, first);
      samples = static_cast<int>(std::ceil((to - origin) / step - 1e-6));
      whole.sample_time = record.sample_time;
      whole.outputs.setConstant(record.num_outputs(), samples, kNaN);
      whole.inputs.setConstant(record.num_inputs(), samples, kNaN);
      if (record.set_points.size() > 0) {
        whole.set_points.setConstant(record.num_outputs(), samples, kNaN);
      }
    }
    for (int k = first; k < record.samples(); ++k) {
      const auto at = static_cast<int>(
          std::lround((data.TimeOf(record, k) - origin) / step));
      if (at >= samples) break;
      whole.outputs.col(at) = record.outputs.col(k);
      whole.inputs.col(at) = record.inputs.col(k);
      if (whole.set_points.size() > 0) {
        whole.set_points.col(at) = record.set_points.col(k);
      }
    }
  }
  batch.first = std::clamp(
      static_cast<int>(std::ceil((begin - origin) / step - 1e-6)), 0, samples);
  return batch;
}

std::string ChecksumOf(const WatchBatch& batch) {
  Sha256 hash;
  hash.Add(BytesOf(batch.record.outputs));
  hash.Add(BytesOf(batch.record.inputs));
  hash.Add(BytesOf(batch.record.set_points));
  return absl::HexStringToBytes(hash.HexDigest()).substr(0, kChecksumBytes);
}

std::string NameOfDay(int day) {
  return FormatIsoTime(day * kSecondsOfDay).substr(0, kDateLength);
}

}  // namespace mle::watch
