#include "mle/data/gap_bridging.h"

#include <cmath>

namespace mle {
namespace {

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
