#include "mle/explain/instruments.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "Eigen/QR"
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
// Functions of all instruments at most; more signals have fewer each.
constexpr Index kMostColumns = 72;
// A singular value above this share of the largest counts as a direction of its
// own: the first for instruments, the second for offsets, ramps and free
// responses.
constexpr double kLeastDirection = 1e-3;
constexpr double kLeastFree = 1e-6;
// Fewer rows than this for each function of the instruments tell too little of
// chance.
constexpr Index kLeastRows = 8;
// Rows that the lengths of placebos are taken from: at least this many, and
// this many of τ.
constexpr int kLengthRows = 1500;
constexpr double kLengthRowsPerTau = 5.0;
// Squared lengths of a placebo's columns count as at least this share of the
// largest.
constexpr double kLeastPlacebo = 1e-2;
// Time constants nearer than this factor leave the same free response.
constexpr double kSameLag = 1.3;

int MovesOf(const RecordSignal& signal) {
  int moves = 0;
  for (const VectorXd& values : signal) {
    for (Index k = 1; k < values.size(); ++k) {
      if (values[k] != values[k - 1]) ++moves;
    }
  }
  return moves;
}

// The moves of the first half of all moves, and the others.
std::vector<RecordSignal> Halves(const RecordSignal& signal) {
  const int half = MovesOf(signal) / 2;
  std::vector<RecordSignal> halves(2, signal);
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

MovesBank BankOf(const ExplainedOutput& output,
                 const std::vector<RecordSignal>& signals, Index functions) {
  return {output, signals, static_cast<int>(functions),
          kLaguerreTime * output.tau()};
}

// Leaves of the signals as many as have room, those that move the responses of
// the elements most, by the model.
void MostMoving(const ExplainedOutput& output, const MatrixXd& free,
                std::vector<RecordSignal>& signals) {
  const auto rows = static_cast<Index>(output.rows().size());
  const Index most = std::clamp(rows / (kLeastRows * kLaguerre), kLaguerre,
                                kMostColumns / kFewestLaguerre);
  if (static_cast<Index>(signals.size()) <= most) return;
  MatrixXd responses(rows, static_cast<Index>(output.inputs().size()));
  for (Index c = 0; c < responses.cols(); ++c) {
    responses.col(c) =
        output.ContributionOf(output.inputs()[static_cast<std::size_t>(c)]);
  }
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < signals.size(); ++s) {
    MatrixXd columns = BankOf(output, {signals[s]}, kLaguerre).Columns(0.0);
    columns -= free * (free.transpose() * columns);
    const Eigen::HouseholderQR<MatrixXd> qr(columns);
    const MatrixXd driven = qr.householderQ().transpose() * responses;
    order.emplace_back(-driven.topRows(columns.cols()).squaredNorm(), s);
  }
  std::stable_sort(order.begin(), order.end());
  order.resize(static_cast<std::size_t>(most));
  std::vector<RecordSignal> moving;
  for (const auto& [less, index] : order) {
    moving.push_back(std::move(signals[index]));
  }
  signals = std::move(moving);
}

std::vector<RecordSignal> InHalves(const std::vector<RecordSignal>& signals) {
  std::vector<RecordSignal> halves;
  for (const RecordSignal& signal : signals) {
    if (MovesOf(signal) < kFewestMoves) {
      halves.push_back(signal);
      continue;
    }
    for (RecordSignal& half : Halves(signal)) halves.push_back(std::move(half));
  }
  return halves;
}

}  // namespace

absl::StatusOr<Instruments> Instruments::Create(const ProcessModel& model,
                                                const ExplainedOutput& output) {
  Instruments made;
  const std::vector<Record>& records = output.records();
  std::vector<RecordSignal> signals;
  const auto add = [&](auto row_of) {
    RecordSignal signal;
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
  for (const RecordSignal& signal : signals) made.moves_ += MovesOf(signal);
  made.free_ = FreeColumns(output);
  MostMoving(output, made.free_, signals);
  const Index rows = static_cast<Index>(output.rows().size());
  std::vector<RecordSignal> halves = InHalves(signals);
  const auto of_halves = kLaguerre * static_cast<Index>(halves.size());
  if (rows >= kLeastRows * of_halves && of_halves <= kMostColumns) {
    made.parts_ = static_cast<double>(halves.size()) /
                  static_cast<double>(signals.size());
    signals = std::move(halves);
  }
  const auto count = static_cast<Index>(signals.size());
  const Index functions =
      std::min({kLaguerre, rows / (kLeastRows * count), kMostColumns / count});
  if (functions < kFewestLaguerre) {
    return absl::FailedPreconditionError("the records are too short");
  }
  made.bank_ = BankOf(output, signals, functions);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(made.Products(0.0, 1));
  const VectorXd& squares = eigen.eigenvalues();  // in increasing order
  const Index n = squares.size();
  if (!(squares[n - 1] > 0.0)) {
    return absl::FailedPreconditionError("no set point and no input moves");
  }
  Index rank = 0;
  while (rank < n && squares[n - 1 - rank] >
                         kLeastDirection * kLeastDirection * squares[n - 1]) {
    ++rank;
  }
  made.to_basis_ = eigen.eigenvectors().rightCols(rank) *
                   squares.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  made.FindPlacebos(output);
  return made;
}

MatrixXd Instruments::Products(double share, int every) const {
  MatrixXd columns = bank_.Columns(share, every);
  MatrixXd free(columns.rows(), free_.cols());
  for (Index i = 0; i < free.rows(); ++i) free.row(i) = free_.row(i * every);
  const Eigen::HouseholderQR<MatrixXd> qr(free);
  free = qr.householderQ() * MatrixXd::Identity(free.rows(), free.cols());
  columns -= free * (free.transpose() * columns);
  MatrixXd products = MatrixXd::Zero(columns.cols(), columns.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(
      columns.transpose(), static_cast<double>(every));
  return products.selfadjointView<Eigen::Lower>();
}

void Instruments::FindPlacebos(const ExplainedOutput& output) {
  const auto rows = static_cast<int>(output.rows().size());
  const double row_time = output.samples_a_row() * output.sample_time();
  const int every = std::max(
      1, std::min(
             rows / kLengthRows,
             static_cast<int>(output.tau() / (kLengthRowsPerTau * row_time))));
  for (int s = 1; s <= kPlacebos; ++s) {
    shares_.push_back(s / (kPlacebos + 1.0));
    // Made orthonormal by the smallest change, so that each direction stays
    // that of the same moves.
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
        to_basis_.transpose() * Products(shares_.back(), every) * to_basis_);
    const VectorXd lengths = eigen.eigenvalues().cwiseMax(
        kLeastPlacebo * eigen.eigenvalues().maxCoeff());
    to_placebo_.push_back(to_basis_ * eigen.eigenvectors() *
                          lengths.cwiseSqrt().cwiseInverse().asDiagonal() *
                          eigen.eigenvectors().transpose());
  }
}

VectorXd Instruments::Project(const VectorXd& e) const {
  return to_basis_.transpose() * bank_.Project(Freed(e), {0.0});
}

VectorXd Instruments::Undriven(const VectorXd& e) const {
  const VectorXd driven = bank_.Columns(0.0) * (to_basis_ * Project(e));
  return Freed(e - driven);
}

VectorXd Instruments::Project(const VectorXd& e,
                              const VectorXd& weights) const {
  if ((weights.array() == 1.0).all()) return Project(e);
  const MatrixXd weighted = weights.asDiagonal() * free_;
  MatrixXd products = weighted.transpose() * free_;
  products.diagonal().array() += 1e-9;
  const VectorXd left =
      e - free_ * products.ldlt().solve(weighted.transpose() * e);
  return Project(left.cwiseProduct(weights));
}

MatrixXd Instruments::ProjectPlacebos(const VectorXd& e) const {
  const MatrixXd products = bank_.Project(Freed(e), shares_);
  MatrixXd placebos(products.cols(), rank());
  for (Index s = 0; s < placebos.rows(); ++s) {
    placebos.row(s) =
        (to_placebo_[static_cast<std::size_t>(s)].transpose() * products.col(s))
            .transpose();
  }
  return placebos;
}

}  // namespace mle
