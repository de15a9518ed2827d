#include "mle/data/gap_bridging.h"

#include <cmath>
#include <numeric>

namespace mle {
namespace {

using Row = Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>;

// Moves at arbitrary instants would all be multiples of two samples apart with
// a probability of 2^−(moves − 1).
constexpr int kEnoughMoves = 11;

// Where `fill(last, next)` fills the samples between two good ones. Returns how
// many it filled.
template <typename Fill>
int BridgeRow(int max_samples, Row row, Fill fill) {
  int bridged = 0;
  Eigen::Index last = -1;  // the last good sample
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    if (!std::isfinite(row(k))) continue;
    const Eigen::Index missing = k - last - 1;
    if (last >= 0 && missing > 0 && missing <= max_samples) {
      fill(last, k);
      bridged += static_cast<int>(missing);
    }
    last = k;
  }
  return bridged;
}

int BridgeLinearly(int max_samples, Row row) {
  return BridgeRow(
      max_samples, row, [&row](Eigen::Index last, Eigen::Index next) {
        const double slope =
            (row(next) - row(last)) / static_cast<double>(next - last);
        for (Eigen::Index k = last + 1; k < next; ++k) {
          row(k) = row(last) + static_cast<double>(k - last) * slope;
        }
      });
}

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

int BridgeHeld(int max_samples, const MoveInstants& instants, Row row) {
  return BridgeRow(max_samples, row, [&](Eigen::Index last, Eigen::Index next) {
    Eigen::Index moved = next;
    if (instants.period > 1 && instants.LastUpTo(next) > last) {
      moved = instants.LastUpTo(next);
    }
    for (Eigen::Index k = last + 1; k < next; ++k) {
      row(k) = k < moved ? row(last) : row(next);
    }
  });
}

}  // namespace

std::vector<int> BridgeGaps(int max_samples, bool bridge_outputs,
                            Record& record) {
  const int p = record.num_outputs();
  std::vector<int> bridged(2 * p + record.num_inputs(), 0);
  for (int i = 0; i < p; ++i) {
    if (bridge_outputs) {
      bridged[i] = BridgeLinearly(max_samples, record.outputs.row(i));
    }
    if (record.set_points.size() > 0) {
      bridged[p + i] = BridgeHeld(max_samples, {}, record.set_points.row(i));
    }
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    bridged[2 * p + j] =
        BridgeHeld(max_samples, FindMoveInstants(record.inputs.row(j)),
                   record.inputs.row(j));
  }
  return bridged;
}

}  // namespace mle
