#include "mle/maintain/steady_records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Core"
#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/segment_information.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kRestBlock = 60;
constexpr double kFarBeyondUsual = 400.0;  // of the median
// Settling times.
constexpr double kAround = 5.0;
constexpr double kApart = 20.0;
constexpr std::size_t kFewBlocks = 10;

int BlocksOf(const Record& record) {
  return (record.samples() + kRestBlock - 1) / kRestBlock;
}

// p × blocks: mean squares of the whitened residuals; 0 where nothing was
// measured.
absl::StatusOr<MatrixXd> SquaresAtRest(const ProcessModel& model,
                                       const Record& record) {
  MLE_ASSIGN_OR_RETURN(
      const MatrixXd response,
      SimulateResponse(model, record.sample_time, WithoutGaps(record).inputs));
  const std::vector<bool> integrates = IntegratingOutputs(model);
  MatrixXd squares = MatrixXd::Zero(record.num_outputs(), BlocksOf(record));
  for (int i = 0; i < record.num_outputs(); ++i) {
    std::vector<int> times;
    for (int k = 0; k < record.samples(); ++k) {
      if (std::isfinite(record.outputs(i, k))) times.push_back(k);
    }
    if (times.empty()) continue;
    MatrixXd residuals(static_cast<Index>(times.size()), 1);
    for (std::size_t r = 0; r < times.size(); ++r) {
      residuals(static_cast<Index>(r)) =
          record.outputs(i, times[r]) - response(i, times[r]);
    }
    // The first inputs are not those that balance a level: its residual has a
    // slope, its increments have an offset.
    if (integrates[i]) {
      const Index last = residuals.rows() - 1;
      residuals.bottomRows(last) -= residuals.topRows(last).eval();
      residuals(0) = last > 0 ? residuals(1) : 0.0;
    }
    InnovationsFilter(times, {.ratio = kExpectedDriftRatio}).Apply(residuals);
    std::vector<int> counts(BlocksOf(record), 0);
    for (std::size_t r = 0; r < times.size(); ++r) {
      const double residual = residuals(static_cast<Index>(r));
      squares(i, times[r] / kRestBlock) += residual * residual;
      ++counts[times[r] / kRestBlock];
    }
    for (int b = 0; b < BlocksOf(record); ++b) {
      squares(i, b) /= std::max(counts[b], 1);
    }
  }
  return squares;
}

// p: medians over all blocks in which something was measured; infinite where
// there are too few of them.
std::vector<double> MediansOf(const std::vector<MatrixXd>& squares) {
  std::vector<double> medians;
  for (Index i = 0; i < squares[0].rows(); ++i) {
    std::vector<double> all;
    for (const MatrixXd& of_record : squares) {
      for (const double square : of_record.row(i)) {
        if (square > 0.0) all.push_back(square);
      }
    }
    medians.push_back(all.size() < kFewBlocks
                          ? std::numeric_limits<double>::infinity()
                          : MedianInPlace(all));
  }
  return medians;
}

// Which blocks of a record are as usual, `margin` blocks away from others and
// not among such as are no more than `together` apart.
std::vector<bool> UsualBlocks(const MatrixXd& squares,
                              const std::vector<double>& medians, int margin,
                              int together) {
  const auto blocks = static_cast<int>(squares.cols());
  std::vector<bool> usual(blocks, true);
  for (int b = 0, last = -together - 1; b < blocks; ++b) {
    bool is_far = false;
    for (Index i = 0; i < squares.rows(); ++i) {
      is_far |= squares(i, b) > kFarBeyondUsual * medians[i];
    }
    if (!is_far) continue;
    const int first = b - last <= together ? last : b;
    std::fill(usual.begin() + std::max(first - margin, 0),
              usual.begin() + std::min(b + margin + 1, blocks), false);
    last = b;
  }
  return usual;
}

}  // namespace

absl::StatusOr<SteadyRecords> FindSteadyRecords(const ProcessModel& model,
                                                std::vector<Record> rest) {
  SteadyRecords parts;
  if (rest.empty()) return parts;
  std::vector<MatrixXd> squares;
  for (const Record& record : rest) {
    MLE_ASSIGN_OR_RETURN(MatrixXd of_record, SquaresAtRest(model, record));
    squares.push_back(std::move(of_record));
  }
  const std::vector<double> medians = MediansOf(squares);
  const double settling =  // blocks
      SettlingTime(model) / (rest[0].sample_time * kRestBlock);
  const auto blocks_in = [&](double settling_times) {
    return static_cast<int>(
        std::clamp(std::ceil(settling_times * settling), 1.0, 1e6));
  };
  const int margin = blocks_in(kAround);
  const int together = blocks_in(kApart);
  for (std::size_t r = 0; r < rest.size(); ++r) {
    const std::vector<bool> usual =
        UsualBlocks(squares[r], medians, margin, together);
    if (std::find(usual.begin(), usual.end(), false) == usual.end()) {
      parts.usual.push_back(std::move(rest[r]));
      continue;
    }
    const Record& record = rest[r];
    const auto blocks = static_cast<int>(usual.size());
    for (int b = 0; b < blocks;) {
      const int first = b * kRestBlock;
      const bool is_usual = usual[b];
      while (b < blocks && usual[b] == is_usual) ++b;
      const int end = std::min(b * kRestBlock, record.samples());
      if (is_usual) {
        parts.usual.push_back(PartOf(record, first, end - first));
      } else {
        parts.left_out.emplace_back(record.time(first), record.time(end - 1));
      }
    }
  }
  return parts;
}

}  // namespace mle
