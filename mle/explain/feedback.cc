#include "mle/explain/feedback.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Core"
#include "Eigen/QR"
#include "mle/explain/explained_output.h"
#include "mle/explain/instruments.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPointsPerTau = 10.0;
constexpr int kInputLags = 6;
constexpr int kResidualLags = 4;
constexpr int kMostLags = std::max(kInputLags, kResidualLags);

// Means over several rows that adjoin: e, then each input, then each set point
// that moves.
struct Grid {
  MatrixXd values;  // 1 + inputs + set points × points
  Index inputs = 0;
  std::vector<int> before;  // points before each that adjoin it
};

Grid GridOf(const ExplainedOutput& output, const VectorXd& e) {
  const std::vector<ResidualRow>& rows = output.rows();
  std::vector<VectorXd> signals;
  for (const int j : output.possible_inputs()) {
    signals.push_back(output.InputRows(j));
  }
  const auto inputs = static_cast<Index>(signals.size());
  for (int i = 0; i < output.num_moving_set_points(); ++i) {
    std::vector<VectorXd> moves;
    for (int r = 0; r < static_cast<int>(output.records().size()); ++r) {
      moves.push_back(output.SetPointMoves(i, r));
    }
    signals.push_back(output.RowMeans(moves));
  }
  const double row_time = output.sample_time() * output.samples_a_row();
  const auto every = static_cast<std::size_t>(std::max(
      1.0, std::floor(output.tau() / (kPointsPerTau * row_time) + 1e-9)));
  Grid grid;
  grid.inputs = inputs;
  grid.values.resize(static_cast<Index>(1 + signals.size()),
                     static_cast<Index>(rows.size()));
  Index points = 0;
  for (std::size_t i = 0; i + every <= rows.size();) {
    const ResidualRow& first = rows[i];
    const ResidualRow& last = rows[i + every - 1];
    if (last.record != first.record ||
        last.first - first.first !=
            static_cast<int>(every - 1) * first.samples) {
      ++i;
      continue;
    }
    const auto mean = [&](const VectorXd& of) {
      return of.segment(static_cast<Index>(i), static_cast<Index>(every))
          .mean();
    };
    grid.values(0, points) = mean(e);
    for (std::size_t j = 0; j < signals.size(); ++j) {
      grid.values(static_cast<Index>(1 + j), points) = mean(signals[j]);
    }
    const bool adjoins = i > 0 && !grid.before.empty() &&
                         rows[i - 1].record == first.record &&
                         rows[i - 1].first + rows[i - 1].samples == first.first;
    grid.before.push_back(adjoins ? grid.before.back() + 1 : 0);
    ++points;
    i += every;
  }
  grid.values.conservativeResize(Eigen::NoChange, points);
  return grid;
}

}  // namespace

std::optional<double> FeedbackPValue(const ExplainedOutput& output,
                                     const VectorXd& e) {
  const Grid grid = GridOf(output, e);
  std::vector<Index> points;
  for (std::size_t k = 0; k < grid.before.size(); ++k) {
    if (grid.before[k] >= kMostLags) points.push_back(static_cast<Index>(k));
  }
  const auto n = static_cast<Index>(points.size());
  const Index inputs = grid.inputs;
  const Index set_points = grid.values.rows() - 1 - inputs;
  const Index of_set_points = (kInputLags + 1) * set_points;
  const Index known = kInputLags * inputs + of_set_points + 1;
  const Index left = n - known - kResidualLags;
  if (left < known) return std::nullopt;
  MatrixXd columns(n, known + kResidualLags);
  for (Index i = 0; i < n; ++i) {
    const Index k = points[static_cast<std::size_t>(i)];
    for (int l = 1; l <= kInputLags; ++l) {
      columns.row(i).segment((l - 1) * inputs, inputs) =
          grid.values.col(k - l).segment(1, inputs).transpose();
    }
    for (int l = 0; l <= kInputLags; ++l) {
      columns.row(i).segment(kInputLags * inputs + l * set_points, set_points) =
          grid.values.col(k - l).tail(set_points).transpose();
    }
    columns(i, known - 1) = 1.0;
    for (int l = 1; l <= kResidualLags; ++l) {
      columns(i, known + l - 1) = grid.values(0, k - l);
    }
  }
  // Columns in units of their own.
  for (Index c = 0; c < columns.cols(); ++c) {
    const double size = columns.col(c).norm();
    if (size > 0.0) columns.col(c) /= size;
  }
  const auto left_by = [&](const MatrixXd& of, const MatrixXd& targets) {
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(of);
    MatrixXd rotated = qr.householderQ().adjoint() * targets;
    rotated.topRows(qr.rank()).setZero();
    return VectorXd(rotated.colwise().squaredNorm());
  };
  MatrixXd targets(n, inputs);
  for (Index i = 0; i < n; ++i) {
    targets.row(i) = grid.values.col(points[static_cast<std::size_t>(i)])
                         .segment(1, inputs)
                         .transpose();
  }
  for (Index j = 0; j < inputs; ++j) {
    targets.col(j).array() -= targets.col(j).mean();
  }
  const VectorXd sizes = targets.colwise().squaredNorm();
  const VectorXd without = left_by(columns.leftCols(known), targets);
  const VectorXd with = left_by(columns, targets);
  double least = 1.0;
  int tested = 0;
  for (Index j = 0; j < inputs; ++j) {
    // An input that its past tells exactly, as one that rests.
    constexpr double kExact = 1e-10;
    if (!(without[j] > kExact * sizes[j])) continue;
    ++tested;
    const double f = (without[j] - with[j]) / kResidualLags /
                     (std::max(with[j], 1e-300) / static_cast<double>(left));
    least = std::min(least,
                     FisherTail(f, kResidualLags, static_cast<double>(left)));
  }
  if (tested == 0) return std::nullopt;
  return -std::expm1(tested * std::log1p(-least));
}

std::optional<double> FeedbackPValue(const ProcessModel& model,
                                     const std::vector<Record>& records,
                                     int i) {
  const absl::StatusOr<ExplainedOutput> output =
      ExplainedOutput::Create(model, records, i);
  if (!output.ok()) return std::nullopt;
  const absl::StatusOr<Instruments> instruments =
      Instruments::Create(model, *output);
  if (!instruments.ok()) return std::nullopt;
  return FeedbackPValue(*output, instruments->Undriven(output->Residual({})));
}

}  // namespace mle
