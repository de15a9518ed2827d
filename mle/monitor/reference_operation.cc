#include "mle/monitor/reference_operation.h"

#include <cmath>

namespace mle {

std::vector<OutputOperation> OperationOf(const std::vector<WatchBatch>& batches,
                                         const std::vector<Record>& rest) {
  std::vector<OutputOperation> operation;
  if (rest.front().set_points.size() == 0) return operation;
  operation.resize(static_cast<std::size_t>(rest.front().num_outputs()));
  for (const WatchBatch& batch : batches) {
    for (const SetPointChange& change : FindSetPointChanges(batch.record)) {
      if (change.sample < batch.first) continue;
      OutputOperation& output = operation[change.output];
      output.changes += 1.0;
      output.change_size +=
          (change.to - change.from) * (change.to - change.from);
    }
  }
  for (std::size_t i = 0; i < operation.size(); ++i) {
    OutputOperation& output = operation[i];
    if (output.changes > 0.0) {
      output.change_size = std::sqrt(output.change_size / output.changes);
    }
    output.changes /= static_cast<double>(batches.size());
    double squares = 0.0;
    int samples = 0;
    for (const Record& record : rest) {
      const auto row = static_cast<Eigen::Index>(i);
      for (int k = 0; k < record.samples(); ++k) {
        const double error = record.outputs(row, k) - record.set_points(row, k);
        if (!std::isfinite(error)) continue;
        squares += error * error;
        ++samples;
      }
    }
    if (samples >= kLeastReference) output.squared_error = squares / samples;
  }
  return operation;
}

}  // namespace mle
