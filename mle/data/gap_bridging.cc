#include "mle/data/gap_bridging.h"

#include <cmath>
#include <numeric>

namespace mle {
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
