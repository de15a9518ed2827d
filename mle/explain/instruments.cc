#include "mle/explain/instruments.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "Eigen/SVD"
#include "absl/status/status.h"
#include "mle/explain/signal_effects.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Functions of each signal, fewer where there are few rows.
constexpr Index kLaguerre = 6;
constexpr Index kFewestLaguerre = 3;
constexpr double kLaguerreTime = 0.6;  // of τ
constexpr int kPlacebos = 40;
// Signals with fewer moves are one instrument.
constexpr int kFewestMoves = 4;
// More instruments than these are those that move the output most.
constexpr int kMostInstruments = 6;
// A singular value above this share of the largest counts as a direction of its
// own: the first for instruments, the second for offsets, ramps and free
// responses.
constexpr double kLeastDirection = 1e-3;
constexpr double kLeastFree = 1e-6;
// Fewer rows than this for each function of the instruments tell too little of
// chance.
constexpr Index kLeastRows = 8;
// Squared lengths of a placebo's columns count as at least this share of the
// largest.
constexpr double kLeastPlacebo = 1e-2;
// Time constants nearer than this factor leave the same free response.
constexpr double kSameLag = 1.3;

// A signal of each record.
using Signal = std::vector<VectorXd>;

double RangeOf(const Signal& signal) {
  double range = 0.0;
  for (const VectorXd& values : signal) {
    range = std::max(range, values.maxCoeff() - values.minCoeff());
  }
  return range;
}

int MovesOf(const Signal& signal) {
  int moves = 0;
  for (const VectorXd& values : signal) {
    for (Index k = 1; k < values.size(); ++k) {
      if (values[k] != values[k - 1]) ++moves;
    }
  }
  return moves;
}

// The moves of the first half of all moves, and the others.
std::vector<Signal> Halves(const Signal& signal) {
  const int half = MovesOf(signal) / 2;
  std::vector<Signal> halves(2, signal);
  int moves = 0;
  for (std::size_t r = 0; r < signal.size(); ++r) {
    VectorXd& first = halves[0][r];
    VectorXd& later = halves[1][r];
    first[0] = later[0] = 0.0;
    for (Index k = 1; k < first.size(); ++k) {
      const double move = signal[r][k] - signal[r][k - 1];
      if (move != 0.0) ++moves;
      first[k] = first[k - 1] + (moves > half ? 0.0 : move);
      later[k] = later[k - 1] + (moves > half ? move : 0.0);
    }
  }
  return halves;
}

// The moves of a signal later by `shift` samples, those at the end first.
VectorXd Shifted(const VectorXd& values, Index shift) {
  const Index n = values.size();
  if (shift == 0) return values.array() - values[0];
  VectorXd shifted(n);
  const Index k = n - shift;  // the first `shift` moves are the last ones
  shifted.head(shift) = values.tail(shift).array() - values[k];
  shifted.tail(k) =
      values.head(k).array() - values[0] + (values[n - 1] - values[k]);
  return shifted;
}

// Its Laguerre functions (rows × functions).
MatrixXd Bank(const ExplainedOutput& output, const Signal& signal,
              Index functions, double share) {
  const double pole =
      std::exp(-output.sample_time() / (kLaguerreTime * output.tau()));
  const double scale = std::max(RangeOf(signal), 1e-300);
  MatrixXd bank(static_cast<Index>(output.rows().size()), functions);
  Signal filtered;
  for (const VectorXd& values : signal) {
    const auto shift =
        static_cast<Index>(share * static_cast<double>(values.size()));
    const VectorXd moved = Shifted(values, shift) / scale;
    VectorXd first(values.size());
    double state = 0.0;
    for (Index k = 0; k < moved.size(); ++k) {
      first[k] = state;
      state = pole * state + std::sqrt(1.0 - pole * pole) * moved[k];
    }
    filtered.push_back(std::move(first));
  }
  for (Index f = 0; f < functions; ++f) {
    bank.col(f) = output.RowMeans(filtered);
    if (f + 1 == functions) break;
    for (VectorXd& values : filtered) {  // (q⁻¹ − pole) / (1 − pole q⁻¹)
      double input = 0.0;
      double before = 0.0;
      for (double& value : values) {
        const double now = value;
        before = pole * before - pole * now + input;
        input = now;
        value = before;
      }
    }
  }
  return bank;
}

// Offsets, ramps and free responses of each record, orthonormal.
MatrixXd FreeColumns(const ExplainedOutput& output) {
  std::vector<double> lags = output.time_constants();
  std::sort(lags.begin(), lags.end());
  std::vector<double> distinct;
  for (const double lag : lags) {
    if (distinct.empty() || lag > kSameLag * distinct.back()) {
      distinct.push_back(std::max(lag, output.sample_time()));
    }
  }
  const auto rows = static_cast<Index>(output.rows().size());
  const int each = 2 + static_cast<int>(distinct.size());
  const auto records = static_cast<Index>(output.records().size());
  MatrixXd columns = MatrixXd::Zero(rows, each * records);
  for (Index i = 0; i < rows; ++i) {
    const ResidualRow& row = output.rows()[static_cast<std::size_t>(i)];
    const double t = (row.first + 0.5 * row.samples) * output.sample_time();
    Index c = row.record * each;
    columns(i, c++) = 1.0;
    columns(i, c++) =
        t / (output.sample_time() * output.records()[row.record].samples());
    for (const double lag : distinct) columns(i, c++) = std::exp(-t / lag);
  }
  const Eigen::BDCSVD<MatrixXd> svd(columns, Eigen::ComputeThinU);
  const VectorXd& sizes = svd.singularValues();
  Index rank = 0;
  while (rank < sizes.size() && sizes[rank] > kLeastFree * sizes[0]) ++rank;
  return svd.matrixU().leftCols(rank);
}

// Leaves of the signals those that move the output most, by the model.
template <typename Freed>
void MostMoving(const ExplainedOutput& output, const Freed& freed,
                std::vector<Signal>& signals) {
  if (signals.size() <= kMostInstruments) return;
  const VectorXd modelled = output.Modelled();
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < signals.size(); ++s) {
    const Eigen::BDCSVD<MatrixXd> svd(
        freed(Bank(output, signals[s], kLaguerre, 0.0)), Eigen::ComputeThinU);
    order.emplace_back(-(svd.matrixU().transpose() * modelled).squaredNorm(),
                       s);
  }
  std::stable_sort(order.begin(), order.end());
  order.resize(kMostInstruments);
  std::vector<Signal> most;
  for (const auto& [less, index] : order) {
    most.push_back(std::move(signals[index]));
  }
  signals = std::move(most);
}

std::vector<Signal> InHalves(const std::vector<Signal>& signals) {
  std::vector<Signal> halves;
  for (const Signal& signal : signals) {
    if (MovesOf(signal) < kFewestMoves) {
      halves.push_back(signal);
      continue;
    }
    for (Signal& half : Halves(signal)) halves.push_back(std::move(half));
  }
  return halves;
}

}  // namespace

absl::StatusOr<Instruments> Instruments::Create(const ProcessModel& model,
                                                const ExplainedOutput& output) {
  Instruments made;
  const std::vector<Record>& records = output.records();
  std::vector<Signal> signals;
  const auto add = [&](auto row_of) {
    Signal signal;
    for (const Record& record : records) {
      signal.push_back(Filled(row_of(record).transpose()));
    }
    if (RangeOf(signal) > 0.0) signals.push_back(std::move(signal));
  };
  const bool set_points = std::all_of(
      records.begin(), records.end(),
      [](const Record& record) { return record.set_points.rows() > 0; });
  if (set_points) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      add([&](const Record& record) { return record.set_points.row(i); });
    }
  }
  made.by_set_points_ = !signals.empty();
  for (const int j : output.possible_inputs()) {
    const bool measured = model.inputs()[j].role == InputRole::kDisturbance;
    if (made.by_set_points_ && !measured) continue;
    add([&](const Record& record) { return record.inputs.row(j); });
  }
  if (signals.empty()) {
    return absl::FailedPreconditionError("no set point and no input moves");
  }
  for (const Signal& signal : signals) made.moves_ += MovesOf(signal);
  made.free_ = FreeColumns(output);
  const auto freed = [&](const MatrixXd& columns) -> MatrixXd {
    return columns - made.free_ * (made.free_.transpose() * columns);
  };

  MostMoving(output, freed, signals);
  const Index rows = static_cast<Index>(output.rows().size());
  std::vector<Signal> halves = InHalves(signals);
  if (rows >= kLeastRows * kLaguerre * static_cast<Index>(halves.size())) {
    made.parts_ = static_cast<double>(halves.size()) /
                  static_cast<double>(signals.size());
    signals = std::move(halves);
  }
  const auto count = static_cast<Index>(signals.size());
  const Index functions = std::min(kLaguerre, rows / (kLeastRows * count));
  if (functions < kFewestLaguerre) {
    return absl::FailedPreconditionError("the records are too short");
  }
  const auto columns_at = [&](double share) {
    MatrixXd columns(rows, functions * count);
    for (Index s = 0; s < count; ++s) {
      columns.middleCols(functions * s, functions) = freed(
          Bank(output, signals[static_cast<std::size_t>(s)], functions, share));
    }
    return columns;
  };
  const MatrixXd columns = columns_at(0.0);
  const Eigen::BDCSVD<MatrixXd> svd(columns,
                                    Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& sizes = svd.singularValues();
  if (!(sizes[0] > 0.0)) {
    return absl::FailedPreconditionError("no set point and no input moves");
  }
  Index rank = 0;
  while (rank < sizes.size() && sizes[rank] > kLeastDirection * sizes[0]) {
    ++rank;
  }
  const MatrixXd to_basis = svd.matrixV().leftCols(rank) *
                            sizes.head(rank).cwiseInverse().asDiagonal();
  made.basis_ = svd.matrixU().leftCols(rank);
  made.placebos_ = kPlacebos;
  made.placebo_.resize(columns.rows(), rank * kPlacebos);
  for (int s = 0; s < kPlacebos; ++s) {
    // Made orthonormal by the smallest change, so that each direction stays
    // that of the same moves.
    const MatrixXd moved = columns_at((s + 1.0) / (kPlacebos + 1.0)) * to_basis;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(moved.transpose() *
                                                        moved);
    const VectorXd lengths = eigen.eigenvalues().cwiseMax(
        kLeastPlacebo * eigen.eigenvalues().maxCoeff());
    const MatrixXd to_orthonormal =
        eigen.eigenvectors() * lengths.cwiseSqrt().cwiseInverse().asDiagonal() *
        eigen.eigenvectors().transpose();
    made.placebo_.middleCols(s * rank, rank) =
        (moved * to_orthonormal).cast<float>();
  }
  return made;
}

VectorXd Instruments::Project(const VectorXd& e,
                              const VectorXd& weights) const {
  if ((weights.array() == 1.0).all()) return Project(e);
  const MatrixXd weighted = weights.asDiagonal() * free_;
  MatrixXd products = weighted.transpose() * free_;
  products.diagonal().array() += 1e-9;
  const VectorXd left =
      e - free_ * products.ldlt().solve(weighted.transpose() * e);
  return basis_.transpose() * left.cwiseProduct(weights);
}

MatrixXd Instruments::ProjectPlacebos(const VectorXd& e) const {
  // Without offsets, which may be larger by more than a float has digits, and
  // in units in which no number leaves its range.
  const VectorXd freed = Freed(e);
  const double size = freed.norm();
  if (!(size > 0.0)) return MatrixXd::Zero(placebos_, rank());
  const Eigen::VectorXf scaled = (freed / size).cast<float>();
  const VectorXd all = size * (placebo_.transpose() * scaled).cast<double>();
  return Eigen::Map<const MatrixXd>(all.data(), rank(), placebos_).transpose();
}

}  // namespace mle
