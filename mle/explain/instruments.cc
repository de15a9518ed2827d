#include "mle/explain/instruments.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "Eigen/QR"
#include "Eigen/SVD"
#include "absl/status/status.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Functions of each signal, fewer where there are few rows.
constexpr Index kMostLaguerre = MovesBank::kMostFunctions;
constexpr Index kFewestLaguerre = MovesBank::kFewestFunctions;
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

absl::Status NothingMoves() {
  return absl::FailedPreconditionError("no set point and no input moves");
}

int MovesOf(const RecordSignal& signal) {
  int moves = 0;
  for (const VectorXd& values : signal) {
    for (Index k = 1; k < values.size(); ++k) {
      if (values[k] != values[k - 1]) ++moves;
    }
  }
  return moves;
}

// Signals that move, and whether set points are among them.
struct Signals {
  std::vector<RecordSignal> moving;
  bool by_set_points = false;
};

// Set points and measured disturbances; where no set point moves, all inputs.
Signals SignalsOf(const ProcessModel& model, const ExplainedOutput& output) {
  const std::vector<Record>& records = output.records();
  Signals signals;
  const auto add = [&](auto row_of) {
    RecordSignal signal;
    for (const Record& record : records) {
      signal.push_back(Filled(row_of(record).transpose()));
    }
    if (RangeOf(signal) > 0.0) signals.moving.push_back(std::move(signal));
  };
  const bool set_points = std::all_of(
      records.begin(), records.end(),
      [](const Record& record) { return record.set_points.rows() > 0; });
  if (set_points) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      add([&](const Record& record) { return record.set_points.row(i); });
    }
  }
  signals.by_set_points = !signals.moving.empty();
  for (const int j : output.possible_inputs()) {
    const bool measured = model.inputs()[j].role == InputRole::kDisturbance;
    if (signals.by_set_points && !measured) continue;
    add([&](const Record& record) { return record.inputs.row(j); });
  }
  return signals;
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
  const Index most = std::clamp(rows / (kLeastRows * kMostLaguerre),
                                kMostLaguerre, kMostColumns / kFewestLaguerre);
  if (static_cast<Index>(signals.size()) <= most) return;
  MatrixXd responses(rows, static_cast<Index>(output.inputs().size()));
  for (Index c = 0; c < responses.cols(); ++c) {
    responses.col(c) =
        output.ContributionOf(output.inputs()[static_cast<std::size_t>(c)]);
  }
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < signals.size(); ++s) {
    MatrixXd columns = BankOf(output, {signals[s]}, kMostLaguerre).Columns(0.0);
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

// Signals in halves in place of whole ones, if there are rows and columns for
// all functions of each.
void PartWhereThereIsRoom(Index rows, std::vector<RecordSignal>& signals) {
  std::vector<RecordSignal> halves = InHalves(signals);
  const Index columns = kMostLaguerre * static_cast<Index>(halves.size());
  if (rows >= kLeastRows * columns && columns <= kMostColumns) {
    signals = std::move(halves);
  }
}

// Each `every`-th row of orthonormal columns, made orthonormal again.
MatrixXd Thinned(const MatrixXd& columns, int every) {
  if (every == 1) return columns;
  MatrixXd thinned((columns.rows() + every - 1) / every, columns.cols());
  for (Index i = 0; i < thinned.rows(); ++i) {
    thinned.row(i) = columns.row(i * every);
  }
  const Eigen::HouseholderQR<MatrixXd> qr(thinned);
  return qr.householderQ() * MatrixXd::Identity(thinned.rows(), thinned.cols());
}

// BᵀB of columns B, freed of the orthonormal columns `free`.
MatrixXd FreedProducts(MatrixXd columns, const MatrixXd& free) {
  columns -= free * (free.transpose() * columns);
  MatrixXd products = MatrixXd::Zero(columns.cols(), columns.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
  return products.selfadjointView<Eigen::Lower>();
}

}  // namespace

absl::StatusOr<Instruments> Instruments::Create(const ProcessModel& model,
                                                const ExplainedOutput& output) {
  Instruments made;
  Signals found = SignalsOf(model, output);
  std::vector<RecordSignal>& signals = found.moving;
  if (signals.empty()) return NothingMoves();
  made.by_set_points_ = found.by_set_points;
  for (const RecordSignal& signal : signals) made.moves_ += MovesOf(signal);
  made.free_ = FreeColumns(output);
  MostMoving(output, made.free_, signals);
  const auto rows = static_cast<Index>(output.rows().size());
  const auto whole = static_cast<double>(signals.size());
  PartWhereThereIsRoom(rows, signals);
  const auto count = static_cast<Index>(signals.size());
  made.parts_ = static_cast<double>(count) / whole;
  const Index functions = std::min(
      {kMostLaguerre, rows / (kLeastRows * count), kMostColumns / count});
  if (functions < kFewestLaguerre) {
    return absl::FailedPreconditionError("the records are too short");
  }
  made.bank_ = BankOf(output, signals, functions);
  MLE_RETURN_IF_ERROR(made.FindBasis());
  made.FindPlacebos(output);
  return made;
}

absl::Status Instruments::FindBasis() {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      FreedProducts(bank_.Columns(0.0), free_));
  const VectorXd& squares = eigen.eigenvalues();  // in increasing order
  const Index n = squares.size();
  if (!(squares[n - 1] > 0.0)) return NothingMoves();
  Index rank = 0;
  while (rank < n && squares[n - 1 - rank] >
                         kLeastDirection * kLeastDirection * squares[n - 1]) {
    ++rank;
  }
  to_basis_ = eigen.eigenvectors().rightCols(rank) *
              squares.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  return absl::OkStatus();
}

void Instruments::FindPlacebos(const ExplainedOutput& output) {
  const auto rows = static_cast<int>(output.rows().size());
  const double row_time = output.samples_a_row() * output.sample_time();
  const int every = std::max(
      1, std::min(
             rows / kLengthRows,
             static_cast<int>(output.tau() / (kLengthRowsPerTau * row_time))));
  const MatrixXd free = Thinned(free_, every);
  for (int s = 1; s <= kPlacebos; ++s) {
    shares_.push_back(s / (kPlacebos + 1.0));
    // Made orthonormal by the smallest change, so that each direction stays
    // that of the same moves.
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
        static_cast<double>(every) * to_basis_.transpose() *
        FreedProducts(bank_.Columns(shares_.back(), every), free) * to_basis_);
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

std::function<VectorXd(const VectorXd&)> Instruments::ProjectionOf(
    const VectorXd& weights) const {
  if ((weights.array() == 1.0).all()) {
    return [this](const VectorXd& e) { return Project(e); };
  }
  const MatrixXd weighted = weights.asDiagonal() * free_;
  MatrixXd products = weighted.transpose() * free_;
  products.diagonal().array() += 1e-9;
  return [this, weights, weighted,
          factors = products.ldlt()](const VectorXd& e) {
    const VectorXd left = e - free_ * factors.solve(weighted.transpose() * e);
    return Project(left.cwiseProduct(weights));
  };
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
